#include <gtest/gtest.h>

#include "support.hpp"

#include <fp_traps.hpp>

#include <limits>

namespace alpenglow::probes {
namespace {

class ProbesStress : public alpenglow::test::StressTest {};

TEST_F(ProbesStress, LightOfAnySize) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 6);
    for (const float scale : {1e-40F, 1e-30F, 1e-12F, 1e-4F, 1.0F, 1e6F, 1e12F}) {
        for (const Deringing way : {Deringing::none, Deringing::paper, Deringing::exact}) {
            ProbeSources sources = test::clear_sky(3);
            for (glm::vec3& c : sources.sky) {
                c *= scale;
            }
            sources.sun_lux *= scale;
            sources.moon_lux *= scale;
            grid.deringing = way;
            ProbeGridSh light;
            test::make_all(grid, light, sources);
            for (std::size_t p = 0; p < probe_count(grid); ++p) {
                for (int i = 0; i < 9; ++i) {
                    const glm::vec3 c = coefficient(light, p, i);
                    ASSERT_TRUE(std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z)) << scale;
                }
            }
        }
    }
}

TEST_F(ProbesStress, DarknessIsDark) {
    ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    test::make_all(grid, light, ProbeSources{});
    for (const ProbeLine& line : light.coefficients) {
        for (const float v : line.values) {
            EXPECT_EQ(v, 0.0F);
        }
    }
    ProbeSources dawn;
    dawn.sun_lux = glm::vec3(1e-3F);
    const double bound = drift_bound(grid, light, dawn).sources;
    EXPECT_GT(bound, 0.5); // out of the dark everything changes
}

TEST_F(ProbesStress, SunInEveryPlace) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 61);
    ProbeGridSh light;
    const std::vector<glm::vec3> places{{0, 0, 1},  {0, 0, -1}, {1, 0, 0},           {0, 1, 0},
                                        {-1, 0, 0}, {0, -1, 0}, test::towards(1e-5), test::towards(89.9999)};
    for (const glm::vec3& place : places) {
        ProbeSources sources = test::clear_sky(3);
        sources.to_sun = place;
        sources.sun_lux = glm::vec3(1.6e9F);
        test::make_all(grid, light, sources);
        for (std::size_t p = 0; p < probe_count(grid); ++p) {
            EXPECT_GE(test::least_irradiance(3, test::probe_light(light, p)), -2e-6);
        }
    }
}

TEST_F(ProbesStress, InputsThatAreNone) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 7);
    const std::array<float, 7> odd{std::numeric_limits<float>::quiet_NaN(),
                                   std::numeric_limits<float>::infinity(),
                                   -std::numeric_limits<float>::infinity(),
                                   std::numeric_limits<float>::max(),
                                   -1.0F,
                                   std::numeric_limits<float>::denorm_min(),
                                   -0.0F};
    for (std::size_t k = 0; k < odd.size(); ++k) {
        grid.occlusion[2 * 105 + k] = odd[k];
        grid.albedo[10 + k].z = odd[k];
        grid.sun_visibility[20 + k] = odd[k];
        grid.moon_visibility[30 + k] = odd[k];
    }
    ProbeGridSh light;
    test::make_all(grid, light, test::clear_sky(3));
    std::vector<glm::vec3> where;
    for (const float a : odd) {
        where.emplace_back(a, 1.0F, 6.0F);
        where.emplace_back(1.0F, a, a);
    }
    for (std::size_t p = 0; p < 105; ++p) {
        where.push_back(probe_position_m(grid, p));
    }
    std::vector<ProbeLine> out(where.size() * light.lines);
    blend(grid, light, where, out);
    for (std::size_t r = 0; r < where.size(); ++r) {
        for (std::size_t i = 0; i < 27; ++i) {
            EXPECT_TRUE(std::isfinite(out[r * light.lines + i / 16].values[i % 16]));
        }
        EXPECT_GT(out[r * light.lines].values[0], 0.0F);
    }
}

TEST_F(ProbesStress, GridsAtTheEndsOfTheirRange) {
    ProbeGrid grid = test::small_grid();
    grid.min_m = glm::vec3(-4e29F);
    grid.max_m = glm::vec3(4e29F);
    ASSERT_TRUE(check(grid));
    ProbeGridSh light;
    test::make_all(grid, light, test::clear_sky(3));
    const std::vector<glm::vec3> where{glm::vec3(-3e38F), glm::vec3(0.0F), glm::vec3(3e38F), glm::vec3(4e29F)};
    std::vector<ProbeLine> out(where.size() * light.lines);
    blend(grid, light, where, out);
    EXPECT_GT(out[0].values[0], 0.0F);
    grid.max_m = glm::vec3(3e38F);
    grid.min_m = glm::vec3(-3e38F);
    EXPECT_FALSE(check(grid));
    grid.min_m = glm::vec3(0.0F);
    grid.max_m = glm::vec3(1e-35F);
    EXPECT_FALSE(check(grid));
}

} // namespace
} // namespace alpenglow::probes
