// Pictures of a lit cloud.
#pragma once

#include <span>

#include <alpenglow/clouds/lighting.hpp>

namespace alpenglow::clouds {

struct MarchSettings {
    float step_voxels = 1.0F; // of the smallest voxel side, where there is matter
    float optical_step =
        0.0F; // > 0: deep inside, steps grow until they span this optical depth at the transmittance left
    float stop_transmittance = 1e-3F;          // rays end here; what is left of them counts as opaque
    std::span<const float> scene_depth_m = {}; // distance to opaque geometry for each pixel; empty: none
    unsigned threads = 0;
};

// Front to back through the bricks, vectorised over pixels. Each step is integrated analytically with its midpoint's
// source (Harris: eq. 9, a Riemann sum, as it stands). The light of each directional source is looked up by optical
// depth and angle, everything else in the fields contracted for this eye.
[[nodiscard]] Picture march(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                            const MarchSettings& settings = {});

// The same, pixel by pixel and in plain code: what tests hold march() to. step_voxels alone matters.
[[nodiscard]] Picture march_scalar(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                                   const MarchSettings& settings = {});

// One ray of march_scalar(), with fields contracted by the caller. eye: index coordinates; world: unit.
struct RayLight {
    glm::vec3 radiance{0.0F};
    float transmittance = 1.0F;
    float depth_m = 0.0F;
};
[[nodiscard]] RayLight march_ray(const BrickVolume& volume, const CloudLighting& lighting,
                                 const CloudLighting::ViewFields& fields, const glm::dvec3& eye, const glm::vec3& world,
                                 const MarchSettings& settings, float t_end);

} // namespace alpenglow::clouds
