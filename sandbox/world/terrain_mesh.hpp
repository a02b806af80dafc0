// The terrain as vertices for the renderer.
#pragma once

#include "horizon.hpp"
#include "render_data.hpp"
#include "terrain.hpp"

#include <span>

namespace alpenglow::sandbox {

// The outer grid row by row, then the inner grid: the numbering that TerrainLod uses. Without indices.
[[nodiscard]] MeshData make_terrain_mesh(const Terrain& terrain);

// What follows from the heights alone, into vertices that have colour and horizon: positions and normals. An outer
// vertex at an inner one's place becomes its copy, because it is the one drawn.
void shape_terrain_mesh(const Terrain& terrain, std::span<Vertex> vertices);

// The horizon at a point: that of the nearest vertex of the finest grid there.
[[nodiscard]] std::array<std::uint32_t, 4> terrain_horizon(const Terrain& terrain, const MeshData& mesh,
                                                           glm::vec2 position_m);

} // namespace alpenglow::sandbox
