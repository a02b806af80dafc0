// A terrain for tests: cheaper and rougher than the generated one, with its structure.
#pragma once

#include <sandbox/world/noise.hpp>
#include <sandbox/world/terrain.hpp>

#include <alpenglow/core/parallel_for.hpp>

namespace alpenglow::sandbox {

inline Terrain rough_terrain(std::uint32_t seed, float height_m = 2500.0F) {
    Terrain terrain;
    terrain.seed = seed;
    terrain.outer = make_grid(Terrain::samples, Terrain::outer_spacing_m);
    terrain.inner = make_grid(Terrain::samples, Terrain::inner_spacing_m);
    for (HeightGrid* grid : {&terrain.outer, &terrain.inner}) {
        parallel_for(static_cast<std::size_t>(grid->n), 32, [&](std::size_t begin, std::size_t end) {
            for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
                for (int i = 0; i < grid->n; ++i) {
                    const glm::vec2 p = grid->position_m(i, j);
                    grid->height_m[grid->index(i, j)] = height_m * ridged_noise(p.x / 7000.0F, p.y / 7000.0F, 7, seed);
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

} // namespace alpenglow::sandbox
