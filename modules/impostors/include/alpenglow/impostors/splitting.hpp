// Objects inside clouds, and clouds inside clouds: what to draw after what (003, section 3.2).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <alpenglow/impostors/geometry.hpp>

namespace alpenglow::impostors {

// One draw: an object, or the part of a volume between two axis depths of the view (DrawSettings::near_m, far_m).
struct OrderedItem {
    bool object = false;
    std::size_t index = 0; // into the volumes or objects given
    double near_m = 0.0;
    double far_m = 0.0;
};

struct SplitSettings {
    int most_slices = 16; // of one volume; past that the closest cuts go
    int interleave = 4;   // slices of the depth that two overlapping volumes share
};

// Everything back to front. A volume is cut at the depth of the centre of each object that its bounds touch, and
// through the depths that it shares with each volume that its bounds touch; pieces tile its depth without gap. What
// does not touch is never cut: of disjoint spheres the one with the smaller power (distance^2 - radius^2) of the eye is
// in front, on every ray (their radical plane lies between them). Opaque objects need no cut if the draw is given the
// scene's depth: this is for translucent ones, and for objects that are drawn between pieces as in the paper. What lies
// wholly behind the eye's plane is left out. Bounds must be finite.
[[nodiscard]] std::vector<OrderedItem> order_back_to_front(std::span<const Sphere> volumes,
                                                           std::span<const Sphere> objects, const Frustum& view,
                                                           const SplitSettings& settings = {});

} // namespace alpenglow::impostors
