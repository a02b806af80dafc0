// What the files of SkyState share.
#pragma once

#include <alpenglow/components/sky.hpp>
#include <alpenglow/sky/dome.hpp>

namespace alpenglow::sky {

// The relative change of the scattering sky with the observer's height, per metre, at most: aerosol thins by e in 1.2
// km, and with a low sun half a kilometre changes the light near the horizon by a factor.
inline constexpr double height_rate_per_m = 5e-3;

[[nodiscard]] DomeParameters dome_parameters(const Atmosphere& atmosphere, const glm::vec3& to_light);
[[nodiscard]] double altitude_rad(const glm::vec3& direction);
// The same sky, as far as the model looks.
[[nodiscard]] bool same_air(const Atmosphere& a, const Atmosphere& b);

} // namespace alpenglow::sky
