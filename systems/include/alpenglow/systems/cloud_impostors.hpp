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

// A capture of a cloud that is marched a few rows at a time, slab by slab, and asked for when it is complete.
class CloudCapture {
public:
    // hidden: what lies behind opaque slabs is marched too, as another eye may see it.
    CloudCapture(CloudSubject subject, const impostors::Frustum& view, std::span<const double> edges_m,
                 bool hidden = true)
        : subject_(std::move(subject)), view_(view), edges_m_(edges_m.begin(), edges_m.end()),
          eye_m_(view.eye_m - subject_.offset_m) {
        const auto width = static_cast<std::size_t>(view.width);
        per_depth_.resize(width * static_cast<std::size_t>(view.height));
        for (std::size_t i = 0; i < per_depth_.size(); ++i) {
            per_depth_[i] = static_cast<float>(glm::length(
                view.direction(static_cast<double>(i % width) + 0.5, static_cast<double>(i / width) + 0.5)));
        }
        slabs_.resize(edges_m_.size() - 1);
        if (!hidden && slabs_.size() > 1) {
            through_.assign(per_depth_.size(), 1.0F);
        }
        for (clouds::Picture& slab : slabs_) {
            slab = clouds::Picture(view.width, view.height);
        }
        if (subject_.march.fields == nullptr) {
            fields_ = subject_.lighting->contract(subject_.volume->transform().index_from_world(eye_m_));
        }
    }

    [[nodiscard]] bool done() const { return slab_ >= slabs_.size(); }
    [[nodiscard]] std::size_t texels_left() const {
        return done() ? 0 : (slabs_.size() - slab_) * per_depth_.size() - static_cast<std::size_t>(row_ * view_.width);
    }

    // Marches the next rows of the slab that is in progress; returns how many of their texels show anything.
    std::size_t march(int rows) {
        if (done()) {
            return 0;
        }
        const int end = std::min(view_.height, row_ + std::max(rows, 1));
        clouds::MarchSettings march = subject_.march;
        if (march.fields == nullptr) {
            march.fields = &fields_;
        }
        const auto first = static_cast<std::size_t>(row_ * view_.width);
        const auto count = static_cast<std::size_t>((end - row_) * view_.width);
        impostors::Frustum band = view_;
        band.height = end - row_;
        band.tan_top = view_.tan_top - row_ / view_.pixels_per_tan_y();
        band.tan_bottom = view_.tan_top - end / view_.pixels_per_tan_y();
        if (slabs_.size() > 1) { // one slab holds the whole cloud
            from_.resize(count);
            to_.resize(count);
            for (std::size_t i = 0; i < count; ++i) {
                from_[i] = static_cast<float>(edges_m_[slab_]) * per_depth_[first + i];
                const bool opaque = !through_.empty() && through_[first + i] < 2e-3F;
                to_[i] = opaque ? from_[i] : static_cast<float>(edges_m_[slab_ + 1]) * per_depth_[first + i];
            }
            march.from_m = from_;
            march.scene_depth_m = to_;
        }
        const clouds::Picture rows_now =
            clouds::march(*subject_.volume, *subject_.lighting, cloud_camera(band, subject_.offset_m), march);
        clouds::Picture& slab = slabs_[slab_];
        std::size_t seen = 0;
        for (std::size_t i = 0; i < count; ++i) {
            slab.radiance[first + i] = rows_now.radiance[i];
            slab.transmittance[first + i] = rows_now.transmittance[i];
            slab.depth_m[first + i] = rows_now.depth_m[i];
            slab.spread_m[first + i] = rows_now.spread_m[i];
            seen += rows_now.transmittance[i] < 1.0F ? 1 : 0;
            if (!through_.empty()) {
                through_[first + i] *= rows_now.transmittance[i];
            }
        }
        row_ = end;
        if (row_ == view_.height) {
            row_ = 0;
            ++slab_;
        }
        return seen;
    }

    [[nodiscard]] const clouds::Picture& slab(std::size_t k) const { return slabs_[k]; }

    // What has been marched, as a Drawable's slabs.
    void fill(const impostors::CaptureRequest& request, std::span<impostors::SlabImage> slabs) const {
        const auto scale = static_cast<float>(1.0 / request.depth_scale_m);
        for (std::size_t k = 0; k < slabs.size(); ++k) {
            const clouds::Picture& picture = slabs_[k];
            for (std::size_t i = 0; i < per_depth_.size(); ++i) {
                const float alpha = 1.0F - picture.transmittance[i];
                const float depth = picture.depth_m[i] / per_depth_[i];
                const float s = static_cast<float>((static_cast<double>(depth) - request.depth_origin_m)) * scale;
                const float spread = picture.spread_m[i] / per_depth_[i] * scale;
                slabs[k].colour[i] = glm::vec4(subject_.scale * picture.radiance[i], alpha);
                slabs[k].depth[i] = alpha * glm::vec2(s, s * s + spread * spread);
            }
        }
    }

private:
    CloudSubject subject_;
    impostors::Frustum view_;
    std::vector<double> edges_m_;
    glm::dvec3 eye_m_;
    clouds::CloudLighting::ViewFields fields_;
    std::vector<float> per_depth_; // distance over axis depth
    std::vector<float> from_, to_;
    std::vector<float> through_; // transmittance of the slabs in front
    std::vector<clouds::Picture> slabs_;
    std::size_t slab_ = 0;
    int row_ = 0;
};

// Marches each slab by itself. All light follows the key light (SlabImage::fill stays empty).
[[nodiscard]] inline impostors::Drawable cloud_drawable(const CloudSubject& subject) {
    return [subject](const impostors::CaptureRequest& request, std::span<impostors::SlabImage> slabs) -> Status {
        CloudCapture capture(subject, request.view, request.edges_m);
        while (!capture.done()) {
            capture.march(request.view.height);
        }
        capture.fill(request, slabs);
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
