#include "terrain_mesh.hpp"

#include "vertex.hpp"

#include <alpenglow/core/parallel_for.hpp>

#include <cassert>
#include <cmath>

namespace alpenglow::sandbox {
namespace {

constexpr std::size_t grid_count = static_cast<std::size_t>(Terrain::samples) * Terrain::samples;

void colour(const Terrain& terrain, const HeightGrid& grid, const std::vector<float>& drainage_m2,
            const std::vector<HorizonBytes>& horizons, Vertex* out) {
    parallel_for(static_cast<std::size_t>(grid.n), 8, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < grid.n; ++i) {
                const std::size_t k = grid.index(i, j);
                const glm::vec3 albedo = ground_albedo(terrain, grid.position_m(i, j), grid.height_m[k],
                                                       grid_normal(grid, i, j), drainage_m2[k], grid.spacing_m);
                out[k].albedo = pack_albedo(albedo, sky_visibility(horizons[k]));
                out[k].horizon = pack_horizon(horizons[k]);
            }
        }
    });
}

void shape(const HeightGrid& grid, Vertex* out) {
    parallel_for(static_cast<std::size_t>(grid.n), 8, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < grid.n; ++i) {
                const std::size_t k = grid.index(i, j);
                out[k].position_m = {grid.position_m(i, j), grid.height_m[k]};
                out[k].normal = pack_normal(grid_normal(grid, i, j));
            }
        }
    });
}

} // namespace

MeshData make_terrain_mesh(const Terrain& terrain) {
    MeshData mesh;
    mesh.vertices.resize(2 * grid_count);
    colour(terrain, terrain.outer, terrain.outer_area_m2, compute_horizons(terrain.outer), mesh.vertices.data());
    colour(terrain, terrain.inner, terrain.inner_area_m2, compute_horizons(terrain.inner, &terrain.outer),
           mesh.vertices.data() + grid_count);
    shape_terrain_mesh(terrain, mesh.vertices);
    return mesh;
}

void shape_terrain_mesh(const Terrain& terrain, std::span<Vertex> vertices) {
    assert(vertices.size() == 2 * grid_count);
    shape(terrain.outer, vertices.data());
    shape(terrain.inner, vertices.data() + grid_count);
    const int half = (Terrain::samples - 1) / 2;
    const int first = half - half / Terrain::ratio;
    for (int j = 0; j < Terrain::samples; j += Terrain::ratio) {
        for (int i = 0; i < Terrain::samples; i += Terrain::ratio) {
            vertices[terrain.outer.index(first + i / Terrain::ratio, first + j / Terrain::ratio)] =
                vertices[grid_count + terrain.inner.index(i, j)];
        }
    }
}

std::array<std::uint32_t, 4> terrain_horizon(const Terrain& terrain, const MeshData& mesh, glm::vec2 p) {
    const bool fine = std::max(std::abs(p.x), std::abs(p.y)) <= 0.5F * terrain.inner.extent_m();
    const HeightGrid& grid = fine ? terrain.inner : terrain.outer;
    const glm::vec2 q = (p - grid.origin_m) / grid.spacing_m;
    const int i = std::clamp(static_cast<int>(std::lround(q.x)), 0, grid.n - 1);
    const int j = std::clamp(static_cast<int>(std::lround(q.y)), 0, grid.n - 1);
    return mesh.vertices[(fine ? grid_count : 0U) + grid.index(i, j)].horizon;
}

} // namespace alpenglow::sandbox
