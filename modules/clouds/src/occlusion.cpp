#include <alpenglow/clouds/occlusion.hpp>

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

namespace alpenglow::clouds {

CloudShadow::CloudShadow(const BrickVolume& volume, const CloudLighting& lighting, std::size_t light, int factor)
    : transform_(volume.transform()) {
    assert(light < lighting.lights().size());
    if (volume.empty()) {
        return;
    }
    const Lattice lattice = lattice_over(volume, factor, 1, std::size_t(4) << 20);
    const std::vector<float> density = volume.block_means(lattice.first, lattice.dims, lattice.factor);
    const glm::vec3 block = glm::vec3(transform_.voxel_m) * static_cast<float>(lattice.factor);
    const auto scaled = static_cast<float>(scaled_medium(lighting.medium()).extinction);
    LightDepth depth = light_depth(lattice, density, block, lighting.lights()[light].to_light, 1.0F);
    const float extinction = lighting.medium().extinction_per_m * scaled;
    for (float& d : depth.depth) {
        d = std::min(d * extinction, 80.0F);
    }
    for (float& d : depth.behind) {
        d = std::min(d * extinction, 80.0F);
    }
    field_ = Field16(lattice, depth.depth);
    columns_ = depth.columns;
    depth_ = std::move(depth.behind);
}

float CloudShadow::transmittance(const glm::dvec3& world_m) const {
    if (depth_.empty()) {
        return 1.0F;
    }
    const Lattice& l = field_.lattice;
    const glm::dvec3 index = transform_.index_from_world(world_m);
    const glm::dvec3 block = (index - glm::dvec3(l.first) - 0.5 * (l.factor - 1)) / double(l.factor);
    const int ua = columns_.axis == 0 ? 1 : 0;
    const int va = columns_.axis == 2 ? 1 : 2;
    const int na = l.dims[columns_.axis];
    // Slices from the one nearest to the light.
    const double slice = columns_.light_above ? na - 1 - block[columns_.axis] : block[columns_.axis];
    if (slice < 0.0) {
        return 1.0F;
    }
    if (slice < na - 1 && block[ua] >= 0.0 && block[va] >= 0.0 && block[ua] <= l.dims[ua] - 1 &&
        block[va] <= l.dims[va] - 1) {
        return std::exp(-field_.sample(glm::vec3(index)));
    }
    const double u = block[ua] + double(columns_.shift_u) * slice - columns_.first.x;
    const double v = block[va] + double(columns_.shift_v) * slice - columns_.first.y;
    if (!(u >= 0.0 && v >= 0.0 && u < columns_.dims.x - 1 && v < columns_.dims.y - 1)) {
        return 1.0F;
    }
    // Beside the cloud but not yet behind it: columns may still meet matter further down, which lies behind the point.
    if (slice < na - 1) {
        return 1.0F;
    }
    const int iu = static_cast<int>(u);
    const int iv = static_cast<int>(v);
    const auto tu = static_cast<float>(u - iu);
    const auto tv = static_cast<float>(v - iv);
    const float* at = depth_.data() + std::size_t(iv) * std::size_t(columns_.dims.x) + std::size_t(iu);
    const float near = at[0] + tu * (at[1] - at[0]);
    const float far = at[columns_.dims.x] + tu * (at[columns_.dims.x + 1] - at[columns_.dims.x]);
    return std::exp(-(near + tv * (far - near)));
}

namespace {

// Calls add(direction, solid angle, transmittance, radiance) for directions on a Fibonacci spiral.
template <class Add>
void look_around(std::span<const LitCloud> clouds, const glm::dvec3& position_m, int rays, Add&& add) {
    assert(rays > 0);
    // Clouds that share their light share its fields.
    std::map<const CloudLighting*, CloudLighting::ViewFields> made;
    std::vector<const CloudLighting::ViewFields*> fields;
    for (const LitCloud& cloud : clouds) {
        const auto [at, fresh] = made.try_emplace(cloud.lighting);
        if (fresh) {
            at->second = cloud.lighting->contract_mean();
        }
        fields.push_back(&at->second);
    }
    MarchSettings settings;
    settings.step_voxels = 2.0F; // what a probe keeps of it is a few bands
    std::vector<RayLight> hits(clouds.size());
    std::vector<std::size_t> order(clouds.size());
    for (int i = 0; i < rays; ++i) {
        const double z = 1.0 - 2.0 * (i + 0.5) / rays;
        const double azimuth = pi * (3.0 - std::sqrt(5.0)) * i;
        const double s = std::sqrt(1.0 - z * z);
        const glm::vec3 direction(glm::dvec3(s * std::cos(azimuth), s * std::sin(azimuth), z));
        for (std::size_t c = 0; c < clouds.size(); ++c) {
            const BrickVolume& volume = *clouds[c].volume;
            order[c] = c;
            hits[c] = volume.empty() ? RayLight{}
                                     : march_ray(volume, *clouds[c].lighting, *fields[c],
                                                 volume.transform().index_from_world(position_m - clouds[c].offset_m),
                                                 direction, settings, 1e30F);
        }
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return hits[a].depth_m < hits[b].depth_m; });
        float transmittance = 1.0F;
        glm::vec3 radiance(0.0F);
        for (const std::size_t c : order) {
            radiance += hits[c].radiance * transmittance;
            transmittance *= hits[c].transmittance;
        }
        add(direction, static_cast<float>(4.0 * pi / rays), transmittance, radiance);
    }
}

} // namespace

CloudEnvironment cloud_environment(std::span<const LitCloud> clouds, const glm::dvec3& position_m, int rays) {
    CloudEnvironment out;
    look_around(clouds, position_m, rays,
                [&](const glm::vec3& direction, float weight, float transmittance, const glm::vec3& radiance) {
                    float y[16];
                    sh_bands4(direction, y);
                    for (std::size_t k = 0; k < 16; ++k) {
                        out.transmittance[k] += weight * transmittance * y[k];
                        out.radiance[k] += radiance * (weight * y[k]);
                    }
                });
    return out;
}

SkySh sky_behind_clouds(const SkySh& sky, std::span<const LitCloud> clouds, const glm::dvec3& position_m, int rays) {
    SkySh out;
    out.bands = 4;
    look_around(clouds, position_m, rays,
                [&](const glm::vec3& direction, float weight, float transmittance, const glm::vec3& radiance) {
                    float y[16];
                    sh_bands4(direction, y);
                    const glm::vec3 seen = sky.radiance(direction) * transmittance + radiance;
                    for (std::size_t k = 0; k < 16; ++k) {
                        out.coefficients[k] += seen * (weight * y[k]);
                    }
                });
    return out;
}

} // namespace alpenglow::clouds
