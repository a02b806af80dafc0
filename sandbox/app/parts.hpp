// What a scene is made of beside sky and landscape.
#pragma once

#include <memory>
#include <vector>

#include "sandbox/app/part.hpp"
#include "sandbox/scene/scene.hpp"

namespace alpenglow::sandbox {

// In the order of a frame. A scene gets the parts that it names.
[[nodiscard]] std::vector<std::unique_ptr<Part>> make_parts(Stage& stage, const Scene& scene);

} // namespace alpenglow::sandbox
