#include "sandbox/app/cloud_shadow_map.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include <alpenglow/clouds/occlusion.hpp>
#include <alpenglow/core/parallel_for.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

float shadow_at(const CloudShadowMap& map, const glm::vec3& point_m) {
    if (map.size == 0 || point_m.z >= map.top_m) {
        return 1.0F;
    }
    const glm::vec2 along = glm::vec2(map.to_light) / std::max(map.to_light.z, 0.03F);
    const glm::vec2 at = (glm::vec2(point_m) + along * (map.plane_m - point_m.z) - map.offset_m) / map.extent_m;
    const auto size = static_cast<float>(map.size);
    const glm::vec2 texel = size * (at - glm::floor(at)) + (size - 0.5F);
    const glm::ivec2 first(texel);
    const glm::vec2 part = texel - glm::vec2(first);
    const auto value = [&](int x, int y) {
        return static_cast<float>(map.texels[static_cast<std::size_t>((y % map.size) * map.size + x % map.size)]) /
               255.0F;
    };
    const float through =
        glm::mix(glm::mix(value(first.x, first.y), value(first.x + 1, first.y), part.x),
                 glm::mix(value(first.x, first.y + 1), value(first.x + 1, first.y + 1), part.x), part.y);
    return glm::mix(through, 1.0F, glm::smoothstep(map.base_m, map.top_m, point_m.z));
}

void CloudShadowMaker::make(std::span<const ShadowCaster> casters, const glm::vec3& to_light, double extent_m) {
    double low = 1e30;
    double high = -1e30;
    std::vector<clouds::CloudShadow> shadows;
    for (const ShadowCaster& caster : casters) {
        const clouds::BrickVolume& volume = *caster.cloud.volume;
        // Columns a third of a texel wide: finer ones would not show.
        const double texel_voxels = extent_m / cloud_shadow_size / volume.transform().voxel_m.x;
        shadows.emplace_back(volume, *caster.cloud.lighting, caster.light,
                             std::clamp(static_cast<int>(texel_voxels / 3.0), 1, 8));
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 index((corner & 1) != 0 ? volume.active_high().x : volume.active_low().x,
                                   (corner & 2) != 0 ? volume.active_high().y : volume.active_low().y,
                                   (corner & 4) != 0 ? volume.active_high().z : volume.active_low().z);
            const double z = volume.transform().world_from_index(index).z;
            low = std::min(low, z);
            high = std::max(high, z);
        }
    }
    const double plane = low - 20.0;
    const double texel_m = extent_m / cloud_shadow_size;
    const int copies = to_light.z < 0.15F ? 2 : 1; // a low light's way through a layer is long
    std::array<double, cloud_shadow_size> sums{};
    parallel_for(cloud_shadow_size, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) {
            for (std::size_t i = 0; i < cloud_shadow_size; ++i) {
                const glm::dvec3 at((static_cast<double>(i) + 0.5) * texel_m - 0.5 * extent_m,
                                    (static_cast<double>(j) + 0.5) * texel_m - 0.5 * extent_m, plane);
                float through = 1.0F;
                for (std::size_t c = 0; c < casters.size(); ++c) {
                    const double repeat = casters[c].repeat_m > 0.0 ? casters[c].repeat_m : extent_m;
                    for (int v = -copies; v <= copies; ++v) {
                        for (int u = -copies; u <= copies; ++u) {
                            through *= shadows[c].transmittance(at - glm::dvec3(u * repeat, v * repeat, 0.0));
                        }
                    }
                }
                texels_[j * cloud_shadow_size + i] = static_cast<std::uint8_t>(std::lround(255.0F * through));
                sums[j] += static_cast<double>(through);
            }
        }
    });
    double sum = 0.0;
    for (const double s : sums) {
        sum += s;
    }
    mean_ = static_cast<float>(sum / (double(cloud_shadow_size) * cloud_shadow_size));
    map_.texels = texels_;
    map_.size = cloud_shadow_size;
    map_.extent_m = static_cast<float>(extent_m);
    map_.offset_m = glm::vec2(static_cast<float>(-0.5 * extent_m));
    map_.plane_m = static_cast<float>(plane);
    map_.base_m = static_cast<float>(low);
    map_.top_m = static_cast<float>(high);
    map_.to_light = to_light;
    map_.revision = next_revision();
}

} // namespace alpenglow::sandbox
