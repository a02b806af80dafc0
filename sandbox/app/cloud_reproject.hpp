// A picture of clouds from a few of its rays: the rest is what the last picture showed of the same places.
#pragma once

#include <cstddef>
#include <span>

#include <glm/vec2.hpp>

#include <alpenglow/clouds/view.hpp>

namespace alpenglow::sandbox {

// Pixels of a picture: every n-th each way, from `first` (0 .. n - 1 each way) on.
struct PixelLattice {
    int n = 1;
    glm::ivec2 first{0};
};

// The lattices of one n in the order in which they are marched, so that n^2 of them in a row are all pixels and
// neighbours in time are no neighbours in the picture. n: 1, 2 or 3.
[[nodiscard]] PixelLattice lattice_of(int n, int turn);

// A camera for a lattice of `camera`'s picture: its pixel (i, j) looks along pixel n (i, j) + first. Its axes are not
// orthonormal: the forward one is turned by a part of a pixel.
[[nodiscard]] clouds::Camera lattice_camera(const clouds::Camera& camera, const PixelLattice& lattice);

struct PictureBefore {
    const clouds::Picture& picture;
    const clouds::Camera& camera;
    std::span<const float> landscape_m; // as below, of that picture
};

// Fills `out`: the lattice's pixels from `fresh` (marched with lattice_camera()), the others from the picture before,
// at the place that the fresh ones around and the picture before itself say they show, held to within what the fresh
// ones around show or a quarter of their range outside it. Where the picture before does not have that place, for it
// was beyond its border or behind the landscape, the fresh ones are interpolated. `landscape_m`: distance of the
// landscape through each pixel of `out`, 1e30: none. Returns the pixels that were interpolated.
std::size_t complete_picture(const clouds::Picture& fresh, const PixelLattice& lattice, const PictureBefore& before,
                             const clouds::Camera& camera, std::span<const float> landscape_m, clouds::Picture& out);

} // namespace alpenglow::sandbox
