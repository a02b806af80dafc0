// Every input to its ends and past them, with floating-point traps on.
#include <fp_traps.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/preetham.hpp>
#include <alpenglow/sky/sky_sh.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/sky/sun_light.hpp>
#include <alpenglow/sky/twilight.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

using SkyStress = test::StressTest;

std::vector<glm::dvec3> directions() {
    std::vector<glm::dvec3> out{{0, 0, 1},    {0, 0, -1},    {1, 0, 0},    {0, -1, 0},
                                {1, 0, 1e-7}, {1, 0, -1e-7}, {1, 1e-20, 0}};
    for (double altitude : {-89.9999999, -90.0 + 1e-7, -30.0, -1e-7, 0.0, 1e-7, 0.1, 5.0, 45.0, 89.9999999}) {
        for (double azimuth : {0.0, 90.0, 123.0, 359.9999999}) {
            const double a = altitude * degree_rad;
            const double z = azimuth * degree_rad;
            out.emplace_back(std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a));
        }
    }
    return out;
}

bool valid(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && v.x >= 0 && v.y >= 0 && v.z >= 0;
}

TEST_F(SkyStress, PreethamIsFiniteAndNotNegativeEverywhere) {
    for (const glm::dvec3& sun : directions()) {
        for (double turbidity : {-1e30, 0.0, 1.0, 1.64, 1.7, 2.0, 6.0, 10.0, 12.0, 1e30}) {
            const auto sky = make_preetham(sun, turbidity);
            const auto skyf = make_preetham(glm::vec3(sun), static_cast<float>(turbidity));
            for (glm::dvec3 direction : directions()) {
                ASSERT_TRUE(valid(radiance(sky, direction)));
                ASSERT_TRUE(valid(glm::dvec3(radiance(skyf, glm::vec3(direction)))));
                // A hair over unit length, and exactly at the sun and opposite to it.
                ASSERT_TRUE(valid(radiance(sky, direction * (1.0 + 1e-15))));
            }
            ASSERT_TRUE(valid(radiance(sky, sun)));
            ASSERT_TRUE(valid(radiance(sky, -sun)));
            ASSERT_TRUE(valid(glm::dvec3(radiance(skyf, glm::vec3(sun)))));
            ASSERT_TRUE(valid(radiance(sky, glm::dvec3(0.0))));
            ASSERT_TRUE(valid(radiance(sky, glm::dvec3(1e300, -1e300, 1e300))));
        }
    }
}

TEST_F(SkyStress, DirectLight) {
    for (double altitude = -1.7; altitude <= 1.7; altitude += 0.013) {
        for (double turbidity : {-1.0, 1.0, 2.0, 10.0, 1e9}) {
            for (double radius : {0.0, 4.65e-3, 1.0}) {
                ASSERT_TRUE(valid(sun_illuminance_lux(altitude, radius, 1.0, {turbidity, 0.35, 2.0})));
                ASSERT_TRUE(
                    valid(moon_illuminance_lux(altitude, radius, 3.8e8, altitude * 3.0, {turbidity, 5.0, -1.0})));
            }
        }
        ASSERT_GE(twilight_fade(altitude), 0.0);
        ASSERT_LE(twilight_fade(altitude), 1.0);
        ASSERT_TRUE(std::isfinite(relative_optical_length(altitude)));
        ASSERT_TRUE(std::isfinite(refraction_rad(altitude)));
    }
    for (double phase : {-10.0, -1e-9, 0.0, 1e-9, pi - 1e-9, pi, 100.0}) {
        ASSERT_GE(moon_phase_factor(phase), 0.0);
        ASSERT_GE(lommel_seeliger_phase_factor(phase), 0.0);
    }
}

TEST_F(SkyStress, StatesAndTheirSh) {
    for (const glm::dvec3& sun : directions()) {
        for (float turbidity : {1.7F, 10.0F}) {
            CelestialState celestial;
            celestial.to_sun = glm::vec3(sun);
            celestial.to_moon = glm::vec3(-sun);
            Atmosphere atmosphere;
            atmosphere.turbidity = turbidity;
            const SkyState state = make_sky_state(celestial, atmosphere);
            ASSERT_TRUE(valid(glm::dvec3(state.sun_illuminance_lux)));
            ASSERT_TRUE(valid(glm::dvec3(state.moon_illuminance_lux)));
            ASSERT_TRUE(valid(glm::dvec3(state.night_radiance_cd_m2)));
            std::array<glm::vec3, 49> c{};
            project_sky_state(state, nullptr, 7, c);
            ASSERT_TRUE(valid(glm::dvec3(c[0])));
            for (const glm::vec3& value : c) {
                ASSERT_TRUE(std::isfinite(value.x + value.y + value.z));
            }
        }
    }
}

} // namespace
} // namespace alpenglow::sky
