// Clouds as impostors' subjects: the march of one cloud from a pinhole as what a capture asks for.
#pragma once

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/impostors/capture.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace alpenglow {

// A lit cloud, where it stands. What it points to outlives the Drawable.
struct CloudSubject {
    const clouds::BrickVolume* volume = nullptr;
    const clouds::CloudLighting* lighting = nullptr;
    glm::dvec3 offset_m{0.0};
    clouds::MarchSettings march;
    float scale = 1.0F; // on radiance: the exposure, say
};

// The march's pinhole: its axes need not be orthonormal, so that a window off centre is a leaning forward axis.
[[nodiscard]] inline clouds::Camera cloud_camera(const impostors::Frustum& view, const glm::dvec3& offset_m = {}) {
    clouds::Camera camera;
    camera.position_m = view.eye_m - offset_m;
    camera.forward = glm::vec3(view.forward + 0.5 * (view.tan_left + view.tan_right) * view.right +
                               0.5 * (view.tan_bottom + view.tan_top) * view.up);
    camera.right = glm::vec3(view.right * (view.pixels_per_tan_y() / view.pixels_per_tan_x()));
    camera.up = glm::vec3(view.up);
    camera.tan_half_height = static_cast<float>(0.5 * (view.tan_top - view.tan_bottom));
    camera.width = view.width;
    camera.height = view.height;
    return camera;
}

// Marches each slab by itself. All light follows the key light (SlabImage::fill stays empty).
[[nodiscard]] inline impostors::Drawable cloud_drawable(const CloudSubject& subject) {
    return [subject](const impostors::CaptureRequest& request, std::span<impostors::SlabImage> slabs) -> Status {
        const clouds::Camera camera = cloud_camera(request.view, subject.offset_m);
        const auto texels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        std::vector<float> per_depth(texels); // distance over axis depth
        for (std::size_t i = 0; i < texels; ++i) {
            const auto x = static_cast<double>(i % static_cast<std::size_t>(camera.width));
            const auto y = static_cast<double>(i / static_cast<std::size_t>(camera.width));
            per_depth[i] = static_cast<float>(glm::length(request.view.direction(x + 0.5, y + 0.5)));
        }
        clouds::MarchSettings march = subject.march;
        clouds::CloudLighting::ViewFields fields;
        if (march.fields == nullptr && slabs.size() > 1) {
            fields = subject.lighting->contract(subject.volume->transform().index_from_world(camera.position_m));
            march.fields = &fields;
        }
        std::vector<float> from(texels);
        std::vector<float> to(texels);
        for (std::size_t k = 0; k < slabs.size(); ++k) {
            if (slabs.size() > 1) { // one slab holds the whole cloud
                for (std::size_t i = 0; i < texels; ++i) {
                    from[i] = static_cast<float>(request.edges_m[k]) * per_depth[i];
                    to[i] = static_cast<float>(request.edges_m[k + 1]) * per_depth[i];
                }
                march.from_m = from;
                march.scene_depth_m = to;
            }
            const clouds::Picture picture = clouds::march(*subject.volume, *subject.lighting, camera, march);
            impostors::SlabImage& slab = slabs[k];
            const auto scale = static_cast<float>(1.0 / request.depth_scale_m);
            for (std::size_t i = 0; i < texels; ++i) {
                const float alpha = 1.0F - picture.transmittance[i];
                const float depth = picture.depth_m[i] / per_depth[i];
                const float s = static_cast<float>((static_cast<double>(depth) - request.depth_origin_m)) * scale;
                const float spread = picture.spread_m[i] / per_depth[i] * scale;
                slab.colour[i] = glm::vec4(subject.scale * picture.radiance[i], alpha);
                slab.depth[i] = alpha * glm::vec2(s, s * s + spread * spread);
            }
        }
        return Ok{};
    };
}

// A sphere about the matter of a cloud: around the middle of its box, as far as its bricks reach.
[[nodiscard]] inline impostors::Sphere cloud_bounds(const clouds::BrickVolume& volume,
                                                    const glm::dvec3& offset_m = {}) {
    if (volume.empty()) {
        return {offset_m, 0.0};
    }
    const glm::dvec3 low(volume.active_low() - 1);
    const glm::dvec3 high(volume.active_high() + 1);
    const glm::dvec3 centre = volume.transform().world_from_index(0.5 * (low + high));
    double radius_m = 0.0;
    for (const glm::ivec3& brick : volume.table().coordinates()) {
        const glm::dvec3 from = glm::max(glm::dvec3(volume.min() + 8 * brick - 1), low);
        const glm::dvec3 to = glm::min(glm::dvec3(volume.min() + 8 * brick + 8), high);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 index((corner & 1) != 0 ? to.x : from.x, (corner & 2) != 0 ? to.y : from.y,
                                   (corner & 4) != 0 ? to.z : from.z);
            radius_m = std::max(radius_m, glm::length(volume.transform().world_from_index(index) - centre));
        }
    }
    return {centre + offset_m, radius_m};
}

} // namespace alpenglow
