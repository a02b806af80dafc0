// The closed forms to their ends and past them, with floating-point traps on.
#include <fp_traps.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/night_sky.hpp>
#include <alpenglow/sky/sun_light.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

using SkyModelsStress = test::StressTest;

template <class V>
bool valid(const V& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && v.x >= 0 && v.y >= 0 && v.z >= 0;
}

constexpr std::array<double, 12> altitudes_deg{-90.0, -89.9999999, -30.0, -10.0, -1.0, -1e-7,
                                               0.0,   1e-7,        0.1,   5.0,   45.0, 90.0};

std::vector<glm::vec3> directions() {
    std::vector<glm::vec3> out{{0, 0, 1}, {0, 0, -1}, {1, 0, 1e-7F}, {1, 0, -1e-7F}, {0, 0, 0}};
    for (double altitude : altitudes_deg) {
        for (double azimuth : {0.0, 123.0}) {
            const double a = altitude * degree_rad;
            const double z = azimuth * degree_rad;
            out.emplace_back(glm::dvec3(std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a)));
        }
    }
    return out;
}

TEST_F(SkyModelsStress, AerialPerspective) {
    const std::vector<glm::vec3> ways = directions();
    const glm::vec3 lux(1.3e5F);
    for (float turbidity : {-1.0F, 1.0F, 4.0F, 1e9F}) {
        const Air air = make_air(turbidity);
        for (float height : {-400.0F, 0.0F, 3e3F, 1e5F, 1e7F}) {
            for (float distance : {0.0F, 1e-6F, 1.0F, 1e4F, 2e6F, 1e9F}) {
                std::vector<float> x, y, z, d;
                for (const glm::vec3& v : ways) {
                    const auto a = aerial_perspective(air, height, v, distance, ways[9], lux, lux);
                    ASSERT_TRUE(valid(a.transmittance) && valid(a.in_scatter)) << height << ' ' << distance;
                    ASSERT_LE(a.transmittance.z, 1.0F);
                    x.push_back(v.x);
                    y.push_back(v.y);
                    z.push_back(v.z);
                    d.push_back(distance);
                }
                std::array<std::vector<float>, 6> out;
                out.fill(std::vector<float>(x.size()));
                aerial_perspective(air, height, ways[9], lux, lux, {x, y, z, d},
                                   {out[0], out[1], out[2], out[3], out[4], out[5]});
                for (std::size_t i = 0; i < x.size(); ++i) {
                    ASSERT_TRUE(valid(glm::vec3(out[0][i], out[1][i], out[2][i])) &&
                                valid(glm::vec3(out[3][i], out[4][i], out[5][i])))
                        << turbidity << ' ' << height << ' ' << distance << ' ' << z[i];
                }
            }
        }
    }
}

TEST_F(SkyModelsStress, DirectLightAtEveryHeight) {
    for (double altitude : altitudes_deg) {
        for (double height : {-1e9, 0.0, 1e-6, 1.0, 12e3, 25e3, 80e3, 1e5, 1e30}) {
            const double a = altitude * degree_rad;
            ASSERT_TRUE(std::isfinite(refraction_rad(a, height)));
            const ApparentDisc disc = apparent_disc(a, 4.65e-3, height);
            ASSERT_TRUE(std::isfinite(disc.altitude_rad) && disc.vertical_radius_rad >= 0.0);
            const SlantColumn column = slant_column(a, height);
            for (double amount : {column.molecules, column.aerosol, column.ozone, column.water}) {
                ASSERT_TRUE(std::isfinite(amount) && amount >= 0.0) << altitude << ' ' << height;
            }
            for (double radius : {0.0, 4.65e-3, 1.0}) {
                AirColumn air;
                air.observer_height_m = height;
                ASSERT_TRUE(valid(sun_illuminance_lux(a, radius, 1.0, air)));
                ASSERT_TRUE(valid(moon_illuminance_lux(a, radius, 3.8e8, 0.5, air)));
            }
        }
    }
    for (double r : {-1.0, 0.0, 1.0 - 1e-15, 1.0, 2.0}) {
        ASSERT_TRUE(valid(limb_darkening(r)));
    }
}

TEST_F(SkyModelsStress, NightSky) {
    const std::vector<glm::vec3> ways = directions();
    for (const glm::vec3& moon : ways) {
        for (float turbidity : {-1.0F, 1.0F, 5.0F, 1e9F}) {
            for (float phase : {0.0F, 3.14159265F, -7.0F}) {
                const NightSky sky = make_night_sky(moon, 0.0F, phase, turbidity);
                for (const glm::vec3& v : ways) {
                    ASSERT_TRUE(valid(night_radiance(sky, v)));
                }
                ASSERT_TRUE(valid(night_radiance(sky, moon)));
                ASSERT_TRUE(valid(night_radiance(sky, -moon)));
                std::array<glm::vec3, 49> c{};
                project_night_sky(sky, 7, c);
                ASSERT_TRUE(valid(c[0]));
                for (const glm::vec3& coefficient : c) {
                    ASSERT_TRUE(std::isfinite(coefficient.y));
                }
            }
        }
    }
}

} // namespace
} // namespace alpenglow::sky
