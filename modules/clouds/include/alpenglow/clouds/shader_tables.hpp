// What shaders/alpenglow/cloud.glsl reads, as words for storage buffers.
#pragma once

#include <cstdint>
#include <vector>

#include <alpenglow/clouds/march.hpp>

namespace alpenglow::clouds {

// The bricks: uploaded once, for they do not change while the cloud only moves.
[[nodiscard]] std::vector<std::uint32_t> pack_volume(const BrickVolume& volume);

// Optical depths, beam table and medium: uploaded when the light changed.
[[nodiscard]] std::vector<std::uint32_t> pack_light(const BrickVolume& volume, const CloudLighting& lighting);

// Fields contracted for an eye, step and detail, of which the first words alone change with anything but light and eye:
// pack_view() of no fields is what they are.
[[nodiscard]] std::vector<std::uint32_t> pack_view(const BrickVolume& volume, const CloudLighting& lighting,
                                                   const CloudLighting::ViewFields& fields,
                                                   const MarchSettings& settings = {});

// Uploaded once, for all clouds.
[[nodiscard]] std::vector<std::uint32_t> pack_detail(const DetailTexture& texture);

// A camera's position for the shader: voxels from the volume's corner.
[[nodiscard]] glm::vec3 shader_eye(const BrickVolume& volume, const glm::dvec3& eye_m);

} // namespace alpenglow::clouds
