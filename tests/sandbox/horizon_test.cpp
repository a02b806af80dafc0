#include <sandbox/world/horizon.hpp>
#include <sandbox/world/noise.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace alpenglow::sandbox {
namespace {

HeightGrid rough_grid(int n, float spacing_m, std::uint32_t seed, float jitter_m = 30.0F) {
    HeightGrid grid = make_grid(n, spacing_m);
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const glm::vec2 p = grid.position_m(i, j);
            grid.height_m[grid.index(i, j)] =
                800.0F * fractal_noise(p.x / 900.0F, p.y / 900.0F, 5, seed) + jitter_m * hash_unit(i, j, seed);
        }
    }
    return grid;
}

TEST(Horizon, SweepAgreesWithWalkingEveryLine) {
    const HeightGrid grid = rough_grid(97, 16.0F, 3);
    for (int azimuth = 0; azimuth < horizon_azimuths; ++azimuth) {
        const std::vector<float> swept = sweep_horizon(grid, azimuth);
        for (int j = 0; j < grid.n; ++j) {
            for (int i = 0; i < grid.n; ++i) {
                const float walked = walk_horizon(grid, i, j, azimuth);
                ASSERT_NEAR(swept[grid.index(i, j)], walked, 2e-5F * (1.0F + walked))
                    << "azimuth " << azimuth << " at " << i << ", " << j;
            }
        }
    }
}

TEST(Horizon, DirectionsAreNearTheirAzimuths) {
    for (int k = 0; k < horizon_azimuths; ++k) {
        const glm::ivec2 d = horizon_direction(k);
        const double azimuth = std::atan2(d.x, d.y);
        const double nominal = std::numbers::pi / 8.0 * k;
        EXPECT_LT(std::abs(std::remainder(azimuth - nominal, 2.0 * std::numbers::pi)), 0.0123); // 0.7 degrees
    }
}

TEST(Horizon, AWallStandsAtItsAngle) {
    HeightGrid grid = make_grid(65, 10.0F);
    for (int j = 0; j < grid.n; ++j) {
        grid.height_m[grid.index(50, j)] = 70.0F; // a wall along north, in the east
    }
    const std::vector<float> east = sweep_horizon(grid, 4);
    const std::vector<float> west = sweep_horizon(grid, 12);
    const std::vector<float> north_east = sweep_horizon(grid, 2);
    EXPECT_NEAR(east[grid.index(43, 32)], 1.0F, 1e-5F); // 70 m high, 70 m away
    EXPECT_NEAR(east[grid.index(36, 32)], 0.5F, 1e-5F);
    EXPECT_NEAR(north_east[grid.index(43, 32)], 1.0F / std::sqrt(2.0F), 1e-5F);
    EXPECT_EQ(east[grid.index(55, 32)], 0.0F); // behind it
    EXPECT_NEAR(west[grid.index(57, 32)], 1.0F, 1e-5F);
    EXPECT_EQ(west[grid.index(43, 32)], 0.0F);
}

// What lies beyond the grid counts as if the grid were larger: exactly along its lines, closely between them.
TEST(Horizon, SeesBeyondTheGrid) {
    const HeightGrid large = rough_grid(193, 16.0F, 5, 0.0F);
    HeightGrid middle = make_grid(65, 16.0F);
    for (int j = 0; j < middle.n; ++j) {
        for (int i = 0; i < middle.n; ++i) {
            middle.height_m[middle.index(i, j)] = large.at(i + 64, j + 64);
        }
    }
    for (int azimuth = 0; azimuth < horizon_azimuths; ++azimuth) {
        const std::vector<float> swept = sweep_horizon(middle, azimuth, &large);
        double worst = 0.0;
        double sum = 0.0;
        double without = 0.0;
        const std::vector<float> alone = sweep_horizon(middle, azimuth);
        for (int j = 0; j < middle.n; ++j) {
            for (int i = 0; i < middle.n; ++i) {
                const double walked = std::atan(walk_horizon(large, i + 64, j + 64, azimuth));
                const double error = std::abs(std::atan(swept[middle.index(i, j)]) - walked);
                worst = std::max(worst, error);
                sum += error;
                without += std::abs(std::atan(alone[middle.index(i, j)]) - walked);
            }
        }
        if (azimuth % 4 == 0) {
            EXPECT_LT(worst, 1e-4) << azimuth;
        } else {
            // The far lines pass up to half a spacing beside; only near the border that shows.
            EXPECT_LT(sum, 0.1 * without) << azimuth;
        }
    }
}

TEST(Horizon, EncodingIsMonotoneAndClose) {
    float last = -1.0F;
    for (int v = 0; v < 256; ++v) {
        const float angle = decode_horizon_rad(static_cast<std::uint8_t>(v));
        EXPECT_GT(angle, last);
        last = angle;
    }
    std::uint8_t before = 0;
    for (double degrees = 0.0; degrees < 89.9; degrees += 0.01) {
        const double angle = degrees * std::numbers::pi / 180.0;
        const std::uint8_t v = encode_horizon(static_cast<float>(std::tan(angle)));
        EXPECT_GE(v, before);
        before = v;
        // Half a step of the square-root scale.
        const double step =
            std::numbers::pi / 255.0 * std::sqrt(degrees / 90.0) + 0.5 * std::numbers::pi / 255.0 / 255.0;
        EXPECT_LE(std::abs(decode_horizon_rad(v) - angle), 0.5 * step + 1e-5) << degrees;
    }
    EXPECT_EQ(encode_horizon(0.0F), 0);
    EXPECT_EQ(encode_horizon(-5.0F), 0);
    EXPECT_EQ(encode_horizon(std::numeric_limits<float>::quiet_NaN()), 0);
    EXPECT_EQ(encode_horizon(std::numeric_limits<float>::infinity()), 255);
}

TEST(Horizon, PacksAzimuthZeroLowest) {
    HorizonBytes bytes{};
    bytes[0] = 1;
    bytes[5] = 2;
    bytes[15] = 3;
    const auto words = pack_horizon(bytes);
    EXPECT_EQ(words[0], 1U);
    EXPECT_EQ(words[1], 2U << 8U);
    EXPECT_EQ(words[3], 3U << 24U);
}

TEST(Horizon, OpenGroundSeesTheWholeSky) {
    EXPECT_FLOAT_EQ(sky_visibility(HorizonBytes{}), 1.0F);
    HorizonBytes pit;
    pit.fill(255);
    EXPECT_NEAR(sky_visibility(pit), 0.0F, 1e-6F);
}

} // namespace
} // namespace alpenglow::sandbox
