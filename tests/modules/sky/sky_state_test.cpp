#include <alpenglow/sky/sky_state.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/colour.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

glm::vec3 towards(double altitude_deg, double azimuth_deg) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return glm::vec3(glm::dvec3(std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a)));
}

struct Light {
    std::array<glm::vec3, 49> sky;
    double sun, moon, horizontal;
};

Light light_of(const SkyState& state) {
    Light light{};
    project_sky_state(state, nullptr, 7, light.sky);
    light.sun = luminance(state.sun_illuminance_lux);
    light.moon = luminance(state.moon_illuminance_lux);
    // Irradiance on level ground from the zonal terms.
    light.horizontal =
        0.886227 * luminance(light.sky[0]) + 1.023327 * luminance(light.sky[2]) + 0.495416 * luminance(light.sky[6]);
    return light;
}

struct Errors {
    double sky, sun, moon;
};

Errors errors(const Light& kept, const Light& now) {
    double difference = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < now.sky.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(kept.sky[i]) - glm::dvec3(now.sky[i]);
        difference += glm::dot(d, d);
        norm += glm::dot(glm::dvec3(now.sky[i]), glm::dvec3(now.sky[i]));
    }
    return {std::sqrt(difference / norm), std::abs(kept.sun - now.sun) / (now.sun + now.horizontal),
            std::abs(kept.moon - now.moon) / (now.moon + now.horizontal)};
}

// Sweep the sun, keep the state for as long as the bound allows, recompute in secret: the true error never exceeds it.
TEST(SkyState, DriftBoundHolds) {
    double tightest = 0.0;
    for (float turbidity : {1.7F, 2.5F, 5.0F, 10.0F}) {
        Atmosphere atmosphere;
        atmosphere.turbidity = turbidity;
        for (double limit : {0.005, 0.1}) {
            CelestialState celestial;
            SkyState kept;
            Light kept_light{};
            double altitude = -20.0;
            double azimuth = 40.0;
            while (altitude < 90.0) {
                celestial.to_sun = towards(altitude, azimuth);
                celestial.to_moon = towards(-altitude * 0.5, azimuth + 150.0);
                double bound = drift_bound(kept, celestial, atmosphere);
                if (!(bound <= limit)) {
                    kept = make_sky_state(celestial, atmosphere);
                    kept.revision = 1;
                    kept_light = light_of(kept);
                    bound = 0.0;
                }
                const Light now = light_of(make_sky_state(celestial, atmosphere));
                const Errors e = errors(kept_light, now);
                const double float_noise = 2e-6;
                EXPECT_LE(e.sky, bound + float_noise) << turbidity << " sun at " << altitude;
                EXPECT_LE(e.sun, bound + float_noise) << turbidity << " sun at " << altitude;
                if (altitude < 0.0) {
                    EXPECT_LE(e.moon, bound + float_noise) << turbidity << " sun at " << altitude;
                }
                if (bound > 0.0) {
                    tightest = std::max({tightest, e.sky / bound, e.sun / bound});
                }
                const double step = (altitude < 12.0 ? 0.0131 : 0.31) * (limit > 0.05 ? 6.0 : 1.0);
                altitude += step;
                azimuth += 0.7 * step;
            }
        }
    }
    // A bound that is never approached wastes work.
    EXPECT_GT(tightest, 0.4);
}

TEST(SkyState, OtherAirIsNeverWithinTheBound) {
    const CelestialState celestial;
    Atmosphere atmosphere;
    SkyState state = make_sky_state(celestial, atmosphere);
    EXPECT_EQ(drift_bound(state, celestial, atmosphere), std::numeric_limits<double>::infinity());
    state.revision = 1;
    EXPECT_EQ(drift_bound(state, celestial, atmosphere), 0.0);
    atmosphere.turbidity = 3.0F;
    EXPECT_EQ(drift_bound(state, celestial, atmosphere), std::numeric_limits<double>::infinity());
}

TEST(SkyState, CheckNamesTheField) {
    Atmosphere atmosphere;
    EXPECT_TRUE(check(atmosphere).has_value());
    atmosphere.turbidity = 0.5F;
    EXPECT_NE(check(atmosphere).error().message().find("turbidity"), std::string::npos);
    atmosphere.turbidity = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(check(atmosphere).has_value());
    atmosphere = {};
    atmosphere.ground_albedo.y = 1.5F;
    EXPECT_NE(check(atmosphere).error().message().find("albedo"), std::string::npos);
}

// The day's illuminance on level ground, sun and sky together: blinding noon, civil twilight, moonless night, and no
// step between minutes that the physics does not have.
TEST(SkyState, ADayOfLight) {
    const Atmosphere atmosphere;
    CelestialState celestial;
    celestial.to_moon = towards(-40.0, 0.0);
    double before = 0.0;
    for (double altitude = -25.0; altitude <= 66.0; altitude += 0.02) {
        celestial.to_sun = towards(altitude, 120.0);
        const SkyState state = make_sky_state(celestial, atmosphere);
        const Light light = light_of(state);
        const double total = light.horizontal + light.sun * std::max(std::sin(altitude * degree_rad), 0.0);
        if (before > 0.0) {
            EXPECT_GE(total, before * 0.9999) << altitude;
            EXPECT_LE(total, before * 1.05) << altitude;
        }
        before = total;
    }
    EXPECT_GT(before, 9e4);
    EXPECT_LT(before, 1.4e5);
    celestial.to_sun = towards(-30.0, 0.0);
    const double night = light_of(make_sky_state(celestial, atmosphere)).horizontal;
    EXPECT_GT(night, 2e-4);
    EXPECT_LT(night, 2e-3);
    celestial.to_moon = towards(60.0, 180.0);
    const SkyState moonlit = make_sky_state(celestial, atmosphere);
    EXPECT_GT(luminance(moonlit.moon_illuminance_lux), 0.15);
    // Measured full-moon skies: 0.005 to 0.02 cd/m^2. Brighter around the moon than away from it.
    const std::array<glm::vec3, 3> directions{towards(90.0, 0.0), towards(62.0, 180.0), towards(40.0, 0.0)};
    std::array<glm::vec3, 3> radiance{};
    sky_radiance(moonlit, nullptr, directions, radiance);
    EXPECT_GT(luminance(radiance[0]), 3e-3);
    EXPECT_LT(luminance(radiance[0]), 3e-2);
    EXPECT_GT(luminance(radiance[1]), 1.5 * luminance(radiance[2]));
}

TEST(SkyState, RadianceGoesWithItsSh) {
    Atmosphere atmosphere;
    CelestialState celestial;
    celestial.to_sun = towards(40.0, 200.0);
    const SkyState state = make_sky_state(celestial, atmosphere);
    const PreethamSky<float> model = preetham_of(state);
    const PreethamSky<float> want = make_preetham(celestial.to_sun, atmosphere.turbidity);
    EXPECT_EQ(radiance(model, towards(30.0, 10.0)), radiance(want, towards(30.0, 10.0)));
    const glm::vec3 at = sky_radiance(state, model, towards(30.0, 10.0));
    EXPECT_NEAR(luminance(at), luminance(radiance(want, towards(30.0, 10.0))), 1e-2F);
}

} // namespace
} // namespace alpenglow::sky
