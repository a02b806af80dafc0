// Where an impostor's picture is taken from: the frustum tight on what it shows.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

namespace alpenglow::impostors {

struct Sphere {
    glm::dvec3 centre_m{0.0};
    double radius_m = 0.0;
};

// Axis-aligned.
struct Box {
    glm::dvec3 least_m{0.0};
    glm::dvec3 greatest_m{0.0};
};

// A pinhole camera with a window of width x height pixels in the plane at distance 1 along `forward`; the window may be
// off centre. right, up and forward are orthonormal with cross(right, up) = -forward. Row 0 is the upper one.
struct Frustum {
    glm::dvec3 eye_m{0.0};
    glm::dvec3 right{1.0, 0.0, 0.0};
    glm::dvec3 up{0.0, 0.0, 1.0};
    glm::dvec3 forward{0.0, 1.0, 0.0};
    double tan_left = -1.0, tan_right = 1.0, tan_bottom = -1.0, tan_top = 1.0;
    int width = 0;  // pixels
    int height = 0; // pixels

    [[nodiscard]] double pixels_per_tan_x() const { return width / (tan_right - tan_left); }
    [[nodiscard]] double pixels_per_tan_y() const { return height / (tan_top - tan_bottom); }
    // Direction through the point x, y of the picture in pixels (centres at halves), not normalised: its component
    // along forward is 1.
    [[nodiscard]] glm::dvec3 direction(double x, double y) const {
        return forward + (tan_left + (tan_right - tan_left) * x / width) * right +
               (tan_top - (tan_top - tan_bottom) * y / height) * up;
    }
};

[[nodiscard]] Sphere bounding_sphere(const Box& box);

// A camera looking from `eye` towards `target` with square pixels; fov is the full vertical angle, inside (0, pi).
[[nodiscard]] Frustum look_at(const glm::dvec3& eye_m, const glm::dvec3& target_m, const glm::dvec3& up_hint,
                              double fov_y_rad, int width, int height);

// The symmetric square frustum tight on the sphere: half its window is R / sqrt(d^2 - R^2), plus one texel of border so
// that filtering meets transparency at the rim (`texels` >= 3 a side). Empty where the eye is inside the sphere, on it,
// or so close that a texel at the rim would see more than `widest_tan` (the viewer-inside case: see screen_aligned).
[[nodiscard]] std::optional<Frustum> fit_frustum(const Sphere& bounds, const glm::dvec3& eye_m,
                                                 const glm::dvec3& up_hint, int texels, double widest_tan = 8.0);

// The frustum towards the box's centre, tight on the eight corners; the larger side of the window gets `texels`.
[[nodiscard]] std::optional<Frustum> fit_frustum(const Box& bounds, const glm::dvec3& eye_m, const glm::dvec3& up_hint,
                                                 int texels, double widest_tan = 8.0);

// The view itself at 1 / downscale of its resolution in each dimension (rounded up): the impostor of a viewer inside
// (003, section 3.1: 4). `margin` widens the window by that fraction on each side, so that a turn of the head between
// captures meets a picture.
[[nodiscard]] Frustum screen_aligned(const Frustum& view, double downscale, double margin = 0.0);

// Axis depths between which the sphere lies as seen by a frustum: centre - radius .. centre + radius along forward.
struct DepthRange {
    double near_m = 0.0;
    double far_m = 0.0;
};
[[nodiscard]] DepthRange depth_range(const Sphere& bounds, const Frustum& view);

// Pixels [x0, x1) x [y0, y1) of a view.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
};
// A rectangle that holds everything of the sphere that the view can see; empty if there is none; the whole view if the
// eye is inside.
[[nodiscard]] PixelRect visible_rect(const Sphere& bounds, const Frustum& view);

} // namespace alpenglow::impostors
