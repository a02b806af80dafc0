// Bakes self-transfer of a volume: smoke or a small cloud that shades itself. Sloan, Kautz and Snyder (2002),
// section 7.
#pragma once

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/field_part.hpp>

namespace alpenglow::prt {

// Extinction at grid points, per metre; trilinear between them, zero outside.
struct VolumeDensity {
    Grid grid;
    std::vector<float> extinction_per_m;
};

struct VolumeSettings {
    int order = 5;
    std::size_t directions = 128; // a voxel
    float albedo = 0.9F;          // single scattering, isotropic
    int max_bounces = 16;
    double stop_energy = 1e-3;
    unsigned threads = 0;
    ProgressCallback progress;
};

// One vector a grid point: light coefficients -> mean radiance that arrives there (fluence over 4 pi), so that a voxel
// sends out albedo x extinction x (M L) per metre. The direct part is the paper's, attenuation along each ray to the
// grid's end; bounces gather what scatters along the rays, where the paper deposits it. Points with no extinction in
// the cells around them are left at zero: nothing shows there.
[[nodiscard]] Result<Bake> bake_volume(const VolumeDensity& density, const VolumeSettings& settings);

// The same in parts. Bounces need all voxels: `finish_volume` walks them.
[[nodiscard]] Result<FieldPart> bake_volume_part(const VolumeDensity& density, const VolumeSettings& settings,
                                                 std::size_t first, std::size_t count);
[[nodiscard]] Result<Bake> finish_volume(const VolumeDensity& density, const VolumeSettings& settings,
                                         std::vector<FieldPart> parts);

} // namespace alpenglow::prt
