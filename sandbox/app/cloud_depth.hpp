// The distance to the landscape through each pixel of a small picture, from the triangles that are drawn.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <alpenglow/clouds/view.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

// Along the ray through each pixel's middle, metres; 1e30 where nothing is hit. One thread; deterministic.
void landscape_distance(const clouds::Camera& camera, std::span<const Vertex> vertices,
                        std::span<const std::uint32_t> indices, std::vector<float>& distance_m);

} // namespace alpenglow::sandbox
