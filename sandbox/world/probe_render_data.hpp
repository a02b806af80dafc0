// What a scene with light probes draws beside the landscape (render_data.hpp): plain data, no Vulkan.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace alpenglow::sandbox {

// A vertex that brings its own light.
struct ColorVertex {
    glm::vec3 position_m;
    glm::vec4 light; // rgb: radiance in cd/m^2 where w is 0; a symbol's colour, whatever the exposure, where w is 1
};

// Spans stay valid during draw(). Equal revision, no upload.
struct ColorMesh {
    std::span<const ColorVertex> vertices;
    std::span<const std::uint32_t> indices; // triangles, counter-clockwise from outside
    std::uint32_t revision = 0;
};

// A ball that sends back the light of its own probe: radiance on SH of order 3 by the surface's normal, cd/m^2, albedo
// and cosine included. Values below 0 show as black.
struct LitSphere {
    glm::vec3 centre_m;
    float radius_m;
    std::array<glm::vec3, 9> radiance;
    float padding = 0.0F; // the device reads whole vec4s
};

struct ProbeRenderData {
    ColorMesh yard;
    // What shows probes, and what they light: not there for a probe that looks around itself.
    ColorMesh display;
    std::span<const LitSphere> spheres; // likewise valid during draw()
    std::uint32_t spheres_revision = 0;
};

} // namespace alpenglow::sandbox
