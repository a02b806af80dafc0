// How a probe's irradiance is shown.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "sandbox/world/probe_render_data.hpp"

namespace alpenglow::sandbox {

// Appends a ball whose surface is, towards each direction n, mean_radius_m (1/2 + 1/2 sqrt(|E(n)| / E_mean)) from the
// centre, E being the luminance of the irradiance that a surface of normal n gets. Its colour is what such a surface
// would send back, and red where E is negative. A pin marks the minimum, red where it is negative and blue otherwise.
// `radiance`: nine coefficients, cd/m^2.
void append_probe_display(std::span<const glm::vec3> radiance, const glm::vec3& centre_m, float mean_radius_m,
                          std::vector<ColorVertex>& vertices, std::vector<std::uint32_t>& indices);

} // namespace alpenglow::sandbox
