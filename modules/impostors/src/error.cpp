#include <alpenglow/impostors/error.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace alpenglow::impostors {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// The angle at the eye between points at p and q on one ray from the capture's eye, b away, with beta between ray and
// motion free in [least, greatest]: the largest. d(phi)/d(beta) = 0 where cos beta = (p + q) b / (p q + b^2).
double widest_angle(double p, double q, double b, double least, double greatest) {
    const double a = p * q + b * b;
    const double c = (p + q) * b;
    const double root = (p - b) * (p + b) * (q - b) * (q + b); // a^2 - c^2, without cancellation
    const double beta = std::clamp(std::atan2(std::sqrt(std::max(0.0, root)), c), least, greatest);
    return std::atan2(std::abs(p - q) * b * std::sin(beta), a - c * std::cos(beta));
}

} // namespace

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    const double la = glm::length(a);
    const double lb = glm::length(b);
    if (!(la > 0.0) || !(lb > 0.0)) {
        return 0.0;
    }
    const glm::dvec3 u = a / la;
    const glm::dvec3 v = b / lb;
    return 2.0 * std::atan2(glm::length(u - v), glm::length(u + v));
}

double translation_angle(const Sphere& bounds, const glm::dvec3& capture_eye_m, const glm::dvec3& eye_m, int planes) {
    const double pi = std::numbers::pi;
    const glm::dvec3 axis = bounds.centre_m - capture_eye_m;
    const glm::dvec3 motion = eye_m - capture_eye_m;
    const double r = bounds.radius_m;
    const double d = glm::length(axis);
    const double b = glm::length(motion);
    if (b == 0.0) {
        return d > r ? 0.0 : pi;
    }
    if (!(d > r) || !(glm::length(bounds.centre_m - eye_m) > r)) {
        return pi;
    }
    if (r == 0.0) {
        return 0.0;
    }
    const double beta_0 = angle_between(axis, motion);
    // What a slab's middle is off by in inverse axis depth, where slabs share it evenly.
    const double half_slab = 0.5 * (1.0 / (d - r) - 1.0 / (d + r)) / planes;
    const double rim = std::asin(std::min(1.0, r / d));
    const auto at = [&](double theta) {
        const double cosine = std::cos(theta);
        const double sine = std::sin(theta);
        const double half_chord = std::sqrt(std::max(0.0, (r - d * sine) * (r + d * sine)));
        const double near = d * cosine - half_chord;
        const double far = d * cosine + half_chord;
        const double least = std::max(std::abs(beta_0 - theta), 0.0);
        const double greatest = std::min(beta_0 + theta, pi);
        if (planes <= 1) {
            const double q = d / cosine;
            return std::max(widest_angle(near, q, b, least, greatest), widest_angle(far, q, b, least, greatest));
        }
        const double q_near = 1.0 / (cosine * std::max(1.0 / (near * cosine) - half_slab, 1.0 / (d + r)));
        const double q_far = 1.0 / (cosine * std::min(1.0 / (far * cosine) + half_slab, 1.0 / (d - r)));
        return std::max(widest_angle(near, q_near, b, least, greatest), widest_angle(far, q_far, b, least, greatest));
    };
    constexpr int samples = 8;
    double best = 0.0;
    int where = 0;
    for (int k = 0; k <= samples; ++k) {
        const double phi = at(rim * k / samples);
        if (phi > best) {
            best = phi;
            where = k;
        }
    }
    // Golden section between the neighbours of the best sample.
    double low = rim * std::max(where - 1, 0) / samples;
    double high = rim * std::min(where + 1, samples) / samples;
    constexpr double golden = 0.6180339887498949;
    double x1 = high - golden * (high - low);
    double x2 = low + golden * (high - low);
    double f1 = at(x1);
    double f2 = at(x2);
    for (int step = 0; step < 8; ++step) {
        if (f1 > f2) {
            high = x2;
            x2 = x1;
            f2 = f1;
            x1 = high - golden * (high - low);
            f1 = at(x1);
        } else {
            low = x1;
            x1 = x2;
            f1 = f2;
            x2 = low + golden * (high - low);
            f2 = at(x2);
        }
    }
    return std::max({best, f1, f2});
}

double translation_angle_quick(const Sphere& bounds, const glm::dvec3& capture_eye_m, const glm::dvec3& eye_m,
                               int planes) {
    // The sine of the angle is |p - q| b sin(beta) / (|P - e| |Q - e|), and |P - e| >= p - b: what is left is largest
    // on the axis, at the front.
    const double r = bounds.radius_m;
    const double d = glm::length(bounds.centre_m - capture_eye_m);
    const double b = glm::length(eye_m - capture_eye_m);
    const double gap = d - r - b;
    if (!(gap > 0.0)) {
        return b == 0.0 && d > r ? 0.0 : std::numbers::pi;
    }
    const double one = b * r / (gap * (d - b));
    const double many = b * r / ((d + r) * planes) * (d - r) / (gap * gap);
    const double sine = planes <= 1 ? one : many;
    return sine < 1.0 ? std::asin(sine) : std::numbers::pi;
}

double zoom_angle(double radius_m, double capture_m, double distance_m) {
    const Sphere bounds{glm::dvec3(0.0), radius_m};
    return translation_angle(bounds, {0.0, -capture_m, 0.0}, {0.0, -distance_m, 0.0});
}

double pixels_per_radian(const Frustum& view, const Sphere& bounds) {
    // Along the radius the picture of a direction at angle a from the axis moves by 1 / cos^2 a a radian.
    const double corner = std::hypot(std::max(std::abs(view.tan_left), std::abs(view.tan_right)),
                                     std::max(std::abs(view.tan_bottom), std::abs(view.tan_top)));
    const glm::dvec3 towards = bounds.centre_m - view.eye_m;
    const double d = glm::length(towards);
    double tangent = corner;
    if (d > bounds.radius_m) {
        const double angle = angle_between(towards, view.forward) + std::asin(bounds.radius_m / d);
        if (angle < 1.5) {
            tangent = std::min(corner, std::tan(angle));
        }
    }
    return std::max(view.pixels_per_tan_x(), view.pixels_per_tan_y()) * (1.0 + tangent * tangent);
}

int required_texels(const Frustum& view, const Sphere& bounds, const glm::dvec3& eye_m) {
    const double d = glm::length(bounds.centre_m - eye_m);
    if (!(d > bounds.radius_m)) {
        return std::max(view.width, view.height);
    }
    const double tangent = bounds.radius_m / std::sqrt((d - bounds.radius_m) * (d + bounds.radius_m));
    const double pixels = 2.0 * tangent * std::max(view.pixels_per_tan_x(), view.pixels_per_tan_y());
    return static_cast<int>(std::min(std::ceil(pixels), 65536.0)) + 2; // and the border
}

double resolution_ratio(const Capture& capture, const Frustum& view) {
    // Pixels a metre at the object against texels a metre.
    const double here = glm::length(capture.bounds.centre_m - view.eye_m);
    const double there = glm::length(capture.bounds.centre_m - capture.view.eye_m);
    const double pixels = std::max(view.pixels_per_tan_x(), view.pixels_per_tan_y()) / std::max(here, 1e-30);
    const double texels =
        std::min(capture.view.pixels_per_tan_x(), capture.view.pixels_per_tan_y()) / std::max(there, 1e-30);
    return pixels / texels;
}

double light_error(const Lights& captured, const Lights& now, double phase_g) {
    for (int c = 0; c < 3; ++c) {
        if ((captured.key[c] <= 0.0F && now.key[c] > 0.0F) || (captured.fill[c] <= 0.0F && now.fill[c] > 0.0F)) {
            return infinite;
        }
    }
    const double g = std::clamp(std::abs(phase_g), 0.0, 0.999);
    return angle_between(glm::dvec3(captured.to_key), glm::dvec3(now.to_key)) *
           (1.0 + 3.0 * g / ((1.0 - g) * (1.0 + g)));
}

double view_shading_error(const Sphere& bounds, const glm::dvec3& capture_eye_m, const glm::dvec3& eye_m,
                          double phase_g) {
    const double g = std::clamp(std::abs(phase_g), 0.0, 0.999);
    return angle_between(bounds.centre_m - capture_eye_m, bounds.centre_m - eye_m) * 3.0 * g / ((1.0 - g) * (1.0 + g));
}

double content_error(double captured, double now) {
    const double change = std::abs(now - captured);
    return std::isfinite(change) ? change : infinite;
}

double predicted_error(const Capture& capture, const glm::dvec3& eye_m, double safety) {
    const glm::dvec3 motion = eye_m - capture.view.eye_m;
    const glm::dvec3 t(glm::dot(motion, capture.view.right), glm::dot(motion, capture.view.up),
                       glm::dot(motion, capture.view.forward));
    const double radiance = glm::dot(t, capture.sensitivity.radiance * t);
    const double alpha = glm::dot(t, capture.sensitivity.alpha * t);
    const double resample = motion == glm::dvec3(0.0) ? 0.0 : capture.sensitivity.resample;
    return safety * std::sqrt(std::max({radiance, alpha, 0.0}) + resample * resample);
}

double choose_downscale(const Sensitivity& last, double last_downscale, double max_error) {
    double chosen = 1.0;
    for (const double downscale : {2.0, 4.0, 8.0}) {
        const double factor = downscale / last_downscale;
        if (last.resample * factor * factor <= max_error) {
            chosen = downscale;
        }
    }
    return chosen;
}

} // namespace alpenglow::impostors
