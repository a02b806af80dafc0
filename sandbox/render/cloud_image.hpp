// From the clouds' picture to what the device takes: the air in front of them, exposure, the display's encoding, and
// the tiles of the screen that have anything of it.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>

#include "sandbox/render/gpu_data.hpp"
#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {

inline constexpr int cloud_tile = 8; // texels a side

// A corner of a tile: clip space with w = 1.
struct CloudVertex {
    glm::vec2 place;
    float depth; // reversed: that of the nearest cloud in the tile, so that what stands in front of all of it hides it
};

struct CloudImage {
    // Premultiplied, rows from the top. Display colours in 8 bits, or exposed radiance in half floats.
    std::vector<std::byte> texels;
    std::vector<CloudVertex> vertices; // two triangles a tile, whole
};

// `block`: of the same frame. `for_display`: 8-bit display colours; otherwise half floats.
[[nodiscard]] CloudImage make_cloud_image(const CloudRenderData& clouds, const FrameData& frame,
                                          const gpu::FrameBlock& block, std::uint32_t screen_width,
                                          std::uint32_t screen_height, bool for_display);

} // namespace alpenglow::sandbox
