#include "clouds_test_support.hpp"

#include <alpenglow/core/parallel_for.hpp>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

// Fraction of columns with density above a threshold.
double cover_of(const SparseGrid& grid, const glm::ivec3& low, const glm::ivec3& high) {
    int covered = 0;
    int all = 0;
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            ++all;
            for (int z = low.z; z <= high.z; ++z) {
                if (grid.value(x, y, z) > 0.01F) {
                    ++covered;
                    break;
                }
            }
        }
    }
    return double(covered) / all;
}

TEST(CloudModelling, CoverBaseAndTopAreKept) {
    for (const CloudType type : {CloudType::cumulus, CloudType::stratus, CloudType::cirrus}) {
        for (const float cover : {0.0F, 0.3F, 0.7F}) {
            Weather weather{type, cover, 1000.0F, 1600.0F, {6.0F, 2.0F}, 3};
            const SparseGrid grid = generate(weather, {3200.0F, 3200.0F}, 40.0F);
            const double measured = cover_of(grid, {-40, -40, 24}, {40, 40, 41});
            EXPECT_NEAR(measured, double(cover), 0.12) << int(type);
            EXPECT_EQ(cover_of(grid, {-60, -60, 0}, {60, 60, 24}), 0.0);
            EXPECT_EQ(cover_of(grid, {-60, -60, 41}, {60, 60, 60}), 0.0);
            EXPECT_LE(grid.max_density(), 1.0F);
        }
    }
}

TEST(CloudModelling, SeedsDecideEverything) {
    const Weather weather{CloudType::stratus, 0.5F, 500.0F, 900.0F, {5.0F, 0.0F}, 11};
    const SparseGrid a = generate(weather, {1600.0F, 1600.0F}, 50.0F);
    const SparseGrid b = generate(weather, {1600.0F, 1600.0F}, 50.0F);
    Weather other = weather;
    other.seed = 12;
    const SparseGrid c = generate(other, {1600.0F, 1600.0F}, 50.0F);
    ASSERT_EQ(a.table().count(), b.table().count());
    std::size_t different = 0;
    for (int z = 8; z < 20; ++z) {
        for (int y = -16; y < 16; ++y) {
            for (int x = -16; x < 16; ++x) {
                ASSERT_EQ(a.value(x, y, z), b.value(x, y, z));
                different += a.value(x, y, z) != c.value(x, y, z) ? 1 : 0;
            }
        }
    }
    EXPECT_GT(different, 100U);
}

TEST(CloudModelling, AMetaballIsItsKernel) {
    const Particle p{{3.0F, -4.0F, 5.0F}, 6.0F, 0.8F};
    const SparseGrid grid = rasterise(std::vector<Particle>{p}, 0.5F);
    for (int z = -4; z < 26; ++z) {
        for (int y = -24; y < 8; ++y) {
            for (int x = -8; x < 22; ++x) {
                const glm::vec3 d = glm::vec3(x, y, z) * 0.5F - p.centre_m;
                const float s = std::max(0.0F, 1.0F - (d.x * d.x + d.y * d.y + d.z * d.z) / 36.0F);
                ASSERT_NEAR(grid.value(x, y, z), 0.8F * s * s * s, 1e-6F);
            }
        }
    }
    EXPECT_EQ(rasterise({}, 1.0F).active_voxels(), 0U);
}

TEST(CloudModelling, OnlyWhatChangedIsRasterisedAgain) {
    std::vector<Particle> before;
    for (std::uint32_t i = 0; i < 40; ++i) {
        before.push_back(
            {{80.0F * test::random_at(5 * i), 80.0F * test::random_at(5 * i + 1), 30.0F * test::random_at(5 * i + 2)},
             5.0F + 3.0F * test::random_at(5 * i + 3),
             0.5F});
    }
    SparseGrid grid = rasterise(before, 1.0F);
    const int bricks = grid.table().count();
    std::vector<Particle> after = before;
    EXPECT_EQ(update_rasterised(grid, before, after, 0.01F), 0U);
    after[7].centre_m += glm::vec3(2.0F, 0.0F, 0.0F);
    after[9].centre_m.x = 120.0F; // out of the grid
    const std::size_t updated = update_rasterised(grid, before, after, 0.01F);
    EXPECT_GT(updated, 0U);
    EXPECT_LT(updated, std::size_t(bricks) / 2);
    const SparseGrid fresh = rasterise(after, 1.0F);
    for (int z = -10; z < 45; ++z) {
        for (int y = -10; y < 95; ++y) {
            for (int x = -10; x < 135; ++x) {
                ASSERT_NEAR(grid.value(x, y, z), fresh.value(x, y, z), 1e-6F);
            }
        }
    }
}

} // namespace
