#include <alpenglow/impostors/geometry.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::impostors {
namespace {

// right and up for a unit forward; the hint may be anything.
void complete_axes(Frustum& frustum, const glm::dvec3& up_hint) {
    glm::dvec3 right = glm::cross(frustum.forward, up_hint);
    const double hint = glm::length(up_hint);
    if (!(glm::length(right) > 1e-6 * hint)) { // parallel, zero or NaN
        const glm::dvec3 other =
            std::abs(frustum.forward.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
        right = glm::cross(frustum.forward, other);
    }
    frustum.right = glm::normalize(right);
    frustum.up = glm::cross(frustum.right, frustum.forward);
}

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Range of tangents x / z of the circle that a sphere at (x, z) leaves in the plane of one picture axis and forward.
// False where the sphere reaches behind the eye's plane.
bool tangent_range(double x, double z, double radius, double& least, double& greatest) {
    // (x - m z)^2 = r^2 (1 + m^2): lines through the eye that touch the circle.
    const double a = z * z - radius * radius;
    if (z <= radius || a <= 0.0) {
        return false;
    }
    const double root = radius * std::sqrt(std::max(0.0, x * x + a));
    least = (x * z - root) / a;
    greatest = (x * z + root) / a;
    return true;
}

} // namespace

Sphere bounding_sphere(const Box& box) {
    return {0.5 * (box.least_m + box.greatest_m), 0.5 * glm::length(box.greatest_m - box.least_m)};
}

Frustum look_at(const glm::dvec3& eye_m, const glm::dvec3& target_m, const glm::dvec3& up_hint, double fov_y_rad,
                int width, int height) {
    assert(fov_y_rad > 0.0 && fov_y_rad < 3.14159265358979 && width > 0 && height > 0);
    Frustum view;
    view.eye_m = eye_m;
    const glm::dvec3 towards = target_m - eye_m;
    const double distance = glm::length(towards);
    view.forward = distance > 0.0 ? towards / distance : glm::dvec3(0.0, 1.0, 0.0);
    complete_axes(view, up_hint);
    view.tan_top = std::tan(0.5 * fov_y_rad);
    view.tan_bottom = -view.tan_top;
    view.tan_right = view.tan_top * width / height;
    view.tan_left = -view.tan_right;
    view.width = width;
    view.height = height;
    return view;
}

std::optional<Frustum> fit_frustum(const Sphere& bounds, const glm::dvec3& eye_m, const glm::dvec3& up_hint, int texels,
                                   double widest_tan) {
    assert(texels >= 3);
    const glm::dvec3 towards = bounds.centre_m - eye_m;
    const double distance = glm::length(towards);
    if (!finite(towards) || !(bounds.radius_m >= 0.0) || !(distance > bounds.radius_m)) {
        return std::nullopt;
    }
    // (d - R)(d + R) keeps its digits next to the sphere. A sphere of no size still gets a window of its own.
    const double tangent =
        std::max(bounds.radius_m / std::sqrt((distance - bounds.radius_m) * (distance + bounds.radius_m)), 1e-12);
    const double half = tangent * texels / (texels - 2.0);
    if (!(half <= widest_tan)) {
        return std::nullopt;
    }
    Frustum frustum;
    frustum.eye_m = eye_m;
    frustum.forward = towards / distance;
    complete_axes(frustum, up_hint);
    frustum.tan_left = frustum.tan_bottom = -half;
    frustum.tan_right = frustum.tan_top = half;
    frustum.width = frustum.height = texels;
    return frustum;
}

std::optional<Frustum> fit_frustum(const Box& bounds, const glm::dvec3& eye_m, const glm::dvec3& up_hint, int texels,
                                   double widest_tan) {
    assert(texels >= 3);
    const glm::dvec3 towards = 0.5 * (bounds.least_m + bounds.greatest_m) - eye_m;
    const double distance = glm::length(towards);
    if (!finite(towards) || !finite(bounds.least_m) || !(distance > 0.0)) {
        return std::nullopt;
    }
    Frustum frustum;
    frustum.eye_m = eye_m;
    frustum.forward = towards / distance;
    complete_axes(frustum, up_hint);
    double left = widest_tan, right = -widest_tan, bottom = widest_tan, top = -widest_tan;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p = glm::dvec3((corner & 1) != 0 ? bounds.greatest_m.x : bounds.least_m.x,
                                        (corner & 2) != 0 ? bounds.greatest_m.y : bounds.least_m.y,
                                        (corner & 4) != 0 ? bounds.greatest_m.z : bounds.least_m.z) -
                             eye_m;
        const double z = glm::dot(p, frustum.forward);
        const double x = glm::dot(p, frustum.right);
        const double y = glm::dot(p, frustum.up);
        if (!(z > 0.0) || !(std::max(std::abs(x), std::abs(y)) < widest_tan * z)) {
            return std::nullopt;
        }
        left = std::min(left, x / z);
        right = std::max(right, x / z);
        bottom = std::min(bottom, y / z);
        top = std::max(top, y / z);
    }
    // Square texels: the smaller side gets as many as it needs, and the window grows to whole texels with one of
    // border.
    const double size = std::max({right - left, top - bottom, 1e-12});
    const double texel = size / (texels - 2);
    const auto fit = [texel, texels](double& low, double& high) {
        const int inside = std::clamp(static_cast<int>(std::ceil((high - low) / texel - 1e-9)), 1, texels - 2);
        const double middle = 0.5 * (low + high);
        const double half = 0.5 * texel * (inside + 2);
        low = middle - half;
        high = middle + half;
        return inside + 2;
    };
    frustum.width = fit(left, right);
    frustum.height = fit(bottom, top);
    frustum.tan_left = left;
    frustum.tan_right = right;
    frustum.tan_bottom = bottom;
    frustum.tan_top = top;
    return frustum;
}

Frustum screen_aligned(const Frustum& view, double downscale, double margin) {
    assert(downscale >= 1.0 && margin >= 0.0);
    Frustum result = view;
    result.width = std::max(1, static_cast<int>(std::ceil(view.width * (1.0 + 2.0 * margin) / downscale)));
    result.height = std::max(1, static_cast<int>(std::ceil(view.height * (1.0 + 2.0 * margin) / downscale)));
    const double wider = margin * (view.tan_right - view.tan_left);
    const double taller = margin * (view.tan_top - view.tan_bottom);
    result.tan_left -= wider;
    result.tan_right += wider;
    result.tan_bottom -= taller;
    result.tan_top += taller;
    return result;
}

DepthRange depth_range(const Sphere& bounds, const Frustum& view) {
    const double centre = glm::dot(bounds.centre_m - view.eye_m, view.forward);
    return {centre - bounds.radius_m, centre + bounds.radius_m};
}

PixelRect visible_rect(const Sphere& bounds, const Frustum& view) {
    const glm::dvec3 p = bounds.centre_m - view.eye_m;
    if (!finite(p) || !(bounds.radius_m >= 0.0)) {
        return {};
    }
    const double x = glm::dot(p, view.right);
    const double y = glm::dot(p, view.up);
    const double z = glm::dot(p, view.forward);
    if (z <= -bounds.radius_m) {
        return {};
    }
    double left = view.tan_left, right = view.tan_right, bottom = view.tan_bottom, top = view.tan_top;
    double least = 0.0;
    double greatest = 0.0;
    if (tangent_range(x, z, bounds.radius_m, least, greatest)) {
        left = std::max(left, least);
        right = std::min(right, greatest);
        if (tangent_range(y, z, bounds.radius_m, least, greatest)) {
            bottom = std::max(bottom, least);
            top = std::min(top, greatest);
        }
    } else {
        // Reaches behind the eye: test the four side planes, and give all of the view if none has it outside.
        const auto outside = [r = bounds.radius_m](double along, double depth, double tangent, double sign) {
            return sign * (along - tangent * depth) > r * std::sqrt(1.0 + tangent * tangent);
        };
        if (outside(x, z, view.tan_right, 1.0) || outside(x, z, view.tan_left, -1.0) ||
            outside(y, z, view.tan_top, 1.0) || outside(y, z, view.tan_bottom, -1.0)) {
            return {};
        }
    }
    if (left > right || bottom > top) {
        return {};
    }
    const auto pixel = [](double v, int size) { return static_cast<int>(std::clamp(v, 0.0, double(size))); };
    PixelRect rect;
    rect.x0 = pixel(std::floor((left - view.tan_left) * view.pixels_per_tan_x()), view.width);
    rect.x1 = pixel(std::floor((right - view.tan_left) * view.pixels_per_tan_x()) + 1.0, view.width);
    rect.y0 = pixel(std::floor((view.tan_top - top) * view.pixels_per_tan_y()), view.height);
    rect.y1 = pixel(std::floor((view.tan_top - bottom) * view.pixels_per_tan_y()) + 1.0, view.height);
    return rect;
}

} // namespace alpenglow::impostors
