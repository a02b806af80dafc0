#include "sandbox/render/terrain_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "sandbox/render/detail_image.hpp"
#include "sandbox/world/vertex.hpp"

namespace alpenglow::sandbox {
namespace {

// A coarse square of 9 x 9 vertices 100 m apart and a fine one of 5 x 5, 25 m apart, in its middle.
const std::vector<TerrainGrid> kGrids{{0, 9, 100.0F, {-400.0F, -400.0F}}, {81, 5, 25.0F, {-50.0F, -50.0F}}};

std::vector<std::uint32_t> all_triangles() {
    std::vector<std::uint32_t> indices;
    for (const TerrainGrid& grid : kGrids) {
        for (std::uint32_t j = 0; j + 1 < grid.samples; ++j) {
            for (std::uint32_t i = 0; i + 1 < grid.samples; ++i) {
                const std::uint32_t v = grid.first_vertex + j * grid.samples + i;
                indices.insert(indices.end(), {v, v + 1, v + grid.samples});
                indices.insert(indices.end(), {v + 1, v + grid.samples + 1, v + grid.samples});
            }
        }
    }
    return indices;
}

glm::vec2 position(std::uint32_t vertex) {
    const TerrainGrid& grid = kGrids[vertex >= kGrids[1].first_vertex ? 1 : 0];
    const std::uint32_t k = vertex - grid.first_vertex;
    return grid.origin_m +
           grid.spacing_m * glm::vec2(static_cast<float>(k % grid.samples), static_cast<float>(k / grid.samples));
}

using Triangle = std::array<std::uint32_t, 3>;

std::multiset<Triangle> triangles_of(std::span<const std::uint32_t> indices) {
    std::multiset<Triangle> triangles;
    for (std::size_t t = 0; t < indices.size(); t += 3) {
        triangles.insert({indices[t], indices[t + 1], indices[t + 2]});
    }
    return triangles;
}

TEST(SortTerrainTest, KeepsEveryTriangleAndNeverShowsAFinerTileTooLate) {
    const std::vector<std::uint32_t> indices = all_triangles();
    std::vector<std::uint32_t> sorted(indices.size());
    for (const glm::vec2 camera : {glm::vec2(0.0F), glm::vec2(-390.0F, 200.0F), glm::vec2(5000.0F, 0.0F)}) {
        const std::vector<TerrainRun> runs = sort_terrain(indices, kGrids, camera, sorted);
        EXPECT_EQ(triangles_of(sorted), triangles_of(indices));
        std::uint32_t next = 0;
        for (const TerrainRun& run : runs) {
            EXPECT_EQ(run.first_index, next);
            next += run.index_count;
            for (std::uint32_t i = run.first_index; i < next; ++i) {
                const glm::vec2 at = position(sorted[i]);
                if (run.grid == 1) {
                    EXPECT_LE(std::max(std::abs(at.x), std::abs(at.y)), 50.01F);
                }
                // Far triangles are too far to show the finer tile at any corner.
                if (!run.near) {
                    EXPECT_GT(glm::distance(at, camera), kNearTiles * kDetailTiles[0]);
                }
            }
        }
        EXPECT_EQ(next, indices.size());
    }
}

TEST(SortTerrainTest, RunsKnowTheirDistance) {
    const std::vector<std::uint32_t> indices = all_triangles();
    std::vector<std::uint32_t> sorted(indices.size());
    const glm::vec2 camera(-3000.0F, 500.0F);
    for (const TerrainRun& run : sort_terrain(indices, kGrids, camera, sorted)) {
        for (std::uint32_t i = run.first_index; i < run.first_index + run.index_count; i += 3) {
            const glm::vec2 middle = (position(sorted[i]) + position(sorted[i + 1]) + position(sorted[i + 2])) / 3.0F;
            const float ratio = glm::distance(middle, camera) / run.distance_m;
            EXPECT_LT(std::max(ratio, 1.0F / ratio), std::sqrt(2.0F) * 1.001F);
        }
    }
}

TEST(LevelTest, TexelsAreAboutAPixelWide) {
    EXPECT_EQ(level_at(0.0F, 600.0F, 16.0F), 0.0F);
    EXPECT_EQ(level_at(9600.0F, 600.0F, 16.0F), 0.0F); // a pixel is 16 m wide there
    for (float distance = 9600.0F; distance < 1e6F; distance *= 1.1F) {
        const float texel = 16.0F * std::exp2(level_at(distance, 600.0F, 16.0F));
        EXPECT_LT(std::abs(std::log2(texel / (distance / 600.0F))), 0.501F);
    }
}

TEST(SortTerrainTest, FineTrianglesReadTheFineGrid) {
    const std::vector<std::uint32_t> indices = all_triangles();
    std::vector<std::uint32_t> sorted(indices.size());
    std::uint32_t fine = 0;
    for (const TerrainRun& run : sort_terrain(indices, kGrids, {0.0F, 0.0F}, sorted)) {
        fine += run.grid == 1 ? run.index_count / 3 : 0;
    }
    EXPECT_EQ(fine, 2U * 4U * 4U); // the coarse squares around the middle stick out of the fine grid
}

TEST(TerrainTexelsTest, DecodeToNormalsAndLuminance) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    const TerrainGrid grid{0, 16, 1.0F, {0.0F, 0.0F}};
    std::vector<Vertex> vertices;
    for (int i = 0; i < 256; ++i) {
        Vertex vertex{};
        const glm::vec3 normal(2.0F * unit(random) - 1.0F, 2.0F * unit(random) - 1.0F, 0.3F + unit(random));
        vertex.normal = pack_normal(i == 0 ? glm::vec3(0.0F, 0.0F, 1.0F) : glm::normalize(normal));
        vertex.albedo = pack_albedo({unit(random), unit(random), unit(random)}, unit(random));
        vertices.push_back(vertex);
    }
    const std::vector<std::byte> texels = terrain_texels(vertices, grid);
    ASSERT_EQ(texels.size(), 4U * 256U);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const auto channel = [&](std::size_t k) {
            return static_cast<float>(std::to_integer<int>(texels[4 * i + k])) / 255.0F;
        };
        const glm::vec3 normal = unpack_normal(vertices[i].normal);
        EXPECT_NEAR((255.0F * channel(0) - 128.0F) / 127.0F, normal.x, 1e-5F);
        EXPECT_NEAR((255.0F * channel(1) - 128.0F) / 127.0F, normal.y, 1e-5F);
        const float luminance = glm::dot(unpack_albedo(vertices[i].albedo), glm::vec3(0.2126F, 0.7152F, 0.0722F));
        EXPECT_NEAR(channel(2) * channel(2), luminance, 0.005F);
        EXPECT_FLOAT_EQ(channel(3), static_cast<float>(vertices[i].albedo >> 24U) / 255.0F);
    }
}

TEST(TerrainTexelsTest, ImageCoordinatesHitTexelCentres) {
    for (const TerrainGrid& grid : kGrids) {
        const glm::vec4 map = image_from_position(grid);
        for (std::uint32_t i = 0; i < grid.samples; ++i) {
            const glm::vec2 at = grid.origin_m + grid.spacing_m * static_cast<float>(i);
            const glm::vec2 image = map.x * at + glm::vec2(map.y, map.z);
            EXPECT_NEAR(image.x * static_cast<float>(grid.samples), static_cast<float>(i) + 0.5F, 1e-4F);
            EXPECT_NEAR(image.y * static_cast<float>(grid.samples), static_cast<float>(i) + 0.5F, 1e-4F);
        }
    }
}

// Mean 1/2 in every channel, so that detail changes neither brightness nor slope on the whole; no seam at the border.
TEST(DetailTest, IsNeutralAndRepeats) {
    const std::vector<std::byte> texels = detail_texels();
    ASSERT_EQ(texels.size(), std::size_t{4} * kDetailSize * kDetailSize);
    const auto at = [&](std::uint32_t x, std::uint32_t y, std::size_t k) {
        return std::to_integer<int>(texels[4 * (std::size_t{y} * kDetailSize + x) + k]);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        double sum = 0.0;
        double inner = 0.0;
        double border = 0.0;
        for (std::uint32_t y = 0; y < kDetailSize; ++y) {
            for (std::uint32_t x = 0; x < kDetailSize; ++x) {
                sum += at(x, y, k);
            }
            inner += std::abs(at(200, y, k) - at(201, y, k));
            border += std::abs(at(kDetailSize - 1, y, k) - at(0, y, k));
        }
        EXPECT_NEAR(sum / (double{kDetailSize} * kDetailSize), 127.5, 0.6);
        EXPECT_LT(border, 2.0 * inner);
    }
}

} // namespace
} // namespace alpenglow::sandbox
