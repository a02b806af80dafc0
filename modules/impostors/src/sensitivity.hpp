#pragma once

#include <alpenglow/impostors/capture.hpp>

namespace alpenglow::impostors {

// Measures how a finished capture answers to motion of the eye (error.hpp, predicted_error).
[[nodiscard]] Sensitivity measure_sensitivity(const Capture& capture);

} // namespace alpenglow::impostors
