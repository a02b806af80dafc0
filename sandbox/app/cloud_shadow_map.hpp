// The clouds' shadow over the valley, as a map that repeats with the layer of clouds: it drifts by moving, not by being
// made again.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <alpenglow/clouds/march.hpp>

#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {

// A cloud where it stands without wind. `repeat_m`: of a layer; 0: stands alone.
struct ShadowCaster {
    clouds::LitCloud cloud;
    std::size_t light = 0; // of the cloud's lighting
    double repeat_m = 0.0;
};

// Transmittance that the map has for a point of the world, as light.glsl looks it up; 1 without a map.
[[nodiscard]] float shadow_at(const CloudShadowMap& map, const glm::vec3& point_m);

class CloudShadowMaker {
public:
    // The map for clouds whose light comes from `to_light`; the map's offset is that of no wind.
    void make(std::span<const ShadowCaster> casters, const glm::vec3& to_light, double extent_m);
    [[nodiscard]] const CloudShadowMap& map() const { return map_; }
    [[nodiscard]] float mean() const { return mean_; } // transmittance over the map

private:
    std::array<std::uint8_t, std::size_t(cloud_shadow_size) * cloud_shadow_size> texels_{};
    CloudShadowMap map_;
    float mean_ = 1.0F;
};

} // namespace alpenglow::sandbox
