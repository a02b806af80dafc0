// Impostors: what a designer sets on costly objects and on cameras, and what update_impostors writes.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

namespace alpenglow {

// How an object's picture is kept (docs/impostors.md).
enum class ImpostorKind {
    plane,         // one picture in one plane
    layers,        // one a slab of depth
    depth_warp,    // one picture with depth
    warped_layers, // slabs with depth: the most accurate
};

// Input: an object that is drawn by its picture.
struct Impostor {
    glm::dvec3 centre_m{0.0}; // of its bounding sphere, local frame
    double radius_m = 0.0;    // 0: not drawn
    ImpostorKind kind = ImpostorKind::warped_layers;
    int layers = 8;                               // 1 .. 16; the single-picture kinds take one
    double max_angle_rad = 0.0026179938779914945; // 0.15 degrees: shift of any of its points; plane and layers
    double max_shift_px = 2.0;                    // the same on the screen
    double max_error = 0.01;                      // relative RMSE of its image
    double max_light_error = 0.02;
    double max_content_error = 0.02;
    double content = 0.0; // a clock: move it by the relative change of the image that a change of the object makes
    double phase_g = 0.0; // asymmetry of its scattering, -1 .. 1: how fast turning light changes it
    bool visible = true;
};

// Input, on every camera that shows impostors: the pinhole. right, up, forward: orthonormal, cross(right, up) =
// -forward.
struct ImpostorView {
    glm::dvec3 eye_m{0.0};
    glm::dvec3 right{1.0, 0.0, 0.0};
    glm::dvec3 up{0.0, 0.0, 1.0};
    glm::dvec3 forward{0.0, 1.0, 0.0};
    double tan_left = -1.0, tan_right = 1.0, tan_bottom = -1.0, tan_top = 1.0; // window at distance 1
    int width_px = 0;
    int height_px = 0;
};

// Input, on one entity: the two lights that pictures keep apart. Their colours may change for free; their direction may
// not.
struct ImpostorLight {
    glm::vec3 to_key{0.0F, 0.0F, 1.0F}; // unit vector towards sun or moon
    glm::vec3 key_lux{1.0F};
    glm::vec3 fill_lux{1.0F};
};

// Output of update_impostors, on every entity with Impostor: the worse over all views.
struct ImpostorState {
    std::uint64_t id = 0;       // the scheduler's name for this object
    double error = 0.0;         // of what is shown now, over what is allowed; infinite: nothing to show yet
    bool inside = false;        // some viewer is inside or near: screen-aligned
    std::uint32_t captures = 0; // pictures taken since it exists
};

} // namespace alpenglow
