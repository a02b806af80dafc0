#include <gtest/gtest.h>

#include "support.hpp"

#include <set>

namespace alpenglow::probes {
namespace {

UpdateCounts frame(const ProbeGrid& grid, ProbeGridSh& light, const ProbeSources& sources,
                   std::span<const glm::vec3> receivers) {
    EXPECT_TRUE(begin_frame(grid, light));
    mark_needed(grid, light, receivers);
    return update_grid(grid, light, sources);
}

std::vector<glm::vec3> everywhere(const ProbeGrid& grid) {
    std::vector<glm::vec3> out;
    for (std::size_t p = 0; p < probe_count(grid); ++p) {
        out.push_back(probe_position_m(grid, p));
    }
    return out;
}

TEST(UpdateTest, NobodyNeedsItNobodyMakesIt) {
    const ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    const UpdateCounts counts = frame(grid, light, test::clear_sky(3), {});
    EXPECT_EQ(counts.considered, 105U);
    EXPECT_EQ(counts.updated, 0U);
    EXPECT_EQ(counts.skipped, 105U);
    EXPECT_EQ(light.pass, 0U);
    const glm::vec3 outside(1000.0F, 0.0F, 0.0F);
    EXPECT_EQ(frame(grid, light, test::clear_sky(3), std::span(&outside, 1)).updated, 0U);
}

TEST(UpdateTest, OnlyTheProbesAroundAReceiverAreMade) {
    const ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    const glm::vec3 here(1.0F, 3.0F, 6.0F);
    EXPECT_EQ(frame(grid, light, test::clear_sky(3), std::span(&here, 1)).updated, 8U);
    const Corners corners = trilinear_corners(grid, here);
    for (const std::uint32_t p : corners.probe) {
        EXPECT_EQ(light.made_pass[p], 1U);
    }
    EXPECT_EQ(std::count(light.made_pass.begin(), light.made_pass.end(), 1U), 8);
    EXPECT_EQ(frame(grid, light, test::clear_sky(3), std::span(&here, 1)).updated, 0U);
}

TEST(UpdateTest, ConvergesWithinTheStatedNumberOfFrames) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 8);
    for (const std::uint32_t budget : {1U, 7U, 50U, 105U, 5000U}) {
        grid.budget = budget;
        ProbeGridSh light;
        const std::vector<glm::vec3> receivers = everywhere(grid);
        for (const double altitude : {30.0, 45.0}) { // first all are new, then all are stale
            const ProbeSources sources = test::clear_sky(3, altitude);
            const std::uint32_t frames = (105 + budget - 1) / budget;
            for (std::uint32_t f = 0; f < frames; ++f) {
                EXPECT_LE(frame(grid, light, sources, receivers).updated, budget);
            }
            const UpdateCounts after = frame(grid, light, sources, receivers);
            EXPECT_EQ(after.updated, 0U) << budget;
            EXPECT_EQ(after.skipped, 105U);
            std::vector<float> occlusion;
            for (std::size_t p = 0; p < 105; ++p) {
                const ProbeCoefficients expected =
                    assemble_reference(3, grid.deringing, sources, test::input_of(grid, p, occlusion));
                EXPECT_LE(test::distance(test::probe_light(light, p), expected), 1e-5 * test::norm(expected));
            }
        }
    }
}

TEST(UpdateTest, NoProbeStarvesWhileTheLightKeepsMoving) {
    ProbeGrid grid = test::small_grid();
    grid.budget = 10;
    grid.max_error = 0.0F;
    ProbeGridSh light;
    const std::vector<glm::vec3> receivers = everywhere(grid);
    std::vector<std::uint32_t> last(105, 0);
    for (std::uint32_t f = 1; f <= 60; ++f) {
        frame(grid, light, test::clear_sky(3, 20.0 + f), receivers);
        for (std::size_t p = 0; p < 105; ++p) {
            if (light.made_pass[p] == light.pass) {
                last[p] = f;
            }
            EXPECT_LE(f - last[p], 22U); // two rounds of 11 at most
        }
    }
}

TEST(UpdateTest, NewProbesComeBeforeStaleOnes) {
    ProbeGrid grid = test::small_grid();
    grid.budget = 8;
    ProbeGridSh light;
    const std::vector<glm::vec3> old{{-9.0F, 1.0F, 5.5F}};
    frame(grid, light, test::clear_sky(3, 30.0), old);
    const std::vector<glm::vec3> both{{-9.0F, 1.0F, 5.5F}, {18.0F, 7.0F, 8.5F}};
    EXPECT_EQ(frame(grid, light, test::clear_sky(3, 50.0), both).updated, 8U);
    for (const std::uint32_t p : trilinear_corners(grid, both[1]).probe) {
        EXPECT_EQ(light.made_pass[p], 2U);
    }
    for (const std::uint32_t p : trilinear_corners(grid, both[0]).probe) {
        EXPECT_EQ(light.made_pass[p], 1U);
    }
}

TEST(UpdateTest, ASkippedProbeIsWithinMaxError) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 17);
    grid.max_error = 0.02F;
    ProbeGridSh light;
    const std::vector<glm::vec3> receivers = everywhere(grid);
    int skipped_frames = 0;
    for (int f = 0; f < 300; ++f) {
        const ProbeSources sources = test::clear_sky(3, 5.0 + 0.02 * f);
        const UpdateCounts counts = frame(grid, light, sources, receivers);
        skipped_frames += counts.updated == 0 ? 1 : 0;
        EXPECT_LE(counts.error_bound, 0.02);
        if (f % 10 == 9) {
            const DirectLight direct = direct_light(3, grid.deringing, sources);
            const double total = test::norm(sources.sky) + test::norm(direct.sun) + test::norm(direct.moon);
            std::vector<float> occlusion;
            for (std::size_t p = 0; p < 105; ++p) {
                const ProbeCoefficients expected =
                    assemble_reference(3, grid.deringing, sources, test::input_of(grid, p, occlusion));
                EXPECT_LE(test::distance(test::probe_light(light, p), expected), 0.02 * total);
            }
        }
    }
    EXPECT_GT(skipped_frames, 200);
}

TEST(UpdateTest, AShadowTouchesOnlyTheProbesItFallsOn) {
    ProbeGrid grid = test::small_grid();
    grid.sun_visibility.assign(105, 1.0F);
    ProbeGridSh light;
    const std::vector<glm::vec3> receivers = everywhere(grid);
    const ProbeSources sources = test::clear_sky(3);
    frame(grid, light, sources, receivers);
    grid.sun_visibility[17] = 0.0F;
    grid.sun_visibility[60] = 0.5F;
    grid.sun_visibility[61] = 0.9999F; // within max_error
    EXPECT_EQ(frame(grid, light, sources, receivers).updated, 2U);
    EXPECT_EQ(frame(grid, light, sources, receivers).updated, 0U);
}

TEST(UpdateTest, ARaisedRevisionMakesAllAnew) {
    ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    const std::vector<glm::vec3> receivers = everywhere(grid);
    const ProbeSources sources = test::clear_sky(3);
    frame(grid, light, sources, receivers);
    grid.ground_albedo = glm::vec3(0.9F);
    EXPECT_EQ(frame(grid, light, sources, receivers).updated, 0U);
    ++grid.revision;
    EXPECT_EQ(frame(grid, light, sources, receivers).updated, 105U);
}

TEST(UpdateTest, ABadGridChangesNothing) {
    ProbeGrid grid = test::small_grid();
    ProbeGridSh light;
    frame(grid, light, test::clear_sky(3), everywhere(grid));
    const std::vector<std::uint32_t> before = light.made_pass;
    grid.count = {0, 5, 3};
    EXPECT_FALSE(begin_frame(grid, light));
    EXPECT_EQ(light.made_pass, before);
}

TEST(UpdateTest, InvalidProbesAreNeverMade) {
    ProbeGrid grid = test::small_grid();
    grid.valid.assign(105, 1);
    grid.valid[5] = 0;
    grid.valid[77] = 0;
    ProbeGridSh light;
    EXPECT_EQ(frame(grid, light, test::clear_sky(3), everywhere(grid)).updated, 103U);
    EXPECT_EQ(light.made_pass[5], 0U);
    EXPECT_EQ(light.made_pass[77], 0U);
}

// NaN stays where it is: the probe lights nothing, its neighbours are as they were without it.
TEST(UpdateTest, NaNNeverSpreads) {
    ProbeGrid clean = test::small_grid();
    test::furnish(clean, 30);
    ProbeGrid dirty = clean;
    const float nan = std::nanf("");
    dirty.occlusion[3 * 105 + 20] = nan;
    dirty.albedo[21].y = nan;
    dirty.albedo[40].x = -1.0F;
    dirty.occlusion[50] = std::numeric_limits<float>::infinity();
    dirty.sun_visibility[60] = nan; // counts as 0
    clean.sun_visibility[60] = 0.0F;
    ProbeGridSh a;
    ProbeGridSh b;
    const std::vector<glm::vec3> receivers = everywhere(clean);
    const ProbeSources sources = test::clear_sky(3);
    frame(clean, a, sources, receivers);
    frame(dirty, b, sources, receivers);
    const std::set<std::size_t> bad{20, 21, 40, 50};
    for (std::size_t p = 0; p < 105; ++p) {
        for (int i = 0; i < 9; ++i) {
            if (bad.contains(p)) {
                EXPECT_EQ(coefficient(b, p, i), glm::vec3(0.0F));
                EXPECT_TRUE(std::isnan(b.window[p]));
            } else {
                EXPECT_EQ(coefficient(b, p, i), coefficient(a, p, i)) << p;
            }
        }
    }
    std::vector<ProbeLine> out(receivers.size() * b.lines);
    blend(dirty, b, receivers, out);
    for (std::size_t r = 0; r < receivers.size(); ++r) {
        EXPECT_TRUE(std::isfinite(out[r * b.lines].values[0]));
        EXPECT_GT(out[r * b.lines].values[0], 0.0F);
    }
    EXPECT_EQ(frame(dirty, b, sources, receivers).updated, 0U) << "unusable probes are not tried again and again";
}

TEST(UpdateTest, SameInputsSameBits) {
    ProbeGrid grid = test::small_grid();
    test::furnish(grid, 2);
    ProbeGridSh whole;
    ProbeGridSh parts;
    test::make_all(grid, whole, test::clear_sky(3));
    grid.budget = 13;
    test::make_all(grid, parts, test::clear_sky(3));
    for (std::size_t i = 0; i < whole.coefficients.size(); ++i) {
        EXPECT_EQ(whole.coefficients[i].values, parts.coefficients[i].values);
    }
}

} // namespace
} // namespace alpenglow::probes
