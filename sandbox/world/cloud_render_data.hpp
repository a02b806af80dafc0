// What a scene with clouds draws beside the landscape (render_data.hpp): plain data, no Vulkan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

inline constexpr int cloud_shadow_size = 112; // texels a side: what fits into the frame's uniform block

// A light's transmittance through clouds, on a map that repeats: texel (i, j) holds it for points whose way to the
// light meets the height `plane_m` at offset_m + extent_m * ((i, j) + 0.5) / size. Points above top_m are in the light,
// those between base_m and top_m partly.
struct CloudShadowMap {
    std::span<const std::uint8_t> texels; // 255: all of the light; rows from the south
    int size = 0;                         // cloud_shadow_size; 0: no map
    float extent_m = 1.0F;
    glm::vec2 offset_m{0.0F};
    float plane_m = 0.0F, base_m = 0.0F, top_m = 0.0F;
    glm::vec3 to_light{0.0F, 0.0F, 1.0F};
    std::uint32_t revision = 0; // of the texels
};

// Words for a storage buffer of the device. Equal revision: equal words but for the first `header`, which are small.
struct CloudTable {
    std::span<const std::uint32_t> words;
    std::size_t header = 0;
    std::uint32_t revision = 0;
};

// A cloud of a picture that the device marches (shaders/alpenglow/cloud.glsl).
struct CloudPlace {
    std::uint32_t volume = 0, light = 0, view = 0;  // of CloudMarch::tables
    glm::vec3 eye{0.0F};                            // voxels from the volume's corner
    glm::vec3 forward{0.0F}, right{0.0F}, up{0.0F}; // of the camera, the grid's frame
    glm::vec3 voxel_m{1.0F};
};

struct CloudMarch {
    std::vector<CloudTable> tables; // the first: detail
    std::vector<CloudPlace> clouds; // in any order
    float tan_half_height = 1.0F;   // of the picture
};

// The clouds' picture, seen with the frame's camera, at reduced resolution. Spans stay valid during draw(). Equal
// revision: equal picture.
struct CloudRenderData {
    int width = 0, height = 0; // pixels, rows from the top
    float scale = 1.0F;        // pixels of the screen a pixel; the picture is centred on the screen
    // Premultiplied radiance, without the air in front, cd/m^2; transmittance of what lies behind; mean distance of
    // what is seen, 0 where there is no cloud.
    std::span<const glm::vec3> radiance_cd_m2;
    std::span<const float> transmittance;
    std::span<const float> distance_m;
    std::span<const float>
        landscape_m;                   // distance to the landscape; 1e30: none. Clouds behind it are not in the picture
    const CloudMarch* march = nullptr; // the device makes the picture: radiance, transmittance and distance are empty
    std::uint32_t revision = 0;
    CloudShadowMap shadow;
};

} // namespace alpenglow::sandbox
