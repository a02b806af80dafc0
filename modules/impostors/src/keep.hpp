// What capture() keeps of the images that a Drawable leaves: the vectorised way, and the plain one that a test holds it
// to.
#pragma once

#include <cstddef>
#include <span>

#include <alpenglow/impostors/capture.hpp>

namespace alpenglow::impostors {

[[nodiscard]] inline bool single_picture(Representation r) {
    return r == Representation::plane || r == Representation::depth_warp;
}
[[nodiscard]] inline bool warped_kind(Representation r) {
    return r == Representation::depth_warp || r == Representation::warped_layers;
}

// Makes texels finite and physical: 0 <= alpha <= 1, radiance >= 0, moments of a distribution on [-1, 1]. Returns how
// many were not. `fill` may be empty.
std::size_t sanitise(std::span<glm::vec4> colour, std::span<glm::vec3> fill, std::span<glm::vec2> depth);

// The axis depth of a layer's plane, from the sums over its texels of alpha and of alpha x s.
[[nodiscard]] double plane_of(const Capture& capture, double near_m, double far_m, double alpha, double depth);

// Fills layers, sensitivity, mean and rejected_texels of a capture whose other fields are set. Images are of the right
// size, and used up.
void keep(Capture& capture, std::span<const double> edges_m, const CaptureSettings& settings,
          std::span<SlabImage> slabs);
void keep_scalar(Capture& capture, std::span<const double> edges_m, const CaptureSettings& settings,
                 std::span<SlabImage> slabs);

} // namespace alpenglow::impostors
