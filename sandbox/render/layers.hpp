// The layers of a frame, in the order in which they draw.
#pragma once

#include <memory>
#include <vector>

#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

[[nodiscard]] std::vector<std::unique_ptr<Layer>> make_layers(const LayerContext& context);

} // namespace alpenglow::sandbox
