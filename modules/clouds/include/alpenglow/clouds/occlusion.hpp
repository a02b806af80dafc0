// What clouds do to everything else: shadows on terrain and objects, and the sky that probes see.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <alpenglow/clouds/march.hpp>

namespace alpenglow::clouds {

// One light's transmittance through a cloud to any point of the world: the columns of light_depth() with all of the
// cloud behind them, addressed by the point. Points inside the cloud use the baked depth. A cloud that moves takes its
// shadow along: pass points minus CloudVolume::offset_m.
class CloudShadow {
public:
    CloudShadow() = default;
    // For light i of `lighting`. Columns of `factor` voxels. Scattering within the forward peak does not darken: what
    // it sends on arrives within degrees of the light, so that the scaled extinction counts (delta-M).
    CloudShadow(const BrickVolume& volume, const CloudLighting& lighting, std::size_t light, int factor = 2);

    // 0 .. 1. Points on the light's side of the cloud: 1.
    [[nodiscard]] float transmittance(const glm::dvec3& world_m) const;
    [[nodiscard]] std::size_t memory_bytes() const { return depth_.size() * sizeof(float) + field_.memory_bytes(); }

private:
    GridTransform transform_;
    Field16 field_; // scaled optical depth of block centres
    LightColumns columns_;
    std::vector<float> depth_; // of whole columns, scaled
};

// Clouds as a probe sees them, projected on SH up to band 3 (SkySh's order and signs, world frame), from `rays`
// directions.
struct CloudEnvironment {
    std::array<float, 16> transmittance{}; // of the sky behind; an open sky is {3.5449, 0, ...}
    std::array<glm::vec3, 16> radiance{};  // of the clouds themselves
};

// Clouds may overlap on a ray: they are taken from near to far by their mean depth.
[[nodiscard]] CloudEnvironment cloud_environment(std::span<const LitCloud> clouds, const glm::dvec3& position_m,
                                                 int rays = 192);

// Sky behind clouds: the product of the sky's radiance and the transmittance, plus the clouds' radiance, by the same
// directions as cloud_environment() would take (so that their error is one): for probes that want one SH vector.
[[nodiscard]] SkySh sky_behind_clouds(const SkySh& sky, std::span<const LitCloud> clouds, const glm::dvec3& position_m,
                                      int rays = 192);

} // namespace alpenglow::clouds
