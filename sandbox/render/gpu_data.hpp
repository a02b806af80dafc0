// From the contract's physical quantities to what shaders read.
#pragma once

#include <array>
#include <cstdint>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

namespace gpu {
using glm::mat4;
using glm::uvec4;
using glm::vec4;
#include <shaders/passes/frame_block.h>

// One visible object.
struct Instance {
    vec4 world_row_x, world_row_y, world_row_z; // rows of world_from_object
    std::array<std::uint32_t, 4> horizon;
};
} // namespace gpu

// What the air and the moon take from the sky dome, in cd/m^2.
struct SkyExtract {
    std::array<glm::vec3, 33> horizon{}; // entry i at sin(azimuth from the sky's light / 2) = i / 16 - 1
    glm::vec3 at_moon{0.0F};
};
// With no sky vertices, air_radiance_cd_m2 everywhere.
[[nodiscard]] SkyExtract extract_sky(const FrameData& frame);

// The projection with depth reversed (1 near, 0 far), which spreads the precision of floats evenly over distance.
[[nodiscard]] glm::mat4 reversed_depth(const glm::mat4& projection);

// From directions relative to the camera to clip space, with reversed depth.
[[nodiscard]] glm::mat4 clip_from_relative(const FrameData& frame);

// Pixels per radian in the middle of an image of that height.
[[nodiscard]] float pixels_per_radian(const FrameData& frame, std::uint32_t height_px);

// Mean over the disc of the cosine of the light's incidence on a Lambertian ball, at cos(phase angle): 2/3 when full, 0
// when new: 2 (sin a + (pi - a) cos a) / (3 pi).
[[nodiscard]] float moon_disc_mean_cosine(float cos_phase);

// True if the moon gives more light than the sun: then it throws the shadows.
[[nodiscard]] bool moon_is_key(const FrameData& frame);

// From directions relative to the camera to the shadow map's clip space: an orthographic view along the key light,
// around a place in front of the camera, moved in whole texels so that edges do not crawl.
[[nodiscard]] glm::mat4 shadow_from_relative(const FrameData& frame, std::uint32_t size_px);

[[nodiscard]] gpu::FrameBlock make_frame_block(const FrameData& frame, const SkyExtract& sky, std::uint32_t height_px);

[[nodiscard]] gpu::Instance make_instance(const ObjectInstance& object);

} // namespace alpenglow::sandbox
