#include "sandbox/app/squadron.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>

namespace alpenglow::sandbox {
namespace {

// Uniform in [0, 1), by a counter.
double random_at(std::uint32_t i) {
    i *= 0x9e3779b1U;
    i ^= i >> 16;
    i *= 0x7feb352dU;
    i ^= i >> 15;
    i *= 0x846ca68bU;
    i ^= i >> 16;
    return static_cast<double>(i >> 8) * 0x1p-24;
}

constexpr double speed_m_s = 110.0;

} // namespace

std::vector<glm::dvec3> cloud_places(int count, double field_m, double base_m) {
    std::vector<glm::dvec3> places;
    const int side = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count)))));
    const double cell = field_m / side;
    for (int i = 0; i < count; ++i) {
        const auto n = static_cast<std::uint32_t>(i);
        places.emplace_back((i % side + 0.15 + 0.7 * random_at(3 * n)) * cell - 0.5 * field_m,
                            (i / side + 0.15 + 0.7 * random_at(3 * n + 1)) * cell - 0.5 * field_m,
                            base_m + 120.0 * random_at(3 * n + 2));
    }
    return places;
}

FlightPath::FlightPath(const std::vector<glm::dvec3>& clouds, double field_m, double base_m) {
    constexpr int turns = 16;
    for (int k = 0; k < turns; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / turns;
        const double radius = field_m * (0.3 + 0.08 * std::sin(3.0 * angle));
        glm::dvec3 point(radius * std::sin(angle), -radius * std::cos(angle), base_m + 260.0);
        if (k % 2 == 1 && !clouds.empty()) { // every other point lies in the nearest cloud
            const auto nearest = std::min_element(clouds.begin(), clouds.end(), [&](const auto& a, const auto& b) {
                return glm::length(a - point) < glm::length(b - point);
            });
            point = *nearest + glm::dvec3(0.0, 0.0, 190.0);
        }
        points_.push_back(point);
    }
    for (std::size_t k = 0; k < points_.size(); ++k) {
        length_m_ += glm::length(points_[(k + 1) % points_.size()] - points_[k]);
    }
}

glm::dvec3 FlightPath::at(double metres) const {
    if (points_.empty()) {
        return glm::dvec3(0.0);
    }
    const auto count = static_cast<double>(points_.size());
    double u = metres / length_m_ * count;
    u -= std::floor(u / count) * count;
    const auto k = std::min(static_cast<std::size_t>(u), points_.size() - 1);
    const double t = u - static_cast<double>(k);
    const auto point = [&](std::size_t i) { return points_[(i + points_.size()) % points_.size()]; };
    const glm::dvec3 a = point(k + points_.size() - 1);
    const glm::dvec3 b = point(k);
    const glm::dvec3 c = point(k + 1);
    const glm::dvec3 d = point(k + 2);
    return 0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t +
                  (3.0 * b - a - 3.0 * c + d) * t * t * t);
}

std::vector<Craft> squadron_at(const FlightPath& path, int count, double time_s) {
    std::vector<Craft> all;
    for (int i = 0; i < count; ++i) {
        const double row = (i + 1) / 2; // a wedge: one ahead, pairs behind
        const double side = i == 0 ? 0.0 : (i % 2 == 1 ? -1.0 : 1.0);
        const double along = time_s * speed_m_s - 45.0 * row;
        const glm::dvec3 here = path.at(along);
        const glm::dvec3 forward = glm::normalize(path.at(along + 5.0) - path.at(along - 5.0));
        const glm::dvec3 before = glm::normalize(path.at(along - 15.0) - path.at(along - 25.0));
        const glm::dvec3 after = glm::normalize(path.at(along + 25.0) - path.at(along + 15.0));
        const glm::dvec3 level = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 0.0, 1.0)));
        // Banked so that lift and weight turn it: tan = v^2 / (r g).
        const double bank = std::atan(glm::dot(after - before, level) / 40.0 * speed_m_s * speed_m_s / 9.81);
        const glm::dvec3 straight_up = glm::cross(level, forward);
        const glm::dvec3 right = std::cos(bank) * level - std::sin(bank) * straight_up;
        const glm::dvec3 up = glm::cross(right, forward);
        const double sway = std::sin(0.7 * time_s + 1.9 * i);
        Craft craft;
        craft.position_m =
            here + (side * 38.0 * row + 4.0 * sway) * right + (3.0 * std::cos(0.9 * time_s + 2.3 * i) - 4.0 * row) * up;
        craft.axes = glm::mat3(glm::vec3(right), glm::vec3(forward), glm::vec3(up));
        all.push_back(craft);
    }
    return all;
}

void append_craft(const Craft& craft, const CraftLight& light, std::vector<ColorVertex>& triangles) {
    // A delta with a fuselage and a fin: metres, right, forward, up.
    constexpr glm::vec3 nose(0.0F, 9.0F, 0.0F), left(-6.5F, -5.5F, 0.0F), right(6.5F, -5.5F, 0.0F);
    constexpr glm::vec3 top(0.0F, -3.0F, 1.6F), under(0.0F, -3.0F, -0.9F), tail(0.0F, -6.0F, 0.3F);
    constexpr glm::vec3 fin(0.0F, -7.0F, 4.2F), fin_front(0.0F, -2.5F, 1.4F);
    constexpr glm::vec3 metal(0.55F, 0.56F, 0.58F), paint(0.55F, 0.08F, 0.05F);
    struct Face {
        glm::vec3 a, b, c, albedo;
    };
    constexpr std::array<Face, 11> faces{{{nose, top, left, metal},
                                          {nose, right, top, metal},
                                          {left, top, tail, metal},
                                          {top, right, tail, metal},
                                          {nose, left, under, metal},
                                          {nose, under, right, metal},
                                          {left, tail, under, metal},
                                          {under, tail, right, metal},
                                          {fin_front, fin, tail, paint},
                                          {fin_front, tail, fin, paint},
                                          {top, fin_front, tail, paint}}};
    for (const Face& face : faces) {
        const glm::vec3 normal = glm::normalize(craft.axes * glm::cross(face.b - face.a, face.c - face.a));
        const float sky = 0.65F + 0.35F * normal.z;
        const glm::vec3 radiance =
            face.albedo * (light.direct * std::max(0.0F, glm::dot(normal, light.to_light)) + light.ambient * sky);
        for (const glm::vec3& corner : {face.a, face.b, face.c}) {
            triangles.push_back(
                {glm::vec3(craft.position_m) + craft.axes * (1.8F * corner), glm::vec4(radiance, 0.0F)});
        }
    }
}

} // namespace alpenglow::sandbox
