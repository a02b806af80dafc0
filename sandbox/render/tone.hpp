// The display's tone curve on the CPU, from the shaders' own source.
#pragma once

#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// From radiance times exposure to what a display takes, 0 .. 1.
[[nodiscard]] glm::vec3 display(glm::vec3 exposed_radiance);

} // namespace alpenglow::sandbox
