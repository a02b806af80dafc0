#include <alpenglow/clouds/compact.hpp>
#include <alpenglow/clouds/march.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {

namespace {

// A lit cloud as a ray reads it: bricks and dense fields, or the compact form.
struct Plain {
    const BrickVolume& volume;
    const CloudLighting& lighting;
    const CloudLighting::ViewFields& view;

    [[nodiscard]] const BrickVolume& box() const { return volume; }
    [[nodiscard]] float density(const glm::vec3& p) const { return volume.sample(p); }
    [[nodiscard]] const std::vector<BakedLight>& lights() const { return lighting.lights(); }
    [[nodiscard]] const std::vector<Field16>& fields() const { return view.fields; }
    [[nodiscard]] const glm::vec3& colour() const { return view.colour; }
    [[nodiscard]] const BeamTable& table() const { return lighting.table(); }
    [[nodiscard]] float eye_extinction() const { return lighting.eye_extinction(); }
    [[nodiscard]] float extinction_per_m() const {
        return lighting.medium().extinction_per_m * lighting.eye_extinction();
    }
    [[nodiscard]] bool riemann() const { return lighting.settings().method == LightingMethod::harris; }
};

struct Compact {
    const CompactCloud& cloud;

    [[nodiscard]] const CompactCloud& box() const { return cloud; }
    [[nodiscard]] float density(const glm::vec3& p) const { return cloud.density().sample(p); }
    [[nodiscard]] const std::vector<CompactCloud::Light>& lights() const { return cloud.lights(); }
    [[nodiscard]] const std::vector<CompactField>& fields() const { return cloud.fields(); }
    [[nodiscard]] const glm::vec3& colour() const { return cloud.colour(); }
    [[nodiscard]] const CompactTable& table() const { return cloud.table(); }
    [[nodiscard]] float eye_extinction() const { return cloud.eye_extinction(); }
    [[nodiscard]] float extinction_per_m() const { return cloud.extinction_per_m(); }
    [[nodiscard]] bool riemann() const { return cloud.riemann(); }
};

template <class From>
RayLight ray_through(const From& from_cloud, const glm::dvec3& eye, const glm::vec3& world,
                     const MarchSettings& settings, float t_end, float t_start) {
    RayLight out;
    const auto& box = from_cloud.box();
    const GridTransform& transform = box.transform();
    const auto voxel = static_cast<float>(std::min({transform.voxel_m.x, transform.voxel_m.y, transform.voxel_m.z}));
    const float step = settings.step_voxels * voxel;
    const float extinction = from_cloud.extinction_per_m();
    const bool riemann = from_cloud.riemann();
    const glm::dvec3 low = glm::dvec3(box.active_low() - 1);
    const glm::dvec3 high = glm::dvec3(box.active_high() + 1);
    const glm::vec3 local(transform.local_direction(glm::dvec3(world)));
    const glm::vec3 d = local / glm::vec3(transform.voxel_m);
    double enter = std::max(0.0, double(t_start));
    auto leave = double(t_end);
    for (int a = 0; a < 3; ++a) {
        const double inverse = 1.0 / (std::abs(d[a]) < 1e-12F ? std::copysign(1e-12, double(d[a])) : double(d[a]));
        const double u = (low[a] - eye[a]) * inverse;
        const double v = (high[a] - eye[a]) * inverse;
        enter = std::max(enter, std::min(u, v));
        leave = std::min(leave, std::max(u, v));
    }
    if (!(enter < leave)) {
        return out;
    }
    // Samples lie at the middles of steps counted from the eye, so that they do not slide with the box; distances are
    // counted from the step that enters it, so that far eyes keep their digits.
    const double base = std::floor(enter / double(step)) * double(step);
    const glm::vec3 origin(eye + glm::dvec3(d) * base);
    const auto t0 = static_cast<float>(enter - base);
    const auto t1 = static_cast<float>(leave - base);
    glm::vec3 sum(0.0F);
    float transmittance = 1.0F;
    float depth = 0.0F;
    float depth_2 = 0.0F;
    float weight = 0.0F;
    for (float k = 0.0F; transmittance > settings.stop_transmittance; ++k) {
        const float from = std::max(k * step, t0);
        const float to = std::min((k + 1.0F) * step, t1);
        if (!(from < t1)) {
            break;
        }
        if (!(to > from)) {
            continue;
        }
        const float t = 0.5F * (from + to);
        const glm::vec3 p = origin + d * t;
        float density = from_cloud.density(p);
        if (settings.detail != nullptr && density > 0.0F) {
            const glm::vec3 cell = (p - glm::vec3(box.min())) * settings.detail_cells;
            const float noise = settings.detail_offsets ? settings.detail->sample(cell, *settings.detail_offsets)
                                                        : settings.detail->sample(cell);
            density = detailed_density(density, 1.0F / box.max_density(), settings.detail_strength, noise);
        }
        const float s = extinction * density;
        if (s <= 0.0F) {
            continue;
        }
        glm::vec3 source(0.0F);
        for (const auto& light : from_cloud.lights()) {
            const glm::vec3 difference = light.to_light - local;
            const float omc =
                0.5F * (difference.x * difference.x + difference.y * difference.y + difference.z * difference.z);
            source += light.irradiance * from_cloud.table().value(light.depth.sample(p), omc);
        }
        source /= from_cloud.eye_extinction();
        const auto& fields = from_cloud.fields();
        if (fields.size() == 1) {
            source += from_cloud.colour() * fields[0].sample(p);
        } else if (fields.size() == 3) {
            source += glm::vec3(fields[0].sample(p), fields[1].sample(p), fields[2].sample(p));
        }
        const float tau = s * (to - from);
        const float opacity = -std::expm1(-tau);
        sum += source * (transmittance * (riemann ? tau : opacity));
        depth += transmittance * opacity * t;
        depth_2 += transmittance * opacity * t * t;
        weight += transmittance * opacity;
        transmittance *= std::exp(-tau);
    }
    if (transmittance <= settings.stop_transmittance) {
        sum /= 1.0F - transmittance;
        transmittance = 0.0F;
    }
    out.radiance = glm::vec3(std::max(sum.x, 0.0F), std::max(sum.y, 0.0F), std::max(sum.z, 0.0F));
    out.transmittance = transmittance;
    out.depth_m = weight > 0.0F ? static_cast<float>(base + double(depth / weight)) : 0.0F;
    const float mean = weight > 0.0F ? depth / weight : 0.0F;
    out.spread_m = weight > 0.0F ? std::sqrt(std::max(0.0F, depth_2 / weight - mean * mean)) : 0.0F;
    return out;
}

template <class From>
Picture picture_of(const From& from, const Camera& camera, const MarchSettings& settings) {
    Picture picture(camera.width, camera.height);
    const glm::dvec3 eye = from.box().transform().index_from_world(camera.position_m);
    parallel_for(
        picture.radiance.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                const glm::vec3 world = camera.direction(static_cast<float>(pixel % std::size_t(camera.width)) + 0.5F,
                                                         static_cast<float>(pixel / std::size_t(camera.width)) + 0.5F);
                const float t_end = settings.scene_depth_m.empty() ? 1e30F : settings.scene_depth_m[pixel];
                const float t_start = settings.from_m.empty() ? 0.0F : settings.from_m[pixel];
                const RayLight ray = ray_through(from, eye, world, settings, t_end, t_start);
                picture.radiance[pixel] = ray.radiance;
                picture.transmittance[pixel] = ray.transmittance;
                picture.depth_m[pixel] = ray.depth_m;
                picture.spread_m[pixel] = ray.spread_m;
            }
        },
        settings.threads);
    return picture;
}

} // namespace

RayLight march_ray(const BrickVolume& volume, const CloudLighting& lighting, const CloudLighting::ViewFields& fields,
                   const glm::dvec3& eye, const glm::vec3& world, const MarchSettings& settings, float t_end,
                   float t_start) {
    return ray_through(Plain{volume, lighting, fields}, eye, world, settings, t_end, t_start);
}

Picture march_scalar(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                     const MarchSettings& settings) {
    if (volume.empty()) {
        return Picture(camera.width, camera.height);
    }
    const glm::dvec3 eye = volume.transform().index_from_world(camera.position_m);
    const CloudLighting::ViewFields here =
        settings.fields == nullptr ? lighting.contract(eye) : CloudLighting::ViewFields{};
    return picture_of(Plain{volume, lighting, settings.fields == nullptr ? here : *settings.fields}, camera, settings);
}

Picture march_scalar(const CompactCloud& cloud, const Camera& camera, const MarchSettings& settings) {
    return cloud.empty() ? Picture(camera.width, camera.height) : picture_of(Compact{cloud}, camera, settings);
}

} // namespace alpenglow::clouds
