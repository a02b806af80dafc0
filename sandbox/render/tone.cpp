#include "sandbox/render/tone.hpp"

#include <glm/common.hpp>
#include <glm/exponential.hpp>

namespace alpenglow::sandbox {
namespace tone {

using glm::clamp;
using glm::max;
using glm::min;
using glm::sqrt;
using glm::vec3;

namespace {
#include <shaders/passes/tone.glsl>
} // namespace

} // namespace tone

glm::vec3 display(glm::vec3 exposed_radiance) {
    return tone::display(exposed_radiance);
}

} // namespace alpenglow::sandbox
