// Procedural clouds and metaballs, rasterised to sparse grids. The same seed gives the same bits on any thread count.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/clouds/grid.hpp>

namespace alpenglow::clouds {

// Harris's cloud particle (course notes, cloud rendering, section 2.3), as a metaball with Wyvill's kernel:
// density * (1 - (distance / radius)^2)^3 inside the radius.
struct Particle {
    glm::vec3 centre_m{0.0F};
    float radius_m = 1.0F;
    float density = 1.0F; // at the centre
};

// Sum of the particles' kernels at the voxel centres of a grid with cubic voxels; the grid's origin is a multiple of
// the voxel size, so that clouds rasterised apart share one lattice.
[[nodiscard]] SparseGrid rasterise(std::span<const Particle> particles, float voxel_m, float max_density = 1.0F);

// Brings `grid`, made by rasterise(before), up to date with `after` (same length): only bricks within reach of a
// particle that moved by more than tolerance_m, or whose radius did, are computed again. Returns their number.
std::size_t update_rasterised(SparseGrid& grid, std::vector<Particle>& before, std::span<const Particle> after,
                              float tolerance_m, float max_density = 1.0F);

enum class CloudType { cumulus, stratus, cirrus };

// The weather over a rectangle, to the generators. Heights above the local ground plane z = 0.
struct Weather {
    CloudType type = CloudType::cumulus;
    float cover = 0.4F; // fraction of the rectangle with cloud above it, 0 .. 1
    float base_m = 1200.0F;
    float top_m = 2200.0F;
    glm::vec2 wind_m_s{8.0F, 0.0F}; // stretches cirrus and shears towers; whoever moves the cloud uses it too
    std::uint32_t seed = 1;
};

// Clouds over [-extent/2, extent/2] in x and y. Density is 0 .. 1. voxel_m > 0; extent and heights give at most
// 2048 voxels an axis (asserted).
[[nodiscard]] SparseGrid generate(const Weather& weather, const glm::vec2& extent_m, float voxel_m);

// One billowed cumulus of about 130 x 155 x 90 voxels of 1 m (x, y, z; about 410 thousand of them active), the
// benchmarks' cloud: with an extinction of 1 a metre one voxel is one mean free path in its densest part. `seed` gives
// others of its kind.
[[nodiscard]] SparseGrid cumulus_of_study(std::uint32_t seed = 1);

// A ragged noise cloud with gradual densities, the second kind that methods are held to. `voxels` a side.
[[nodiscard]] SparseGrid noise_cloud(std::uint32_t seed, int voxels);

} // namespace alpenglow::clouds
