// Dense scalar fields over a cloud, and its optical depth towards a light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/clouds/bricks.hpp>

namespace alpenglow::clouds {

// A dense lattice of blocks of `factor`^3 voxels. Block (0, 0, 0) begins at voxel `first`; its centre has the index
// coordinates first + (factor - 1) / 2.
struct Lattice {
    glm::ivec3 first{0};
    glm::ivec3 dims{0};
    int factor = 1;

    [[nodiscard]] std::size_t cells() const { return std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z); }
    bool operator==(const Lattice&) const = default;
};

// The lattice over the volume's active voxels with a margin of `margin` blocks, at the smallest factor >= `factor` that
// keeps it within max_cells.
[[nodiscard]] Lattice lattice_over(const BrickVolume& volume, int factor, int margin, std::size_t max_cells);

// Values on a lattice in 16 bits: offset + scale * value. Interpolated trilinearly between block centres, clamped
// outside.
struct Field16 {
    Lattice lattice;
    float offset = 0.0F;
    float scale = 0.0F;
    std::vector<std::uint16_t> values; // x fastest; one more at the end, so that pairs can be read as 32 bits

    Field16() = default;
    Field16(const Lattice& lattice, const std::vector<float>& values); // the range is the values' own
    [[nodiscard]] float sample(const glm::vec3& index) const;          // at index coordinates
    [[nodiscard]] std::size_t memory_bytes() const { return values.size() * sizeof(std::uint16_t); }
};

// Optical depth from each block's centre to the light, by sheared columns: slices across the light's main axis are
// taken one after the other, from the light's side; columns that run along the light gather the trapezoid rule of the
// density resampled once per slice, and each slice's depths are read back at block centres with one cubic
// interpolation. A sweep that interpolates depths again at every step blurs them, and ruins pictures against the light.
struct LightColumns {
    int axis = 2;         // the light's main axis; u and v are the other two, the lower first
    float shift_u = 0.0F; // blocks that a column moves towards the light a slice
    float shift_v = 0.0F;
    bool light_above = true; // the light is on the axis's high side
    glm::ivec2 first{0};     // column (0, 0) passes block (first.x, first.y) of the slice nearest to the light
    glm::ivec2 dims{0};
};

struct LightDepth {
    std::vector<float> depth; // of each block centre, unit density * metres: multiply by Medium::extinction_per_m
    LightColumns columns;
    std::vector<float> behind; // depth of each whole column, u fastest
    double removed_m2 = 0.0;   // integral over the light's wave front of 1 - exp(-factor * depth of the whole column)
};

// `density`: block means on `lattice`, x fastest. block_m: the blocks' size. to_light: unit, in the grid's frame.
// removal_per_density: the factor in removed_m2.
[[nodiscard]] LightDepth light_depth(const Lattice& lattice, const std::vector<float>& density,
                                     const glm::vec3& block_m, const glm::vec3& to_light, float removal_per_density);

// Depths for reading by trilinear interpolation: less a twelfth of their second differences, so that what is read has
// the mean that it should have over each block (lines between the values of a convex function lie above it, and clouds
// would be darker by 2 %). Not below 0; the lattice's outer layer stays.
[[nodiscard]] std::vector<float> sharpened(const Lattice& lattice, const std::vector<float>& depth);

// Harris's multiple forward scattering (course notes, cloud rendering, eq. 8) along the same columns, a slice a
// particle: I_1 = 1, I_k = (a p(l, -l) / (4 pi) tau_(k-1) + exp(-tau_(k-1))) I_(k-1) with tau = extinction * density *
// slab thickness. `gain` is a p(l, -l) / (4 pi). Returns -log I at block centres; a strong forward phase makes I grow
// and the log positive, as the paper's equations do, unless `saturate` holds I at 1 like the frame buffer that the
// paper computes it in.
[[nodiscard]] std::vector<float> harris_depth(const Lattice& lattice, const std::vector<float>& density,
                                              const glm::vec3& block_m, const glm::vec3& to_light,
                                              float extinction_per_m, float gain, bool saturate);

// Eq. 8 and eq. 9 as they stand, for one line of particles: the scalar reference. incident[k] is I_k for I_0 = 1.
void harris_incident(const float* tau, int count, double gain, double* incident);
// E_N for particles from far to near with S_k = albedo tau_k p / (4 pi) I_k; phase is p / (4 pi).
[[nodiscard]] double harris_exitant(const float* tau, const double* incident, int count, double albedo, double phase);

// The slow way, for tests and benchmarks: trapezoid march of `step` voxels from one point until it leaves the volume.
[[nodiscard]] double marched_depth(const BrickVolume& volume, const glm::dvec3& index, const glm::vec3& to_light,
                                   double step);

} // namespace alpenglow::clouds
