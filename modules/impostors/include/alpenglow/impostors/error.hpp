// How wrong a picture is by now: what update_impostors compares with its tolerances. Angles come from atan2 of lengths
// and products, never from acos: they hold their digits down to 1e-9 rad and below.
#pragma once

#include <glm/vec3.hpp>

#include <alpenglow/impostors/capture.hpp>
#include <alpenglow/impostors/geometry.hpp>

namespace alpenglow::impostors {

// Angle between two directions of any length, by Kahan's form; 0 where either is zero.
[[nodiscard]] double angle_between(const glm::dvec3& a, const glm::dvec3& b);

// The translation error of 003, figure 11 (Schaufler 1995), as the largest angle, seen from `eye`, between any point P
// of the bounds and the place Q that a picture taken from `capture_eye` shows it at: Q lies on the ray from capture_eye
// through P, in the plane through the centre. With p = |P - c|, q = |Q - c|, b = |e - c| and beta the angle between the
// ray and the motion, tan phi = |p - q| b sin beta / (p q - (p + q) b cos beta + b^2), which is stable; the largest
// over beta has a closed form and the largest over rays is sought. Forward motion (Schaufler's zoom error) is in it.
// With more `planes` P and Q are never farther apart than half a slab. pi where the eye is inside the bounds or on
// them, and wherever the picture cannot hold.
[[nodiscard]] double translation_angle(const Sphere& bounds, const glm::dvec3& capture_eye_m, const glm::dvec3& eye_m,
                                       int planes = 1);

// No less than translation_angle, in a tenth of its time: b R / ((d - R - b) (d - b)) for one plane, with b the way
// from the capture's eye, at distance d from the centre. pi where that says nothing.
[[nodiscard]] double translation_angle_quick(const Sphere& bounds, const glm::dvec3& capture_eye_m,
                                             const glm::dvec3& eye_m, int planes = 1);

// The zoom error alone: the angle by which a point at the rim of the sphere's front or back moves against the middle
// plane when the eye goes straight ahead from distance `capture_m` to `distance_m`.
[[nodiscard]] double zoom_angle(double radius_m, double capture_m, double distance_m);

// Pixels a radian of a view, at its most, over what it shows of the bounds: (1 + tan^2) at the farthest corner from the
// axis.
[[nodiscard]] double pixels_per_radian(const Frustum& view, const Sphere& bounds);

// Texels that a tile needs so that each is at most one pixel of the view (003, equation 11, with object size over
// distance exact for a sphere): the side of fit_frustum's square.
[[nodiscard]] int required_texels(const Frustum& view, const Sphere& bounds, const glm::dvec3& eye_m);

// required_texels over what the picture has: past 1 it is magnified.
[[nodiscard]] double resolution_ratio(const Capture& capture, const Frustum& view);

// Relative change of the image since the lights moved: colour changes are made good by light_gain, so that what is left
// is the key light's turn, times the steepest relative slope of shading: that of Henyey and Greenstein's phase
// function, 3 g / (1 - g^2), plus 1 for the slow rest (a cosine, self-shadows). Infinite where a light that was dark
// shines.
[[nodiscard]] double light_error(const Lights& captured, const Lights& now, double phase_g);

// The same for the viewer's own turn about the object, in which the phase function changes and the picture does not.
[[nodiscard]] double view_shading_error(const Sphere& bounds, const glm::dvec3& capture_eye_m, const glm::dvec3& eye_m,
                                        double phase_g);

// The object's own change: `content` is a clock that it moves forward by the relative RMSE of its image that its change
// amounts to (animation, growth); 1 and more: another object.
[[nodiscard]] double content_error(double captured, double now);

// Relative RMSE (of radiance or alpha, the worse) that this very picture is expected to have from `eye`. A texel of
// layer k at inverse depth w lies off its layer's surface by a residual rho with known second moment (from the depth
// moments); a translation t of the eye then shifts it by rho (-t_xy + (x, y) t_z) against its true place, which costs
// its gradient times that. Squares summed over texels, behind the transmittance in front, over the image's energy, give
// t^T M t with M measured once at capture; resampling adds its own. `safety` is on top.
[[nodiscard]] double predicted_error(const Capture& capture, const glm::dvec3& eye_m, double safety = 1.0);

// The largest downscale of 1, 2, 4, 8 whose bilinear blur is expected to stay within max_error, from what the last
// capture at `last_downscale` measured (curvature error grows with the square of the texel): the viewer inside.
[[nodiscard]] double choose_downscale(const Sensitivity& last, double last_downscale, double max_error);

} // namespace alpenglow::impostors
