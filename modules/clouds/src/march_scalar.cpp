#include <alpenglow/clouds/march.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {

Picture march_scalar(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                     const MarchSettings& settings) {
    Picture picture(camera.width, camera.height);
    if (volume.empty()) {
        return picture;
    }
    const GridTransform& transform = volume.transform();
    const glm::dvec3 eye = transform.index_from_world(camera.position_m);
    const CloudLighting::ViewFields fields = lighting.contract(eye);
    const auto voxel = static_cast<float>(std::min({transform.voxel_m.x, transform.voxel_m.y, transform.voxel_m.z}));
    const float step = settings.step_voxels * voxel;
    const float extinction = lighting.medium().extinction_per_m * lighting.eye_extinction();
    const bool riemann = lighting.settings().method == LightingMethod::harris;
    const glm::vec3 low = glm::vec3(volume.active_low()) - 1.0F;
    const glm::vec3 high = glm::vec3(volume.active_high()) + 1.0F;
    parallel_for(
        picture.radiance.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                const glm::vec3 world = camera.direction(static_cast<float>(pixel % std::size_t(camera.width)) + 0.5F,
                                                         static_cast<float>(pixel / std::size_t(camera.width)) + 0.5F);
                const glm::vec3 local(transform.local_direction(glm::dvec3(world)));
                const glm::vec3 d = local / glm::vec3(transform.voxel_m);
                float t0 = 0.0F;
                float t1 = settings.scene_depth_m.empty() ? 1e30F : settings.scene_depth_m[pixel];
                for (int a = 0; a < 3; ++a) {
                    const float inverse = 1.0F / (std::abs(d[a]) < 1e-12F ? std::copysign(1e-12F, d[a]) : d[a]);
                    const float u = (low[a] - static_cast<float>(eye[a])) * inverse;
                    const float v = (high[a] - static_cast<float>(eye[a])) * inverse;
                    t0 = std::max(t0, std::min(u, v));
                    t1 = std::min(t1, std::max(u, v));
                }
                float transmittance = 1.0F;
                glm::vec3 sum(0.0F);
                float depth = 0.0F;
                float weight = 0.0F;
                // Samples at the middles of steps counted from the eye, so that they do not slide with the box.
                for (float k = std::max(0.0F, std::floor(t0 / step)); transmittance > settings.stop_transmittance;
                     ++k) {
                    const float from = std::max(k * step, t0);
                    const float to = std::min((k + 1.0F) * step, t1);
                    if (!(from < t1)) {
                        break;
                    }
                    if (!(to > from)) {
                        continue;
                    }
                    const float t = 0.5F * (from + to);
                    const glm::vec3 p = glm::vec3(eye) + d * t;
                    const float s = extinction * volume.sample(p);
                    if (s <= 0.0F) {
                        continue;
                    }
                    glm::vec3 source(0.0F);
                    for (const BakedLight& light : lighting.lights()) {
                        const glm::vec3 difference = light.to_light - local;
                        const float omc = 0.5F * (difference.x * difference.x + difference.y * difference.y +
                                                  difference.z * difference.z);
                        source += light.irradiance * lighting.table().value(light.depth.sample(p), omc);
                    }
                    source /= lighting.eye_extinction();
                    if (fields.fields.size() == 1) {
                        source += fields.colour * fields.fields[0].sample(p);
                    } else if (fields.fields.size() == 3) {
                        source += glm::vec3(fields.fields[0].sample(p), fields.fields[1].sample(p),
                                            fields.fields[2].sample(p));
                    }
                    const float tau = s * (to - from);
                    const float opacity = -std::expm1(-tau);
                    sum += source * (transmittance * (riemann ? tau : opacity));
                    depth += transmittance * opacity * t;
                    weight += transmittance * opacity;
                    transmittance *= std::exp(-tau);
                }
                if (transmittance <= settings.stop_transmittance) {
                    sum /= 1.0F - transmittance;
                    transmittance = 0.0F;
                }
                picture.radiance[pixel] =
                    glm::vec3(std::max(sum.x, 0.0F), std::max(sum.y, 0.0F), std::max(sum.z, 0.0F));
                picture.transmittance[pixel] = transmittance;
                picture.depth_m[pixel] = weight > 0.0F ? depth / weight : 0.0F;
            }
        },
        settings.threads);
    return picture;
}

} // namespace alpenglow::clouds
