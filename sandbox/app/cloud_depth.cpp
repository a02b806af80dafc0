#include "sandbox/app/cloud_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float near_m = 1.0F;

struct Point {
    float x, y;      // pixels
    float closeness; // 1 / depth along the view axis: linear on the screen
};

// Keeps the largest closeness of every pixel whose middle the triangle covers.
void fill(const Point& a, const Point& b, const Point& c, int width, int height, std::vector<float>& closeness) {
    const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    const auto first = [](float v) { return static_cast<int>(std::ceil(std::clamp(v - 0.5F, -1.0F, 1e6F))); };
    const int x0 = std::max(0, first(std::min({a.x, b.x, c.x})));
    const int y0 = std::max(0, first(std::min({a.y, b.y, c.y})));
    const int x1 = std::min(width - 1, first(std::max({a.x, b.x, c.x})));
    const int y1 = std::min(height - 1, first(std::max({a.y, b.y, c.y})));
    if (std::abs(area) < 1e-12F || x0 > x1 || y0 > y1) {
        return;
    }
    const float inverse = 1.0F / area;
    // Barycentric weights of b and c, and their steps.
    const float bx = (c.y - a.y) * inverse;
    const float by = -(c.x - a.x) * inverse;
    const float cx = -(b.y - a.y) * inverse;
    const float cy = (b.x - a.x) * inverse;
    for (int y = y0; y <= y1; ++y) {
        const float py = static_cast<float>(y) + 0.5F - a.y;
        for (int x = x0; x <= x1; ++x) {
            const float px = static_cast<float>(x) + 0.5F - a.x;
            const float u = px * bx + py * by;
            const float v = px * cx + py * cy;
            if (u < 0.0F || v < 0.0F || u + v > 1.0F) {
                continue;
            }
            float& at =
                closeness[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
            at = std::max(at, a.closeness + u * (b.closeness - a.closeness) + v * (c.closeness - a.closeness));
        }
    }
}

} // namespace

void landscape_distance(const clouds::Camera& camera, std::span<const Vertex> vertices,
                        std::span<const std::uint32_t> indices, std::vector<float>& distance_m) {
    const int width = camera.width;
    const int height = camera.height;
    distance_m.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0F);
    const glm::vec3 eye(camera.position_m);
    const float scale = 0.5F * static_cast<float>(height) / camera.tan_half_height;
    const auto project = [&](const glm::vec3& view) { // right, up, depth
        return Point{0.5F * static_cast<float>(width) + view.x / view.z * scale,
                     0.5F * static_cast<float>(height) - view.y / view.z * scale, 1.0F / view.z};
    };
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        std::array<glm::vec3, 3> corner;
        int in_front = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3 v = vertices[indices[i + k]].position_m - eye;
            corner[k] = {glm::dot(camera.right, v), glm::dot(camera.up, v), glm::dot(camera.forward, v)};
            in_front += corner[k].z >= near_m ? 1 : 0;
        }
        if (in_front == 0) {
            continue;
        }
        if (in_front == 3) {
            fill(project(corner[0]), project(corner[1]), project(corner[2]), width, height, distance_m);
            continue;
        }
        // Cut at the near plane: three or four corners are left.
        std::array<Point, 4> cut{};
        std::size_t count = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3& from = corner[k];
            const glm::vec3& to = corner[(k + 1) % 3];
            if (from.z >= near_m) {
                cut[count++] = project(from);
            }
            if ((from.z >= near_m) != (to.z >= near_m)) {
                const float t = (near_m - from.z) / (to.z - from.z);
                cut[count++] = project({from.x + t * (to.x - from.x), from.y + t * (to.y - from.y), near_m});
            }
        }
        fill(cut[0], cut[1], cut[2], width, height, distance_m);
        if (count == 4) {
            fill(cut[0], cut[2], cut[3], width, height, distance_m);
        }
    }
    // From closeness along the axis to distance along the ray.
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            float& at =
                distance_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
            if (at <= 0.0F) {
                at = 1e30F;
                continue;
            }
            const float u = (static_cast<float>(x) + 0.5F - 0.5F * static_cast<float>(width)) / scale;
            const float v = (static_cast<float>(y) + 0.5F - 0.5F * static_cast<float>(height)) / scale;
            at = std::sqrt(1.0F + u * u + v * v) / at;
        }
    }
}

} // namespace alpenglow::sandbox
