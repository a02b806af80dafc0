// What the dome models leave open: the sky's brightness while the sun sets and after, and the night's floor.
#pragma once

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// The factor on a dome model whose sun is held at the horizon: 1 for a sun above 10 degrees, exactly 0 from -18 degrees
// down, monotone and continuously differentiable in between. `sun_altitude_rad` is the geometric altitude.
// Preetham's model gives about ten times too much light at sunset (docs/sky.md); the factor brings its horizontal
// illuminance at turbidity 2.5 onto the curve of Janiczek and DeYoung (USNO Circular 171, 1987): 3.4 lux at -6 degrees,
// 8e-3 at -12, and the zenith to 270 cd/m^2 at sunset.
[[nodiscard]] double twilight_fade(double sun_altitude_rad);

// Radiance of a clear, moonless night sky far from towns, taken as uniform: airglow, starlight and zodiacal light,
// 2.2e-4 cd/m^2, which gives 7e-4 lux on the ground.
[[nodiscard]] glm::dvec3 night_floor_cd_m2();

} // namespace alpenglow::sky
