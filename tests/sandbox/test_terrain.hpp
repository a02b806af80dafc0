// Terrains for tests with the structure of the generated one: a rougher one that all share, and flat ground.
#pragma once

#include <sandbox/world/noise.hpp>
#include <sandbox/world/terrain.hpp>
#include <sandbox/world/terrain_lod.hpp>

#include <alpenglow/core/parallel_for.hpp>

namespace alpenglow::sandbox {

inline Terrain make_flat_terrain() {
    Terrain terrain;
    terrain.outer = make_grid(Terrain::samples, Terrain::outer_spacing_m);
    terrain.inner = make_grid(Terrain::samples, Terrain::inner_spacing_m);
    return terrain;
}

inline Terrain make_rough_terrain() {
    Terrain terrain = make_flat_terrain();
    constexpr std::uint32_t seed = 4;
    for (HeightGrid* grid : {&terrain.outer, &terrain.inner}) {
        parallel_for(static_cast<std::size_t>(grid->n), 32, [&](std::size_t begin, std::size_t end) {
            for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
                for (int i = 0; i < grid->n; ++i) {
                    const glm::vec2 p = grid->position_m(i, j);
                    grid->height_m[grid->index(i, j)] = 2500.0F * ridged_noise(p.x / 7000.0F, p.y / 7000.0F, 7, seed);
                }
            }
        });
    }
    // Along the inner border the surfaces agree.
    const int last = Terrain::samples - 1;
    for (int k = 0; k <= last; ++k) {
        for (const auto& [i, j] : {std::pair{k, 0}, std::pair{k, last}, std::pair{0, k}, std::pair{last, k}}) {
            terrain.inner.height_m[terrain.inner.index(i, j)] =
                sample_bilinear(terrain.outer, terrain.inner.position_m(i, j));
        }
    }
    return terrain;
}

inline const Terrain& rough_terrain() {
    static const Terrain terrain = make_rough_terrain();
    return terrain;
}

// A level of detail of its own for each test, with bounds that are found once.
inline TerrainLod rough_lod() {
    static const LodBounds bounds = TerrainLod(rough_terrain()).bounds();
    return {rough_terrain(), bounds};
}

inline TerrainLod flat_lod() {
    static const Terrain terrain = make_flat_terrain();
    static const LodBounds bounds = TerrainLod(terrain).bounds();
    return {terrain, bounds};
}

} // namespace alpenglow::sandbox
