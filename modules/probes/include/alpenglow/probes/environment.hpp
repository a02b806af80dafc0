// Environment maps: equirectangular images in files, and their light on spherical harmonics.
#pragma once

#include <alpenglow/components/environment_map.hpp>
#include <alpenglow/core/result.hpp>

#include <cstddef>
#include <filesystem>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

// Reads a Radiance .hdr file (RGBE, run-length coded or flat) as an equirectangular map of order `order`. The Error
// names the file and what is wrong with it: missing, not a Radiance file, a header without size or with one of 0, data
// that end early or say what no image can, more than max_bytes of pixels.
[[nodiscard]] Result<EnvironmentMap> load_environment(const std::filesystem::path& file, int order = 3,
                                                      std::size_t max_bytes = std::size_t{1} << 30U);

// Names the field that is out of range, if one is: the size, the number of pixels, the first pixel that is negative or
// not finite, scale, azimuth, order.
[[nodiscard]] Status check(const EnvironmentMap& map);

// Radiance coefficients of a map that has passed check(), in the local frame, not deringed: order * order values. Each
// pixel counts as constant over its own solid angle, and the basis is integrated over it (sh/image.hpp).
void project_environment(const EnvironmentMap& map, std::span<glm::vec3> out);

// Radiance towards a unit vector, cd/m^2: the background. Bilinear; seamless across u = 0 and held at the poles.
[[nodiscard]] glm::vec3 environment_radiance(const EnvironmentMap& map, const glm::vec3& direction);

} // namespace alpenglow::probes
