// What shaders/alpenglow/cloud.glsl reads, as words for storage buffers.
#pragma once

#include <cstdint>
#include <vector>

#include <alpenglow/clouds/march.hpp>

namespace alpenglow::clouds {

// The bricks: uploaded once, for they do not change while the cloud only moves.
[[nodiscard]] std::vector<std::uint32_t> pack_volume(const BrickVolume& volume);

// Optical depths, fields contracted for an eye (world, metres), beam table and step: uploaded when light or eye
// changed.
[[nodiscard]] std::vector<std::uint32_t> pack_light(const BrickVolume& volume, const CloudLighting& lighting,
                                                    const glm::dvec3& eye_m, const MarchSettings& settings = {});

// A camera's position for the shader: voxels from the volume's corner.
[[nodiscard]] glm::vec3 shader_eye(const BrickVolume& volume, const glm::dvec3& eye_m);

} // namespace alpenglow::clouds
