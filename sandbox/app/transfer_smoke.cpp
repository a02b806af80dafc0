#include "sandbox/app/transfer_smoke.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "sandbox/world/noise.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float height_m = 3.6F;
constexpr float peak_per_m = 26.0F;

// Extinction, per metre.
float plume(const glm::vec3& p) {
    const float up = p.z / height_m;
    if (up <= 0.0F || up >= 1.0F) {
        return 0.0F;
    }
    const glm::vec2 axis(0.55F * up * up + 0.16F * up * std::sin(5.0F * up), 0.14F * up * std::sin(6.5F * up + 1.0F));
    const glm::vec2 away = glm::vec2(p) - axis;
    const float radius = 0.13F + 0.55F * up;
    // Billows: bulges that climb around the axis.
    const float phi = std::atan2(away.y, away.x);
    const float bulge = gradient_noise(1.6F * phi + 4.0F * up, 7.0F * up, 5U) +
                        0.6F * gradient_noise(3.7F * p.x + 9.0F, 3.7F * p.z, 11U);
    const float r = glm::length(away) / (radius * (1.0F + 0.38F * bulge));
    const float body = std::clamp(1.25F - 1.25F * r, 0.0F, 1.0F);
    const float fade = std::min(1.0F, 8.0F * up) * std::pow(1.0F - up, 0.8F);
    return peak_per_m * body * body * (3.0F - 2.0F * body) * fade * 0.35F / (0.35F + up);
}

} // namespace

prt::VolumeDensity make_plume(float cell_m) {
    prt::VolumeDensity density;
    const glm::vec3 low(-0.75F, -0.8F, 0.0F);
    const glm::vec3 high(1.35F, 0.8F, height_m);
    density.grid.size = glm::uvec3(glm::ceil((high - low) / cell_m)) + 1U;
    density.grid.origin_m = low;
    density.grid.step_m = (high - low) / glm::vec3(density.grid.size - 1U);
    for (unsigned k = 0; k < density.grid.size.z; ++k) {
        for (unsigned j = 0; j < density.grid.size.y; ++j) {
            for (unsigned i = 0; i < density.grid.size.x; ++i) {
                density.extinction_per_m.push_back(plume(low + density.grid.step_m * glm::vec3(glm::uvec3(i, j, k))));
            }
        }
    }
    return density;
}

void draw_smoke(const prt::VolumeDensity& density, std::span<const glm::vec3> fluence, const glm::vec3& position_m,
                const glm::vec3& camera_m, int columns, int rows, std::vector<SmokeVertex>& vertices,
                std::vector<std::uint32_t>& indices) {
    vertices.clear();
    indices.clear();
    const prt::Grid& grid = density.grid;
    const glm::vec3 extent = grid.step_m * glm::vec3(grid.size - 1U);
    const glm::vec3 middle = position_m + grid.origin_m + 0.5F * extent;
    const glm::vec3 towards = camera_m - middle;
    const float distance = glm::length(towards);
    if (distance < 0.5F * glm::length(extent)) {
        return; // the camera is in it
    }
    const glm::vec3 facing = towards / distance;
    const glm::vec3 level = glm::cross(glm::vec3(0.0F, 0.0F, 1.0F), facing);
    const glm::vec3 right = glm::length(level) > 1e-3F ? glm::normalize(level) : glm::vec3(1.0F, 0.0F, 0.0F);
    const glm::vec3 up = glm::cross(facing, right);
    const float half_width =
        0.5F * (std::abs(right.x) * extent.x + std::abs(right.y) * extent.y + std::abs(right.z) * extent.z);
    const float half_height =
        0.5F * (std::abs(up.x) * extent.x + std::abs(up.y) * extent.y + std::abs(up.z) * extent.z);
    const float ds = std::min({grid.step_m.x, grid.step_m.y, grid.step_m.z});
    const glm::ivec3 size(grid.size);
    const auto row_stride = static_cast<std::size_t>(size.x);
    const auto plane_stride = row_stride * static_cast<std::size_t>(size.y);
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const float x = 2.0F * static_cast<float>(i) / static_cast<float>(columns - 1) - 1.0F;
            const float y = 2.0F * static_cast<float>(j) / static_cast<float>(rows - 1) - 1.0F;
            SmokeVertex& vertex = vertices.emplace_back();
            vertex.position_m = middle + x * half_width * right + y * half_height * up;
            vertex.radiance = glm::vec4(0.0F);
            const glm::vec3 along = glm::normalize(vertex.position_m - camera_m);
            // Where the ray is in the grid.
            const glm::vec3 from = (camera_m - position_m - grid.origin_m) / grid.step_m;
            const glm::vec3 step = along / grid.step_m;
            float enter = 0.0F;
            float leave = std::numeric_limits<float>::max();
            for (int axis = 0; axis < 3; ++axis) {
                const float far = static_cast<float>(size[axis] - 1);
                if (std::abs(step[axis]) < 1e-9F) {
                    leave = from[axis] < 0.0F || from[axis] > far ? -1.0F : leave;
                    continue;
                }
                const float a = -from[axis] / step[axis];
                const float b = (far - from[axis]) / step[axis];
                enter = std::max(enter, std::min(a, b));
                leave = std::min(leave, std::max(a, b));
            }
            float through = 1.0F;
            for (float t = enter + 0.5F * ds; t < leave && through > 1e-3F; t += ds) {
                const glm::vec3 at = from + t * step;
                const glm::ivec3 cell = glm::clamp(glm::ivec3(glm::floor(at)), glm::ivec3(0), size - 2);
                const glm::vec3 f = glm::clamp(at - glm::vec3(cell), 0.0F, 1.0F);
                float extinction = 0.0F;
                glm::vec3 light(0.0F);
                float weights = 0.0F;
                for (std::size_t corner = 0; corner < 8; ++corner) {
                    const float w = ((corner & 1U) != 0 ? f.x : 1.0F - f.x) * ((corner & 2U) != 0 ? f.y : 1.0F - f.y) *
                                    ((corner & 4U) != 0 ? f.z : 1.0F - f.z);
                    const std::size_t point = static_cast<std::size_t>(cell.x) + (corner & 1U) +
                                              row_stride * (static_cast<std::size_t>(cell.y) + ((corner >> 1U) & 1U)) +
                                              plane_stride * (static_cast<std::size_t>(cell.z) + (corner >> 2U));
                    const float share = w * density.extinction_per_m[point];
                    extinction += share;
                    light += share * fluence[point];
                    weights += share;
                }
                if (weights <= 0.0F) {
                    continue;
                }
                const float scattered = -std::expm1(-extinction * ds) * through;
                vertex.radiance +=
                    glm::vec4(scattered * smoke_albedo * glm::max(light / weights, glm::vec3(0.0F)), 0.0F);
                through -= scattered;
            }
            vertex.radiance.w = 1.0F - through;
        }
    }
    for (int j = 0; j + 1 < rows; ++j) {
        for (int i = 0; i + 1 < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * columns + i);
            const auto c = static_cast<std::uint32_t>(columns);
            const auto shows = [&](std::uint32_t v) { return vertices[v].radiance.w > 0.002F; };
            if (shows(a) || shows(a + 1) || shows(a + c) || shows(a + c + 1)) {
                indices.insert(indices.end(), {a, a + 1, a + c + 1, a, a + c + 1, a + c});
            }
        }
    }
}

} // namespace alpenglow::sandbox
