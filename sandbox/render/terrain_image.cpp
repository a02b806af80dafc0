#include "sandbox/render/terrain_image.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sandbox {
namespace {

glm::vec2 position_of(std::uint32_t vertex, std::span<const TerrainGrid> grids) {
    const auto after = std::find_if(grids.begin(), grids.end(),
                                    [vertex](const TerrainGrid& grid) { return grid.first_vertex > vertex; });
    assert(after != grids.begin());
    const TerrainGrid& grid = *(after - 1);
    const std::uint32_t k = vertex - grid.first_vertex;
    return grid.origin_m +
           grid.spacing_m * glm::vec2(static_cast<float>(k % grid.samples), static_cast<float>(k / grid.samples));
}

bool contains(const TerrainGrid& grid, glm::vec2 position) {
    const glm::vec2 at = (position - grid.origin_m) / (grid.spacing_m * static_cast<float>(grid.samples - 1));
    constexpr float kRounding = 1e-5F;
    return std::min(at.x, at.y) > -kRounding && std::max(at.x, at.y) < 1.0F + kRounding;
}

} // namespace

std::vector<std::byte> terrain_texels(std::span<const Vertex> vertices, const TerrainGrid& grid) {
    std::vector<std::byte> texels;
    texels.reserve(std::size_t{4} * grid.samples * grid.samples);
    for (const Vertex& vertex : vertices.subspan(grid.first_vertex, std::size_t{grid.samples} * grid.samples)) {
        const auto component = [&vertex](unsigned k) {
            const auto n = static_cast<std::int8_t>(vertex.normal >> (8U * k) & 0xFFU);
            return static_cast<std::byte>(std::clamp(n + 128, 1, 255)); // -127 .. 127 to 1 .. 255, 0 to 128
        };
        const auto reflectance = [&vertex](unsigned k) {
            const float root = static_cast<float>(vertex.albedo >> (8U * k) & 0xFFU) / 255.0F;
            return root * root;
        };
        const float luminance = 0.2126F * reflectance(0) + 0.7152F * reflectance(1) + 0.0722F * reflectance(2);
        texels.push_back(component(0));
        texels.push_back(component(1));
        texels.push_back(static_cast<std::byte>(std::lround(255.0F * std::sqrt(std::min(luminance, 1.0F)))));
        texels.push_back(static_cast<std::byte>(vertex.albedo >> 24U));
    }
    return texels;
}

glm::vec4 image_from_position(const TerrainGrid& grid) {
    const float side_m = grid.spacing_m * static_cast<float>(grid.samples);
    const glm::vec2 offset = (0.5F * grid.spacing_m - grid.origin_m) / side_m;
    return {1.0F / side_m, offset.x, offset.y, 0.0F};
}

std::vector<TerrainRun> sort_terrain(std::span<const std::uint32_t> indices, std::span<const TerrainGrid> grids,
                                     glm::vec2 camera_m, std::span<std::uint32_t> sorted) {
    assert(!grids.empty() && sorted.size() == indices.size());
    const std::size_t triangles = indices.size() / 3;
    constexpr float kNear = 1.2F * kNearTiles * kDetailTiles[0];
    constexpr std::size_t kOctaves = 11; // 148 km and more
    // A key for each triangle: distance first, so that what hides is drawn first, then grid from fine to coarse.
    std::vector<std::uint8_t> keys(triangles);
    std::vector<TerrainRun> runs((1 + kOctaves) * grids.size());
    for (std::size_t t = 0; t < triangles; ++t) {
        std::array<glm::vec2, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            corners[k] = position_of(indices[3 * t + k], grids);
        }
        const auto inside = [&corners](const TerrainGrid& grid) {
            return std::all_of(corners.begin(), corners.end(), [&grid](glm::vec2 p) { return contains(grid, p); });
        };
        std::size_t grid = grids.size() - 1;
        while (grid > 0 && !inside(grids[grid])) {
            --grid;
        }
        // Near where the ball around the triangle is; the margin in kNear covers how far the camera moves before the
        // triangulation is made anew.
        const glm::vec2 middle = (corners[0] + corners[1] + corners[2]) / 3.0F;
        float radius = 0.0F;
        for (const glm::vec2 corner : corners) {
            radius = std::max(radius, glm::distance(middle, corner));
        }
        const float distance = glm::distance(middle, camera_m);
        const bool near = distance - radius < kNear;
        const auto octave =
            static_cast<std::size_t>(std::clamp(std::log2(distance / kNear), 0.0F, static_cast<float>(kOctaves - 1)));
        const std::size_t key = (near ? 0 : 1 + octave) * grids.size() + (grids.size() - 1 - grid);
        keys[t] = static_cast<std::uint8_t>(key);
        runs[key].grid = static_cast<std::uint32_t>(grid);
        runs[key].near = near;
        runs[key].distance_m = near ? 0.0F : kNear * std::exp2(static_cast<float>(octave) + 0.5F);
        runs[key].index_count += 3;
    }
    std::vector<std::uint32_t> next(runs.size(), 0);
    for (std::size_t key = 1; key < runs.size(); ++key) {
        runs[key].first_index = runs[key - 1].first_index + runs[key - 1].index_count;
        next[key] = runs[key].first_index;
    }
    for (std::size_t t = 0; t < triangles; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            sorted[next[keys[t]]++] = indices[3 * t + k];
        }
    }
    std::erase_if(runs, [](const TerrainRun& run) { return run.index_count == 0; });
    return runs;
}

float level_at(float distance_m, float pixels_per_radian, float texel_m) {
    return std::round(std::log2(std::max(distance_m / (pixels_per_radian * texel_m), 1.0F)));
}

} // namespace alpenglow::sandbox
