#include <gtest/gtest.h>

#include "support.hpp"

#include <limits>

namespace alpenglow::probes {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

// Fills the probes with a function of position, marking valid ones as made.
template <class F>
ProbeGridSh filled(const ProbeGrid& grid, const F& value) {
    ProbeGridSh light;
    test::make_all(grid, light, test::clear_sky(grid.order));
    for (std::size_t p = 0; p <= probe_count(grid); ++p) {
        for (std::size_t i = 0; i < light.lines; ++i) {
            light.coefficients[p * light.lines + i].values.fill(
                p < probe_count(grid) ? value(probe_position_m(grid, p), p) : -1000.0F);
        }
    }
    return light;
}

std::vector<glm::vec3> positions(const ProbeGrid& grid, std::size_t count, float margin) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<float> uniform(-margin, 1.0F + margin);
    std::vector<glm::vec3> out(count);
    for (glm::vec3& p : out) {
        p = grid.min_m + glm::vec3(uniform(engine), uniform(engine), uniform(engine)) * (grid.max_m - grid.min_m);
    }
    return out;
}

TEST(ProbeGridTest, ChecksNameTheField) {
    const auto message = [](const auto& change) {
        ProbeGrid grid = test::small_grid();
        change(grid);
        const Status status = check(grid);
        return status ? std::string("fine") : status.error().message();
    };
    EXPECT_EQ(message([](ProbeGrid&) {}), "fine");
    EXPECT_NE(message([](ProbeGrid& g) { g.count.y = 0; }).find("ProbeGrid::count.y: is 0"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.count.z = -3; }).find("count.z: is -3"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { std::swap(g.min_m.x, g.max_m.x); }).find("ProbeGrid::max_m.x"),
              std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.max_m.z = g.min_m.z; }).find("max_m.z"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.min_m.y = nan; }).find("min_m.y: is not finite"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.max_m.y = infinity; }).find("max_m.y: is not finite"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.order = 6; }).find("order: is 6"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.budget = 0; }).find("budget"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.max_error = nan; }).find("max_error"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.ground_albedo.y = 1.5F; }).find("ground_albedo"), std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.valid.resize(7); }).find("valid: has 7 values (expected none, or 105"),
              std::string::npos);
    EXPECT_NE(message([](ProbeGrid& g) { g.occlusion.resize(105); }).find("945"), std::string::npos);
}

TEST(ProbeGridTest, AMillionProbesFitAndABillionSayWhatTheyWouldTake) {
    ProbeGrid grid = test::small_grid();
    grid.count = {100, 100, 100};
    EXPECT_TRUE(check(grid));
    EXPECT_LT(memory_bytes(grid), std::size_t{216} << 20U);
    ProbeGridSh light;
    prepare(grid, light);
    const std::size_t held = light.coefficients.size() * sizeof(ProbeLine) + light.packed.size() * sizeof(PackedProbe) +
                             light.window.size() * 4 + light.made_pass.size() * 4 +
                             light.made_sun_visibility.size() * 4 + light.made_moon_visibility.size() * 4 +
                             light.needed.size() + light.cell_mask.size() + light.nearest.size() * 4;
    EXPECT_NEAR(static_cast<double>(held), static_cast<double>(memory_bytes(grid)), 1024.0);
    grid.count = {1000, 1000, 1000};
    const Status status = check(grid);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message().find("1000000000 probes, which take 204"), std::string::npos)
        << status.error().message();
}

TEST(ProbeGridTest, BlendsLinearFunctionsExactly) {
    const ProbeGrid grid = test::small_grid();
    const auto linear = [](const glm::vec3& p, std::size_t) { return 100.0F + 2.0F * p.x - 3.0F * p.y + 5.0F * p.z; };
    const ProbeGridSh light = filled(grid, linear);
    const std::vector<glm::vec3> where = positions(grid, 1000, 0.0F);
    std::vector<ProbeLine> out(where.size() * light.lines);
    blend(grid, light, where, out);
    for (std::size_t r = 0; r < where.size(); ++r) {
        EXPECT_NEAR(out[r * light.lines].values[3], linear(where[r], 0), 1e-4F);
    }
}

TEST(ProbeGridTest, VectorisedAndScalarBlendingAgreeWithHolesAndOutside) {
    for (const glm::ivec3 count : {glm::ivec3(7, 5, 3), glm::ivec3(1, 5, 3), glm::ivec3(7, 1, 1), glm::ivec3(1)}) {
        ProbeGrid grid = test::small_grid();
        grid.count = count;
        std::mt19937 engine(1);
        for (std::size_t p = 0; p < probe_count(grid); ++p) {
            grid.valid.push_back(engine() % 3 == 0 ? 1 : 0);
        }
        const ProbeGridSh light =
            filled(grid, [](const glm::vec3&, std::size_t p) { return 10.0F + static_cast<float>(p); });
        std::vector<glm::vec3> where = positions(grid, 777, 0.3F);
        where.emplace_back(nan, 1.0F, 6.0F);
        where.emplace_back(0.0F, infinity, 6.0F);
        where.push_back(grid.min_m);
        where.push_back(grid.max_m);
        std::vector<ProbeLine> fast(where.size() * light.lines);
        std::vector<ProbeLine> slow(where.size() * light.lines);
        blend(grid, light, where, fast);
        blend_reference(grid, light, where, slow);
        for (std::size_t i = 0; i < fast.size(); ++i) {
            for (std::size_t j = 0; j < 16; ++j) {
                ASSERT_NEAR(fast[i].values[j], slow[i].values[j], 2e-4F) << i;
            }
        }
    }
}

// Random light of random size, made negative nowhere: the packed blend is near the scalar one, and not negative either.
TEST(ProbeGridTest, PackedBlendingKeepsItsErrorAndLeavesNothingNegative) {
    for (int order = 1; order <= 3; ++order) {
        ProbeGrid grid = test::small_grid(order);
        test::furnish(grid, 40);
        std::mt19937 engine(5);
        for (std::size_t p = 0; p < probe_count(grid); ++p) {
            grid.valid.push_back(engine() % 4 == 0 ? 0 : 1);
        }
        ProbeGridSh light;
        ProbeSources sources = test::clear_sky(order, 4.0);
        sources.sun_lux = {1.6e9F, 2e4F, 0.0F}; // HDR, and channels far apart
        test::make_all(grid, light, sources);
        ASSERT_EQ(light.packed.size(), probe_count(grid) + 1);
        std::vector<glm::vec3> where = positions(grid, 300, 0.2F);
        where.emplace_back(nan, 1.0F, 6.0F);
        std::vector<ProbeLine> packed(where.size() * light.lines), exact(packed.size());
        blend_packed(grid, light, where, packed);
        blend_reference(grid, light, where, exact);
        for (std::size_t r = 0; r < where.size(); ++r) {
            ProbeCoefficients c{};
            float largest = 0.0F;
            for (const std::uint32_t corner : blend_corners(grid, light, where[r]).probe) {
                for (int i = 0; i < order * order; ++i) {
                    const glm::vec3 v = glm::abs(coefficient(light, corner, i));
                    largest = std::max({largest, v.x, v.y, v.z});
                }
            }
            for (std::size_t i = 0; i < 16 * light.lines; ++i) {
                const float got = packed[r * light.lines + i / 16].values[i % 16];
                const float expected = exact[r * light.lines + i / 16].values[i % 16];
                EXPECT_NEAR(got, expected, (i < 3 ? 4e-5F : 2e-5F) * largest) << order << ' ' << r << ' ' << i;
                if (i < static_cast<std::size_t>(3 * order * order)) {
                    c[i / 3][static_cast<int>(i % 3)] = got;
                } else {
                    EXPECT_EQ(got, 0.0F) << "padding";
                }
            }
            EXPECT_GE(test::least_irradiance(order, c), -1e-6) << order << ' ' << r;
        }
    }
}

TEST(ProbeGridTest, NothingLeaksOutOfTerrain) {
    ProbeGrid grid = test::small_grid();
    std::mt19937 engine(2);
    for (std::size_t p = 0; p < probe_count(grid); ++p) {
        grid.valid.push_back(engine() % 2 == 0 ? 1 : 0);
    }
    // Probes in terrain are bright beyond measure, or not even numbers.
    const ProbeGridSh light = filled(grid, [&](const glm::vec3&, std::size_t p) {
        return grid.valid[p] != 0 ? 1.0F + static_cast<float>(p) / 1000.0F : p % 2 == 0 ? 1e30F : nan;
    });
    std::vector<glm::vec3> where = positions(grid, 2000, 0.1F);
    for (std::size_t p = 0; p < probe_count(grid); ++p) {
        where.push_back(probe_position_m(grid, p)); // exactly on probes, terrain's too
    }
    std::vector<ProbeLine> out(where.size() * light.lines);
    blend(grid, light, where, out);
    for (std::size_t r = 0; r < where.size(); ++r) {
        float least = infinity;
        float most = 0.0F;
        const Corners corners = trilinear_corners(grid, where[r]);
        for (std::size_t c = 0; c < 8; ++c) {
            if (grid.valid[corners.probe[c]] != 0 && corners.weight[c] > 0.0F) {
                const float v = 1.0F + static_cast<float>(corners.probe[c]) / 1000.0F;
                least = std::min(least, v);
                most = std::max(most, v);
            }
        }
        const float v = out[r * light.lines].values[0];
        if (most > 0.0F) { // a mean of those that count
            EXPECT_GE(v, least - 1e-5F);
            EXPECT_LE(v, most + 1e-5F);
        } else { // some valid probe nearby
            EXPECT_GE(v, 1.0F);
            EXPECT_LE(v, 1.2F);
        }
    }
}

TEST(ProbeGridTest, ProbesNeverMadeDoNotCount) {
    const ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    ASSERT_TRUE(begin_frame(grid, light));
    const glm::vec3 here(-9.0F, 1.0F, 5.5F);
    mark_needed(grid, light, std::span(&here, 1));
    EXPECT_EQ(update_grid(grid, light, test::clear_sky(3)).updated, 8U);
    // Two cells away: the probe in the open stands in, with light of its own.
    const std::vector<glm::vec3> where{here, {15.0F, 7.0F, 8.5F}};
    std::vector<ProbeLine> out(where.size() * light.lines);
    blend(grid, light, where, out);
    EXPECT_GT(out[0].values[0], 0.0F);
    EXPECT_EQ(out[light.lines].values[0], light.coefficients[probe_count(grid) * light.lines].values[0]);
    EXPECT_GT(out[light.lines].values[0], 0.0F);
}

TEST(ProbeGridTest, NearestValidProbeIsNearest) {
    ProbeGrid grid = test::small_grid();
    grid.valid.assign(probe_count(grid), 0);
    const std::vector<std::size_t> valid{3, 40, 104};
    for (const std::size_t p : valid) {
        grid.valid[p] = 1;
    }
    ProbeGridSh light;
    prepare(grid, light);
    const auto steps = [&](std::size_t a, std::size_t b) {
        const auto at = [&](std::size_t p) {
            return glm::ivec3(static_cast<int>(p % 7), static_cast<int>(p / 7 % 5), static_cast<int>(p / 35));
        };
        const glm::ivec3 d = glm::abs(at(a) - at(b));
        return d.x + d.y + d.z;
    };
    for (std::size_t p = 0; p < probe_count(grid); ++p) {
        for (const std::size_t q : valid) {
            EXPECT_LE(steps(p, light.nearest[p]), steps(p, q));
        }
        EXPECT_NE(grid.valid[light.nearest[p]], 0);
    }
}

TEST(ProbeGridTest, AGridWithoutAValidProbeStandsInTheOpen) {
    ProbeGrid grid = test::small_grid();
    grid.valid.assign(probe_count(grid), 0);
    ProbeGridSh light;
    ASSERT_TRUE(begin_frame(grid, light));
    const glm::vec3 here(0.0F, 1.0F, 5.5F);
    mark_needed(grid, light, std::span(&here, 1));
    EXPECT_EQ(update_grid(grid, light, test::clear_sky(3)).updated, 0U);
    std::vector<ProbeLine> out(light.lines);
    blend(grid, light, std::span(&here, 1), out);
    EXPECT_EQ(out[0].values[0], light.coefficients[probe_count(grid) * light.lines].values[0]);
}

} // namespace
} // namespace alpenglow::probes
