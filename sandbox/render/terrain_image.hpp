// The terrain's grids as images, and its triangles sorted by the images that they read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

// A texel a vertex, RGBA8, as shaders/passes/terrain_grid.glsl reads it.
[[nodiscard]] std::vector<std::byte> terrain_texels(std::span<const Vertex> vertices, const TerrainGrid& grid);

// From positions to image coordinates: x * position + (y, z), texel centres on vertices.
[[nodiscard]] glm::vec4 image_from_position(const TerrainGrid& grid);

// Sides of the two sizes of the detail's tile, in metres. The finer is seen out to kNearTiles of its sides.
inline constexpr std::array<float, 2> kDetailTiles{22.0F, 700.0F};
inline constexpr float kNearTiles = 5.5F;

// A run of triangles that are drawn alike.
struct TerrainRun {
    std::uint32_t grid = 0;  // the finest that contains the triangles
    bool near = false;       // shows the finer tile
    float distance_m = 0.0F; // of the triangles' middles, within a factor of the square root of 2; near: 0
    std::uint32_t first_index = 0;
    std::uint32_t index_count = 0;
};

// Sorts triangles into runs by octaves of distance, the nearest first. Writes indices.size() indices to `sorted`.
// Distance is taken over the map.
[[nodiscard]] std::vector<TerrainRun> sort_terrain(std::span<const std::uint32_t> indices,
                                                   std::span<const TerrainGrid> grids, glm::vec2 camera_m,
                                                   std::span<std::uint32_t> sorted);

// The mip level whose texels are about as wide as a pixel at that distance, 0 or more, whole.
[[nodiscard]] float level_at(float distance_m, float pixels_per_radian, float texel_m);

} // namespace alpenglow::sandbox
