// Pictures of clouds that stand in for them (render_data.hpp): plain data, no Vulkan.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "sandbox/world/probe_render_data.hpp"

namespace alpenglow::sandbox {

// One layer of a picture that has changed, to be copied into the atlas.
struct ImpostorTile {
    int x = 0, y = 0;                  // texels, of its upper left corner in the atlas
    int width = 0, height = 0;         // texels
    std::span<const glm::vec4> texels; // premultiplied radiance, cd/m^2, and alpha
    glm::vec3 gain{1.0F};              // on the radiance
};

// Pictures are drawn on meshes bent to the depth of what they show. Where one takes over from another, both are read:
// their weights sum to 1.
struct ImpostorVertex {
    glm::vec3 position_m;
    glm::vec2 texel;    // of the atlas, in texels
    glm::vec2 before;   // in the picture that goes
    glm::vec2 weights;  // of the two
    float share = 1.0F; // of the optical depth: below 1 where something divides a layer
};

// Triangles that are drawn with one pipeline.
struct ImpostorRun {
    enum Kind : std::uint8_t { plain, fading, divided };
    std::uint32_t first_index = 0;
    std::uint32_t index_count = 0;
    Kind kind = plain;
};

// Spans stay valid during draw(). Equal revision, no upload.
struct ImpostorRenderData {
    int atlas_width = 0, atlas_height = 0;
    std::span<const ImpostorTile> tiles; // what has changed since the frame before
    std::uint32_t tiles_revision = 0;
    std::span<const ImpostorVertex> vertices;
    std::span<const std::uint32_t> indices;
    std::span<const ImpostorRun> runs; // from far to near
    std::uint32_t mesh_revision = 0;
    // What flies among the clouds: triangles with their own light, opaque.
    std::span<const ColorVertex> craft;
    std::uint32_t craft_revision = 0;
    std::span<const ColorVertex> outlines; // pairs of ends
    std::uint32_t outlines_revision = 0;
};

} // namespace alpenglow::sandbox
