#include <gtest/gtest.h>

#include "support.hpp"

#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>

#include <functional>

namespace alpenglow::probes {
namespace {

constexpr std::array<Deringing, 3> ways{Deringing::none, Deringing::paper, Deringing::exact};

TEST(AssembleTest, BatchAgreesWithTheScalarReference) {
    for (int order = 1; order <= max_probe_order; ++order) {
        for (const Deringing way : ways) {
            ProbeGrid grid = test::small_grid(order);
            if (order > 3) {
                grid.count = {3, 3, 2}; // scalar and slow
            }
            grid.deringing = way;
            test::furnish(grid, 11U + static_cast<unsigned>(order));
            const ProbeSources sources = test::clear_sky(order);
            ProbeGridSh light;
            test::make_all(grid, light, sources);
            std::vector<float> occlusion;
            for (std::size_t p = 0; p < probe_count(grid); ++p) {
                const ProbeCoefficients expected =
                    assemble_reference(order, way, sources, test::input_of(grid, p, occlusion));
                // Float windows are found to 1e-6; the paper's search stops at its table's steps.
                EXPECT_LE(test::distance(test::probe_light(light, p), expected), 5e-6 * test::norm(expected))
                    << "order " << order << ", probe " << p << ", way " << static_cast<int>(way);
            }
        }
    }
}

TEST(AssembleTest, IrradianceIsNowhereNegativeWithDeringing) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 3);
    for (const double altitude : {-5.0, 2.0, 20.0, 60.0, 90.0}) {
        ProbeSources sources = test::clear_sky(3, altitude);
        sources.sun_lux *= altitude > 0.0 ? 10.0F : 0.0F; // stronger than any sun
        for (const Deringing way : ways) {
            grid.deringing = way;
            ++grid.revision;
            ProbeGridSh light;
            test::make_all(grid, light, sources);
            double least = 0.0;
            for (std::size_t p = 0; p < probe_count(grid); ++p) {
                least = std::min(least, test::least_irradiance(3, test::probe_light(light, p)));
            }
            if (way == Deringing::exact) {
                EXPECT_GE(least, -1e-6) << altitude;
            } else if (way == Deringing::paper) {
                EXPECT_GE(least, -0.02) << altitude; // its last column leaves a little
            } else if (altitude > 0.0) {
                EXPECT_LT(least, -0.01) << altitude; // the light of this test does ring
            }
        }
    }
}

TEST(AssembleTest, BlendedLightIsNowhereNegativeEither) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 4);
    ProbeGridSh light;
    test::make_all(grid, light, test::clear_sky(3));
    std::mt19937 engine(9);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 p =
            grid.min_m + glm::vec3(uniform(engine), uniform(engine), uniform(engine)) * (grid.max_m - grid.min_m);
        std::vector<ProbeLine> out(light.lines);
        blend(grid, light, std::span(&p, 1), out);
        ProbeCoefficients c{};
        for (std::size_t k = 0; k < 27; ++k) {
            c[k / 3][static_cast<int>(k % 3)] = out[k / 16].values[k % 16];
        }
        EXPECT_GE(test::least_irradiance(3, c), -1e-6);
    }
}

// An open field is an exact case: sky above, Lambertian ground below.
TEST(AssembleTest, OpenFieldMatchesProjectionOfItsRadiance) {
    constexpr int order = 5;
    ProbeSources sources;
    sources.order = order;
    std::array<double, max_probe_order> dome{};
    sh::zonal_hemisphere(order, 1.0, 0.0, dome);
    sh::add_zonal(order, dome, glm::vec3(0.0F, 0.0F, 1.0F), glm::vec3(1000.0F, 2000.0F, 4000.0F), sources.sky);
    ProbeInput input;
    input.albedo = {0.1F, 0.2F, 0.5F};
    const ProbeCoefficients light = assemble_reference(order, Deringing::none, sources, input);
    // A uniform dome of radiance L puts pi L on the ground, which sends back albedo L.
    std::array<double, max_probe_order> expected{};
    for (int c = 0; c < 3; ++c) {
        const double sky = 1000.0 * std::exp2(c);
        sh::zonal_hemisphere(order, sky, static_cast<double>(input.albedo[c]) * sky, expected);
        for (int l = 0; l < order; ++l) {
            // The dome's irradiance is cut at band 4: 0.6 % too little.
            EXPECT_NEAR(light[static_cast<std::size_t>(sh::index(l, 0))][c], expected[static_cast<std::size_t>(l)],
                        0.007 * sky);
        }
    }
}

// A furnace: ground of albedo 1 under a uniform dome, walls and all, is uniform light.
TEST(AssembleTest, WhiteFurnace) {
    ProbeSources sources;
    sources.order = 3;
    std::array<double, max_probe_order> dome{};
    sh::zonal_hemisphere(3, 1.0, 0.0, dome);
    sh::add_zonal(3, dome, glm::vec3(0.0F, 0.0F, 1.0F), glm::vec3(500.0F), sources.sky);
    ProbeInput input;
    input.albedo = glm::vec3(1.0F);
    const ProbeCoefficients light = assemble_reference(3, Deringing::exact, sources, input);
    const double uniform = 500.0 * std::sqrt(4.0 * pi);
    EXPECT_NEAR(light[0].x, uniform, 1e-3 * uniform);
    for (std::size_t i = 1; i < 9; ++i) {
        EXPECT_NEAR(light[i].x, 0.0, 2e-3 * uniform);
    }
}

TEST(AssembleTest, LightIsLinearInItsSourcesWithoutDeringing) {
    const ProbeSources a = test::clear_sky(3, 20.0);
    ProbeSources twice = a;
    for (glm::vec3& c : twice.sky) {
        c *= 2.0F;
    }
    twice.sun_lux *= 2.0F;
    twice.moon_lux *= 2.0F;
    const std::vector<float> occlusion = test::wall(3, test::towards(30.0), 0.6);
    const ProbeInput input{.sun_visibility = 0.5F, .albedo = glm::vec3(0.3F), .occlusion = occlusion};
    for (const Deringing way : ways) { // a window does not depend on scale, so deringing keeps this
        const ProbeCoefficients one = assemble_reference(3, way, a, input);
        const ProbeCoefficients two = assemble_reference(3, way, twice, input);
        for (std::size_t i = 0; i < one.size(); ++i) {
            EXPECT_LE(glm::distance(2.0F * one[i], two[i]), 1e-5 * test::norm(two));
        }
    }
}

TEST(AssembleTest, AWallTakesTheSkyThatItHides) {
    const ProbeSources sources = test::clear_sky(3);
    ProbeInput input;
    input.albedo = glm::vec3(0.0F);
    input.sun_visibility = 0.0F;
    input.moon_visibility = 0.0F;
    double before = 1e30;
    for (const double angle : {0.0, 0.3, 0.6, 0.9, 1.2}) {
        const std::vector<float> occlusion = test::wall(3, glm::vec3(0.0F, 0.0F, 1.0F), angle);
        input.occlusion = occlusion;
        const ProbeCoefficients light = assemble_reference(3, Deringing::none, sources, input);
        EXPECT_LT(light[0].y, before);
        before = static_cast<double>(light[0].y);
    }
}

// The part of the sky's light that is left under an occlusion that is a function of direction, projected by rays as a
// game does it, on a black ground without sun or moon: coefficients relative to the norm of the open sky's.
double left_of_sky(int order, Deringing way, const std::function<double(const glm::dvec3&)>& hidden, glm::vec3* lux) {
    std::vector<double> projected(static_cast<std::size_t>(sh::coefficient_count(order)));
    sh::project_function(
        order, sh::sphere_quadrature(62), // an even number of nodes in z: none on the horizon
        std::function<double(const glm::dvec3&)>([&](const glm::dvec3& d) { return d.z > 0.0 ? hidden(d) : 0.0; }),
        projected);
    const std::vector<float> occlusion(projected.begin(), projected.end());
    ProbeGrid grid = test::small_grid(order);
    grid.count = {2, 1, 1};
    grid.deringing = way;
    grid.ground_albedo = glm::vec3(0.0F);
    grid.sun_visibility = grid.moon_visibility = {0.0F, 0.0F};
    test::set_occlusion(grid, 0, occlusion);
    const ProbeSources sources = test::clear_sky(order, 15.0);
    ProbeGridSh light;
    test::make_all(grid, light, sources);
    const ProbeCoefficients left = test::probe_light(light, 0), open = test::probe_light(light, 1);
    const ProbeInput input{
        .sun_visibility = 0.0F, .moon_visibility = 0.0F, .albedo = glm::vec3(0.0F), .occlusion = occlusion};
    EXPECT_LE(test::distance(left, assemble_reference(order, way, sources, input)), 2e-6 * test::norm(open));
    if (lux != nullptr) {
        std::vector<glm::vec3> e(left.begin(), left.end());
        sh::irradiance(order, std::span<const glm::vec3>(e), std::span<glm::vec3>(e));
        *lux = sh::evaluate(order, std::span<const glm::vec3>(e), glm::vec3(0.0F, 0.0F, 1.0F));
    }
    return test::norm(left) / test::norm(open);
}

// A sky that is covered gives no light, one that is half covered half of it.
TEST(AssembleTest, CoverTakesTheSkyInProportion) {
    for (int order = 2; order <= max_probe_order; ++order) {
        for (const Deringing way : ways) {
            if (order > 3 && way != Deringing::none) {
                continue; // scalar and slow
            }
            glm::vec3 open, half;
            EXPECT_NEAR(left_of_sky(
                            order, way, [](const glm::dvec3&) { return 0.0; }, &open),
                        1.0, 1e-6);
            EXPECT_NEAR(left_of_sky(
                            order, way, [](const glm::dvec3&) { return 0.5; }, &half),
                        0.5, 1e-5);
            EXPECT_NEAR(half.x / open.x, 0.5, 1e-5);
            EXPECT_LE(left_of_sky(
                          order, way, [](const glm::dvec3&) { return 1.0; }, nullptr),
                      1e-6)
                << order;
            // All but a slit of 1 / 64 of the sky: little is left, and none of it where a bright sky is hidden.
            const auto slit = [](const glm::dvec3& d) { return d.z < 63.0 / 64.0 ? 1.0 : 0.0; };
            EXPECT_LE(left_of_sky(order, way, slit, nullptr), 0.08) << order;
        }
    }
}

// Half of a uniform dome hidden, by a wall along the meridian: half of the light on the ground, whatever the order.
TEST(AssembleTest, HalfOfAUniformSkyIsHalfTheLight) {
    for (int order = 2; order <= max_probe_order; ++order) {
        ProbeSources sources;
        sources.order = order;
        std::array<double, max_probe_order> dome{};
        sh::zonal_hemisphere(order, 1.0, 0.0, dome);
        sh::add_zonal(order, dome, glm::vec3(0.0F, 0.0F, 1.0F), glm::vec3(1000.0F), sources.sky);
        std::vector<double> east(static_cast<std::size_t>(sh::coefficient_count(order)));
        sh::project_function(order, sh::sphere_quadrature(82),
                             std::function<double(const glm::dvec3&)>(
                                 [](const glm::dvec3& d) { return d.z > 0.0 && d.x > 0.0 ? 1.0 : 0.0; }),
                             east);
        const std::vector<float> occlusion(east.begin(), east.end());
        ProbeInput input;
        input.albedo = glm::vec3(0.0F);
        const ProbeCoefficients open = assemble_reference(order, Deringing::none, sources, input);
        input.occlusion = occlusion;
        const ProbeCoefficients half = assemble_reference(order, Deringing::none, sources, input);
        for (int l = 0; l < order; ++l) {
            const auto zonal = static_cast<std::size_t>(sh::index(l, 0));
            EXPECT_NEAR(half[zonal].x, 0.5 * static_cast<double>(open[zonal].x), 0.01 * test::norm(open)) << order << l;
        }
    }
}

TEST(AssembleTest, PunctualLightKeepsItsIlluminanceInTheMean) {
    ProbeSources sources;
    sources.to_sun = test::towards(40.0);
    sources.sun_lux = glm::vec3(1000.0F);
    for (const Deringing way : ways) {
        const DirectLight direct = direct_light(3, way, sources);
        EXPECT_NEAR(direct.sun[0].x, 1000.0 / std::sqrt(4.0 * pi), 1e-3); // radiance integrates to illuminance
        const glm::vec3 axis = sh::optimal_linear_direction(
            std::array<float, 9>{direct.sun[0].x, direct.sun[1].x, direct.sun[2].x, direct.sun[3].x, 0, 0, 0, 0, 0});
        EXPECT_GT(glm::dot(axis, sources.to_sun), 1.0F - 1e-6F);
    }
}

// The bound holds for what it claims: make the probes from one light, ask for another, recompute and compare.
TEST(AssembleTest, DriftBoundHolds) {
    std::mt19937 engine(12);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (const int order : {2, 3}) {
        for (const Deringing way : ways) {
            ProbeGrid grid = test::small_grid(order);
            grid.deringing = way;
            test::furnish(grid, 21);
            double worst_use = 0.0;
            for (const double altitude : {3.0, 25.0, 70.0}) {
                const ProbeSources before = test::clear_sky(order, altitude);
                ProbeGridSh light;
                test::make_all(grid, light, before);
                for (int trial = 0; trial < 12; ++trial) {
                    ProbeSources now = test::clear_sky(order, altitude + uniform(engine) * std::exp2(-trial / 2));
                    now.sun_lux *= static_cast<float>(1.0 + 0.1 * uniform(engine));
                    for (glm::vec3& c : now.sky) {
                        c *= glm::vec3(1.0 + 0.05 * uniform(engine), 1.0 + 0.05 * uniform(engine), 1.0);
                    }
                    ProbeGrid shadows = grid;
                    for (float& v : shadows.sun_visibility) {
                        v = std::clamp(v + static_cast<float>(0.2 * uniform(engine)), 0.0F, 1.0F);
                    }
                    const DriftBound bound = drift_bound(grid, light, now);
                    const DirectLight direct = direct_light(order, way, now);
                    const double total = test::norm(now.sky) + test::norm(direct.sun) + test::norm(direct.moon);
                    std::vector<float> occlusion;
                    for (std::size_t p = 0; p < probe_count(grid); ++p) {
                        const double error =
                            test::distance(test::probe_light(light, p),
                                           assemble_reference(order, way, now, test::input_of(shadows, p, occlusion))) /
                            total;
                        const double allowed =
                            bound.sources +
                            bound.per_sun_visibility * std::abs(static_cast<double>(shadows.sun_visibility[p]) -
                                                                static_cast<double>(grid.sun_visibility[p]));
                        ASSERT_LE(error, allowed + 1e-6) << "order " << order << ", way " << static_cast<int>(way);
                        worst_use = std::max(worst_use, error / allowed);
                    }
                }
            }
            EXPECT_GT(worst_use, 0.05) << "a bound that is of use is not 20 times the error";
        }
    }
}

TEST(AssembleTest, NothingMovedNothingDrifts) {
    ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    test::make_all(grid, light, test::clear_sky(3));
    EXPECT_EQ(drift_bound(grid, light, test::clear_sky(3)).sources, 0.0);
}

TEST(AssembleTest, UnusableSourcesAreTold) {
    ProbeSources sources = test::clear_sky(3);
    EXPECT_TRUE(usable(sources));
    sources.sky[4].y = std::nanf("");
    EXPECT_FALSE(usable(sources));
    sources = test::clear_sky(3);
    sources.to_sun *= 2.0F;
    EXPECT_FALSE(usable(sources));
    sources = test::clear_sky(3);
    sources.moon_lux.x = std::numeric_limits<float>::infinity();
    EXPECT_FALSE(usable(sources));
}

} // namespace
} // namespace alpenglow::probes
