// How a frame is drawn.
#pragma once

namespace alpenglow::sandbox {

// `lean` for the CPU (light per vertex, one pass), `full` for a GPU (shadow map, light per pixel, half-float target
// resolved by a second pass); `automatic` chooses by device.
enum class Quality { automatic, lean, full };

} // namespace alpenglow::sandbox
