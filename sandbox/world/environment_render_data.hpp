// The background of a scene with an environment map: plain data, no Vulkan.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// Equirectangular, as EnvironmentMap. Spans stay valid during draw(). Equal revision, no upload.
struct EnvironmentRenderData {
    int width = 0;
    int height = 0;
    std::span<const glm::vec3> radiance; // row by row; cd/m^2 once multiplied by `scale`
    float scale = 1.0F;
    float azimuth_rad = 0.0F;
    std::uint32_t revision = 0;
};

} // namespace alpenglow::sandbox
