#include "sandbox/render/terrain_image.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/vec2.hpp>

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

std::vector<std::uint32_t> sort_by_grid(std::span<const std::uint32_t> indices, std::span<const TerrainGrid> grids,
                                        std::span<std::uint32_t> sorted) {
    assert(!grids.empty() && sorted.size() == indices.size());
    std::vector<std::uint32_t> grid_of(indices.size() / 3, 0);
    std::vector<std::uint32_t> counts(grids.size(), 0);
    for (std::size_t t = 0; t < grid_of.size(); ++t) {
        for (std::size_t g = grids.size(); g-- > 1;) {
            const bool inside = std::all_of(indices.begin() + static_cast<std::ptrdiff_t>(3 * t),
                                            indices.begin() + static_cast<std::ptrdiff_t>(3 * t + 3),
                                            [&](std::uint32_t v) { return contains(grids[g], position_of(v, grids)); });
            if (inside) {
                grid_of[t] = static_cast<std::uint32_t>(g);
                break;
            }
        }
        counts[grid_of[t]] += 3;
    }
    std::size_t next = 0;
    for (std::uint32_t g = 0; g < grids.size(); ++g) {
        for (std::size_t t = 0; t < grid_of.size(); ++t) {
            if (grid_of[t] == g) {
                std::copy_n(indices.begin() + static_cast<std::ptrdiff_t>(3 * t), 3,
                            sorted.begin() + static_cast<std::ptrdiff_t>(next));
                next += 3;
            }
        }
    }
    return counts;
}

} // namespace alpenglow::sandbox
