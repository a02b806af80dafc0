// What a rasterizer needs to be a Drawable: the matrix to draw a slab with, and what to make of the pixels.
#pragma once

#include <cstddef>
#include <span>

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/impostors/capture.hpp>

namespace alpenglow::impostors {

// From positions relative to view.eye_m, in the world's axes, to Vulkan's clip space: y down, depth 1 at near_m and 0
// at far_m (0 < near_m < far_m, along the axis). Clipping to a slab's borders leaves what is in it, as a Drawable
// should.
[[nodiscard]] glm::mat4 clip_from_eye(const Frustum& view, double near_m, double far_m);

// The axis depth of that depth.
[[nodiscard]] double axis_depth(double near_m, double far_m, float depth);

// Fills one slab of a request from premultiplied colours and depths of `samples` x `samples` pixels a texel, row 0 on
// top, drawn by clip_from_eye between near_m and far_m: averages, and the moments of what the samples hit. Where alpha
// is 0, depth is not read.
// Opaque surfaces: leave out faces that look away, and draw from a little in front of the slab's border (a tenth of its
// thickness). Layers blend what each has of a texel as if it covered the other by chance; a texel that the border cuts,
// or that an edge and the far side of the same body share, would show a seam. Drawn so, it is whole in the slab behind.
void fill_slab(const CaptureRequest& request, double near_m, double far_m, std::span<const glm::vec4> colour,
               std::span<const float> depth, int samples, SlabImage& image);

} // namespace alpenglow::impostors
