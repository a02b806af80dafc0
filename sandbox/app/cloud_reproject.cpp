#include "sandbox/app/cloud_reproject.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/core/parallel_for.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float far_m = 1e6F; // where nothing says how far: direction alone counts

// Radiance and transmittance of a pixel, and its distance times its opacity.
struct Seen {
    glm::vec4 light{0.0F};
    float distance = 0.0F;

    [[nodiscard]] float opacity() const { return 1.0F - light.w; }
    [[nodiscard]] float distance_m() const { return opacity() > 1e-3F ? distance / opacity() : far_m; }
};

Seen seen_at(const clouds::Picture& picture, std::size_t pixel) {
    const float transmittance = picture.transmittance[pixel];
    return {glm::vec4(picture.radiance[pixel], transmittance), (1.0F - transmittance) * picture.depth_m[pixel]};
}

// Of a point relative to the camera, metres: in pixels from the upper left corner; false behind the camera.
bool place_on(const clouds::Camera& camera, const glm::vec3& point_m, glm::vec2& at) {
    const float depth = glm::dot(camera.forward, point_m);
    if (!(depth > 1.0F)) {
        return false;
    }
    const float scale = 0.5F * static_cast<float>(camera.height) / (camera.tan_half_height * depth);
    at = {0.5F * static_cast<float>(camera.width) + glm::dot(camera.right, point_m) * scale,
          0.5F * static_cast<float>(camera.height) - glm::dot(camera.up, point_m) * scale};
    return true;
}

// What the picture shows between pixels, of those alone that look past the landscape to `distance_m`; false where there
// are none.
bool look(const PictureBefore& before, const glm::vec2& at, float distance_m, Seen& seen) {
    const int width = before.picture.width;
    const int height = before.picture.height;
    const glm::vec2 q = at - 0.5F;
    if (q.x < -0.5F || q.y < -0.5F || q.x > static_cast<float>(width) - 0.5F ||
        q.y > static_cast<float>(height) - 0.5F) {
        return false;
    }
    const int x0 = static_cast<int>(std::floor(q.x));
    const int y0 = static_cast<int>(std::floor(q.y));
    const float tx = q.x - static_cast<float>(x0);
    const float ty = q.y - static_cast<float>(y0);
    float weight = 0.0F;
    seen = {};
    for (int k = 0; k < 4; ++k) {
        const int x = std::clamp(x0 + (k & 1), 0, width - 1);
        const int y = std::clamp(y0 + (k >> 1), 0, height - 1);
        const auto pixel = static_cast<std::size_t>(y * width + x);
        if (before.landscape_m[pixel] < 0.98F * distance_m && before.landscape_m[pixel] < 1e29F) {
            continue;
        }
        const float w = ((k & 1) != 0 ? tx : 1.0F - tx) * ((k >> 1) != 0 ? ty : 1.0F - ty);
        const Seen one = seen_at(before.picture, pixel);
        seen.light += w * one.light;
        seen.distance += w * one.distance;
        weight += w;
    }
    if (weight < 1e-3F) {
        return false;
    }
    seen.light /= weight;
    seen.distance /= weight;
    return true;
}

} // namespace

PixelLattice lattice_of(int n, int turn) {
    constexpr std::array<glm::ivec2, 4> second{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}};
    constexpr std::array<glm::ivec2, 9> third{{{0, 0}, {1, 2}, {2, 1}, {1, 1}, {2, 0}, {0, 2}, {2, 2}, {0, 1}, {1, 0}}};
    assert(n >= 1 && n <= 3 && turn >= 0);
    return {n, n == 3   ? third[static_cast<std::size_t>(turn % 9)]
               : n == 2 ? second[static_cast<std::size_t>(turn % 4)]
                        : glm::ivec2(0)};
}

clouds::Camera lattice_camera(const clouds::Camera& camera, const PixelLattice& lattice) {
    clouds::Camera out = camera;
    out.width = (camera.width + lattice.n - 1) / lattice.n;
    out.height = (camera.height + lattice.n - 1) / lattice.n;
    const float pixel = 2.0F * camera.tan_half_height / static_cast<float>(camera.height);
    out.tan_half_height = 0.5F * pixel * static_cast<float>(lattice.n * out.height);
    const auto turn = [&](int first, int coarse, int fine) {
        return (static_cast<float>(first) + 0.5F + 0.5F * static_cast<float>(lattice.n * (coarse - 1) - fine)) * pixel;
    };
    out.forward += turn(lattice.first.x, out.width, camera.width) * camera.right -
                   turn(lattice.first.y, out.height, camera.height) * camera.up;
    return out;
}

std::size_t complete_picture(const clouds::Picture& fresh, const PixelLattice& lattice, const PictureBefore& before,
                             const clouds::Camera& camera, std::span<const float> landscape_m, clouds::Picture& out) {
    // Along one axis: the fresh pixels around, and how far on from the first to the second.
    struct Around {
        std::array<int, 2> at;
        float on;
        bool between; // there is one on either side
    };
    const auto around = [&](int pixel, int first, int count) {
        const int from = pixel - first + lattice.n; // not negative
        const int at = from / lattice.n - 1;
        const int past = from % lattice.n;
        return Around{{std::clamp(at, 0, count - 1), std::clamp(past == 0 ? at : at + 1, 0, count - 1)},
                      static_cast<float>(past) / static_cast<float>(lattice.n),
                      at >= 0 && (past == 0 || at + 1 < count)};
    };
    const glm::vec3 moved_m(camera.position_m - before.camera.position_m);
    std::atomic<std::size_t> without{0};
    parallel_for(static_cast<std::size_t>(camera.height), 8, [&](std::size_t begin, std::size_t end) {
        std::size_t missing = 0;
        for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
            const Around row = around(y, lattice.first.y, fresh.height);
            for (int x = 0; x < camera.width; ++x) {
                const auto pixel = static_cast<std::size_t>(y * camera.width + x);
                const Around column = around(x, lattice.first.x, fresh.width);
                const auto at_fresh = [&](int i, int j) { return static_cast<std::size_t>(j * fresh.width + i); };
                if (x % lattice.n == lattice.first.x && y % lattice.n == lattice.first.y) {
                    const std::size_t from = at_fresh(column.at[0], row.at[0]);
                    out.radiance[pixel] = fresh.radiance[from];
                    out.transmittance[pixel] = fresh.transmittance[from];
                    out.depth_m[pixel] = fresh.depth_m[from];
                    continue;
                }
                Seen mean;
                mean.light.w = 0.0F;
                glm::vec4 low(1e30F);
                glm::vec4 high(-1e30F);
                for (std::size_t k = 0; k < 4; ++k) {
                    const Seen one = seen_at(fresh, at_fresh(column.at[k & 1U], row.at[k >> 1U]));
                    const float weight =
                        ((k & 1U) != 0 ? column.on : 1.0F - column.on) * ((k >> 1U) != 0 ? row.on : 1.0F - row.on);
                    mean.light += weight * one.light;
                    mean.distance += weight * one.distance;
                    low = glm::min(low, one.light);
                    high = glm::max(high, one.light);
                }
                const glm::vec3 direction =
                    camera.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
                Seen seen;
                glm::vec2 at;
                float distance = std::min(mean.distance_m(), landscape_m[pixel]);
                bool found =
                    place_on(before.camera, direction * distance + moved_m, at) && look(before, at, distance, seen);
                if (found && std::abs(std::min(seen.distance_m(), landscape_m[pixel]) - distance) > 0.02F * distance) {
                    distance = std::min(seen.distance_m(), landscape_m[pixel]);
                    found =
                        place_on(before.camera, direction * distance + moved_m, at) && look(before, at, distance, seen);
                }
                if (found && row.between && column.between) {
                    const glm::vec4 slack = 0.5F * (high - low) + 0.1F * high;
                    seen.light = glm::clamp(seen.light, low - slack, high + slack);
                } else if (!found) {
                    seen = mean;
                    ++missing;
                }
                if (seen.opacity() > 1e-3F && seen.distance_m() > landscape_m[pixel]) { // it stands in front of them
                    seen = mean.distance_m() < landscape_m[pixel] ? mean : Seen{{0.0F, 0.0F, 0.0F, 1.0F}, 0.0F};
                }
                out.radiance[pixel] = glm::max(glm::vec3(seen.light), glm::vec3(0.0F));
                out.transmittance[pixel] = std::clamp(seen.light.w, 0.0F, 1.0F);
                out.depth_m[pixel] =
                    out.transmittance[pixel] < 0.999F ? (seen.opacity() > 1e-3F ? seen.distance_m() : distance) : 0.0F;
            }
        }
        without += missing;
    });
    return without;
}

} // namespace alpenglow::sandbox
