// How a probe's irradiance is shown.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "sandbox/world/probe_render_data.hpp"

namespace alpenglow::sandbox {

// Appends a ball whose radius grows with the square root of the irradiance that a surface of that normal gets, relative
// to the mean: `mean_radius_m` where it is the mean. Its colour is what that surface would send back; where the
// irradiance is negative (in luminance) it is red and as large as its amount. A pin marks the direction of the minimum,
// red where it is negative and blue otherwise. `radiance`: nine coefficients, cd/m^2.
void append_probe_display(std::span<const glm::vec3> radiance, const glm::vec3& centre_m, float mean_radius_m,
                          std::vector<ColorVertex>& vertices, std::vector<std::uint32_t>& indices);

} // namespace alpenglow::sandbox
