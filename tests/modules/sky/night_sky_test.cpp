#include <alpenglow/sky/night_sky.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

glm::vec3 towards(double altitude_deg, double azimuth_deg) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return glm::vec3(glm::dvec3(std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a)));
}

constexpr float distance_m = 3.844e8F;

double brightness(const NightSky& sky, double altitude_deg, double azimuth_deg) {
    return luminance(night_radiance(sky, towards(altitude_deg, azimuth_deg)));
}

// Krisciunas and Schaefer's formula as printed, in nanolamberts, for the air of that turbidity.
TEST(NightSky, MoonlightAsPrinted) {
    NightSky sky = make_night_sky(towards(60.0, 0.0), distance_m, 0.0F, 2.0F);
    sky.floor_cd_m2 = glm::vec3(0.0F);
    const double k = sky.extinction / (0.4 * std::log(10.0));
    for (double altitude : {30.0, 60.0, 80.0}) {
        for (double azimuth : {0.0, 70.0, 180.0}) {
            const glm::dvec3 v(towards(altitude, azimuth));
            const double rho = std::acos(std::min(glm::dot(v, glm::dvec3(sky.to_moon)), 1.0)) / degree_rad;
            const double c = std::cos(rho * degree_rad);
            const auto x = [](double altitude_deg) {
                const double s = std::cos(altitude_deg * degree_rad);
                return 1.0 / std::sqrt(1.0 - 0.96 * s * s);
            };
            const double f = std::pow(10.0, 5.36) * (1.06 + c * c) + std::pow(10.0, 6.15 - rho / 40.0);
            const double nl = f * std::pow(10.0, -0.4 * 3.84) * std::pow(10.0, -0.4 * k * x(60.0)) *
                              (1.0 - std::pow(10.0, -0.4 * k * x(altitude)));
            // Luminance through the colours holds but for the weights' rounding.
            EXPECT_NEAR(brightness(sky, altitude, azimuth) / (nl * 1e-5 / pi), 1.0, 2e-3);
        }
    }
}

// What observers report: a full moon high up makes a sky of some millicandela, tens of times the moonless one; a
// crescent hardly shows.
TEST(NightSky, AsBrightAsNightsAre) {
    const NightSky full = make_night_sky(towards(60.0, 0.0), distance_m, 0.0F, 2.0F);
    EXPECT_GT(brightness(full, 60.0, 180.0), 1e-3);
    EXPECT_LT(brightness(full, 60.0, 180.0), 1e-2);
    const NightSky crescent = make_night_sky(towards(60.0, 0.0), distance_m, 2.4F, 2.0F);
    const NightSky none = make_night_sky(towards(-40.0, 0.0), distance_m, 0.0F, 2.0F);
    EXPECT_LT(brightness(crescent, 60.0, 180.0), 1.5 * brightness(none, 60.0, 180.0));
    EXPECT_NEAR(brightness(none, 90.0, 0.0), 2.2e-4, 1e-5);
}

TEST(NightSky, HasItsGradients) {
    const NightSky moonlit = make_night_sky(towards(40.0, 0.0), distance_m, 0.3F, 3.0F);
    EXPECT_GT(brightness(moonlit, 50.0, 0.0), 1.5 * brightness(moonlit, 50.0, 180.0));  // brighter about the moon
    EXPECT_GT(brightness(moonlit, 5.0, 120.0), 1.5 * brightness(moonlit, 85.0, 120.0)); // and at the horizon
    const NightSky dark = make_night_sky(towards(-40.0, 0.0), distance_m, 0.0F, 2.0F);
    double before = brightness(dark, 90.0, 0.0);
    for (double altitude : {70.0, 50.0, 30.0, 20.0}) {
        const double now = brightness(dark, altitude, 0.0);
        EXPECT_GT(now, before);
        before = now;
    }
    // Blue away from the moon.
    const glm::vec3 away = night_radiance(moonlit, towards(50.0, 180.0));
    EXPECT_GT(away.z, away.x);
}

// Across the horizon without a step, and gone 18 degrees below it.
TEST(NightSky, MoonSetsSmoothly) {
    double before = brightness(make_night_sky(towards(3.0, 0.0), distance_m, 0.0F, 2.5F), 30.0, 60.0);
    for (double altitude = 3.0; altitude > -20.0; altitude -= 0.02) {
        const double now = brightness(make_night_sky(towards(altitude, 0.0), distance_m, 0.0F, 2.5F), 30.0, 60.0);
        EXPECT_LE(now, before * 1.0001);
        EXPECT_GT(now, before * 0.97) << altitude;
        before = now;
    }
    const NightSky gone = make_night_sky(towards(-19.0, 0.0), distance_m, 0.0F, 2.5F);
    EXPECT_EQ(gone.molecules, glm::vec3(0.0F));
}

TEST(NightSky, ShIsTheProjection) {
    double worst = 0.0;
    for (double altitude : {-5.0, 2.0, 30.0, 75.0, 90.0, -60.0}) {
        for (float turbidity : {2.0F, 8.0F}) {
            const NightSky sky = make_night_sky(towards(altitude, 0.0), distance_m, 0.4F, turbidity);
            // For a moon towards +X, as the quadrature wants it.
            NightSky turned = sky;
            const double z = sky.to_moon.z;
            turned.to_moon = glm::vec3(std::sqrt(std::max(1.0 - z * z, 0.0)), 0.0F, z);
            std::array<glm::dvec3, 49> want{};
            project_symmetric_sky([&](const glm::dvec3& v) { return glm::dvec3(night_radiance(turned, glm::vec3(v))); },
                                  0.5 * pi - altitude * degree_rad, 7, {24, 32}, want);
            for (int bands : {1, 3, 5, 7}) {
                std::array<glm::vec3, 49> got{};
                project_night_sky(turned, bands, got);
                double difference = 0.0;
                double norm = 0.0;
                for (std::size_t i = 0; i < static_cast<std::size_t>(bands * bands); ++i) {
                    const glm::dvec3 d = glm::dvec3(got[i]) - want[i];
                    difference += glm::dot(d, d);
                    norm += glm::dot(want[i], want[i]);
                }
                worst = std::max(worst, std::sqrt(difference / norm));
            }
        }
    }
    std::printf("night sky's SH: worst relative error %.5f\n", worst);
    EXPECT_LT(worst, 0.011); // the cusp at the moon, cut off after 8 bands
}

TEST(NightSky, ShTurnsWithTheMoon) {
    std::array<glm::vec3, 49> c{};
    const NightSky sky = make_night_sky(towards(30.0, 200.0), distance_m, 0.2F, 2.5F);
    project_night_sky(sky, 7, c);
    NightSky turned = sky;
    turned.to_moon = towards(30.0, 90.0);
    std::array<glm::vec3, 49> d{};
    project_night_sky(turned, 7, d);
    for (int l = 0; l < 7; ++l) { // a rotation about the zenith keeps the zonal terms and each pair's length
        const auto middle = static_cast<std::size_t>(l * (l + 1));
        EXPECT_LT(glm::length(c[middle] - d[middle]), 1e-5F * glm::length(c[0]));
        for (std::size_t m = 1; m <= static_cast<std::size_t>(l); ++m) {
            const float a = std::hypot(c[middle + m].y, c[middle - m].y);
            const float b = std::hypot(d[middle + m].y, d[middle - m].y);
            EXPECT_NEAR(a, b, 1e-5F * c[0].y);
        }
    }
}

} // namespace
} // namespace alpenglow::sky
