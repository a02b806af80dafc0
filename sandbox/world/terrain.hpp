// The landscape: an alpine valley with its ranges, generated from a seed.
#pragma once

#include "grid.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// Two nested square grids around (0, 0): `outer` reaches the horizon, `inner` has 8 times finer samples in the middle.
// Every outer sample that lies in the inner square equals the inner sample there; along the inner border the two
// surfaces agree.
struct Terrain {
    static constexpr int samples = 1025;                              // a side, of both grids
    static constexpr int ratio = 8;                                   // outer spacing over inner spacing
    static constexpr float inner_spacing_m = 16.0F;                   // 16.4 km a side
    static constexpr float outer_spacing_m = inner_spacing_m * ratio; // 131 km a side

    HeightGrid inner;
    HeightGrid outer;
    std::vector<float> inner_area_m2; // drainage area, for streams and moisture; not kept past the ground's colours
    std::vector<float> outer_area_m2;
    std::uint32_t seed = 0;

    // Bilinear height above sea level, of the finest grid there is; clamped to the outer square.
    [[nodiscard]] float height_m(glm::vec2 position_m) const;
};

// Deterministic: the same seed gives the same bits, whatever the thread count. About a second on two cores.
[[nodiscard]] Terrain generate_terrain(std::uint32_t seed);

// Unit normal at a sample, from central differences over two samples each way.
[[nodiscard]] glm::vec3 grid_normal(const HeightGrid& grid, int i, int j);

// Linear Rec.709 reflectance of the ground: fields, meadow, forest, rock, scree, snow, water, by slope, height and
// moisture, for samples `spacing_m` apart.
[[nodiscard]] glm::vec3 ground_albedo(const Terrain& terrain, glm::vec2 position_m, float height_m, glm::vec3 normal,
                                      float drainage_m2, float spacing_m);

// Within one of the woods on the valley floors, 0 .. 1: shared by albedo and by the placing of trees.
[[nodiscard]] float wood_cover(const Terrain& terrain, glm::vec2 position_m);

// The lake on the valley floor: its surface height, and a signed distance (negative over water).
[[nodiscard]] float lake_height_m();
[[nodiscard]] float lake_distance_m(glm::vec2 position_m);

} // namespace alpenglow::sandbox
