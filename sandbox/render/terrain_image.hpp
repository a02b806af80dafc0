// The terrain's grids as images, and its triangles sorted by the grid that they read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec4.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

// A texel a vertex, RGBA8, as shaders/passes/terrain_grid.glsl reads it.
[[nodiscard]] std::vector<std::byte> terrain_texels(std::span<const Vertex> vertices, const TerrainGrid& grid);

// From positions to image coordinates: x * position + (y, z), texel centres on vertices.
[[nodiscard]] glm::vec4 image_from_position(const TerrainGrid& grid);

// The triangles in `indices`, those that lie wholly in the finest grid last, and so on down to the coarsest, which
// takes the rest. Writes indices.size() indices to `sorted`; returns the number of indices for each grid.
[[nodiscard]] std::vector<std::uint32_t> sort_by_grid(std::span<const std::uint32_t> indices,
                                                      std::span<const TerrainGrid> grids,
                                                      std::span<std::uint32_t> sorted);

} // namespace alpenglow::sandbox
