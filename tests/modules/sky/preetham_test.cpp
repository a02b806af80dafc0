#include <alpenglow/sky/preetham.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/colour.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

glm::dvec3 towards(double altitude_deg, double azimuth_deg) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return {std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a)};
}

TEST(Preetham, ZenithHasTheZenithValues) {
    for (double turbidity : {1.7, 2.5, 6.0, 10.0}) {
        for (double altitude : {0.0, 10.0, 45.0, 89.0}) {
            const auto sky = make_preetham(towards(altitude, 30.0), turbidity);
            const glm::dvec3 zenith = luminance_chromaticity(sky, glm::dvec3(0, 0, 1));
            EXPECT_NEAR(zenith.x / sky.zenith_Yxy.x, 1.0, 1e-12);
            EXPECT_NEAR(zenith.y, sky.zenith_Yxy.y, 1e-12);
            EXPECT_NEAR(zenith.z, sky.zenith_Yxy.z, 1e-12);
        }
    }
}

// Preetham et al. 1999, eq. for Y_z at turbidity 2 and the sun 30 degrees from the zenith, by hand:
// chi = (4/9 - 2/120)(pi - pi/3) = 0.895936, Y_z = 3.1196 tan chi - 0.4310 + 2.4192 = 5.884 kcd/m^2.
TEST(Preetham, ZenithLuminanceByHand) {
    EXPECT_NEAR(make_preetham(towards(60.0, 0.0), 2.0).zenith_Yxy.x, 5884.0, 6.0);
}

TEST(Preetham, BlueAtTheZenithAtNoonInClearAir) {
    const auto sky = make_preetham(towards(60.0, 180.0), 2.5);
    const glm::dvec3 rgb = radiance(sky, glm::dvec3(0, 0, 1));
    EXPECT_GT(rgb.z, 1.5 * rgb.x);
    EXPECT_GT(rgb.z, rgb.y);
}

TEST(Preetham, WarmAroundALowSun) {
    const auto sky = make_preetham(towards(3.0, 270.0), 3.0);
    const glm::dvec3 rgb = radiance(sky, towards(2.0, 275.0));
    EXPECT_GT(rgb.x, 1.2 * rgb.z);
}

TEST(Preetham, HorizonBrighterThanZenith) {
    for (double altitude : {10.0, 30.0, 50.0}) {
        const auto sky = make_preetham(towards(altitude, 180.0), 2.5);
        EXPECT_GT(luminance_chromaticity(sky, towards(1.0, 270.0)).x,
                  luminance_chromaticity(sky, glm::dvec3(0, 0, 1)).x);
    }
}

TEST(Preetham, HazeWhitens) {
    const auto saturation = [](double turbidity) {
        const glm::dvec3 rgb = radiance(make_preetham(towards(50.0, 0.0), turbidity), glm::dvec3(0, 0, 1));
        return rgb.z / rgb.x;
    };
    EXPECT_GT(saturation(2.0), saturation(4.0));
    EXPECT_GT(saturation(4.0), saturation(8.0));
}

TEST(Preetham, MirrorSymmetricAboutTheSunsMeridianAndRotates) {
    const auto sky = make_preetham(towards(35.0, 40.0), 3.0);
    const auto turned = make_preetham(towards(35.0, 100.0), 3.0);
    for (double altitude : {1.0, 20.0, 70.0}) {
        for (double offset : {10.0, 60.0, 130.0}) {
            const double left = luminance_chromaticity(sky, towards(altitude, 40.0 - offset)).x;
            const double right = luminance_chromaticity(sky, towards(altitude, 40.0 + offset)).x;
            EXPECT_NEAR(left / right, 1.0, 1e-12);
            EXPECT_NEAR(luminance_chromaticity(turned, towards(altitude, 100.0 + offset)).x / right, 1.0, 1e-12);
        }
    }
}

TEST(Preetham, BelowTheHorizonHoldsTheHorizon) {
    const auto sky = make_preetham(towards(20.0, 0.0), 3.0);
    const glm::dvec3 at = luminance_chromaticity(sky, towards(0.0, 90.0));
    const glm::dvec3 just = luminance_chromaticity(sky, towards(-1e-7 / degree_rad, 90.0));
    EXPECT_NEAR(at.x, just.x, 1e-3 * at.x);
    // The sun below the horizon stands on it.
    EXPECT_EQ(make_preetham(towards(-20.0, 90.0), 3.0).zenith_Yxy.x,
              make_preetham(glm::dvec3(1, 0, 0), 3.0).zenith_Yxy.x);
}

TEST(Preetham, FloatKeepsToDouble) {
    double worst = 0.0;
    for (double turbidity : {1.7, 1.8, 2.0, 2.5, 4.0, 7.0, 10.0}) {
        for (double sun : {0.0, 1e-5, 1.0, 20.0, 60.0, 89.99, 90.0}) {
            const glm::dvec3 to_sun = towards(sun, 123.0);
            const auto reference = make_preetham(glm::dvec3(glm::vec3(to_sun)), double(float(turbidity)));
            const auto sky = make_preetham(glm::vec3(to_sun), float(turbidity));
            for (double altitude = -5.0; altitude <= 90.0; altitude += 2.5) {
                for (double azimuth = 0.0; azimuth < 360.0; azimuth += 13.0) {
                    const glm::vec3 direction(towards(altitude, azimuth));
                    const glm::dvec3 want = luminance_chromaticity(reference, glm::dvec3(direction));
                    const glm::dvec3 got(luminance_chromaticity(sky, direction));
                    for (int k = 0; k < 3; ++k) {
                        worst = std::max(worst, std::abs(got[k] / want[k] - 1.0));
                    }
                }
            }
        }
    }
    EXPECT_LT(worst, 2e-5);
}

} // namespace
} // namespace alpenglow::sky
