#include "sandbox/app/cloud_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "sandbox/app/cloud_depth.hpp"
#include "sandbox/app/cloud_reproject.hpp"

namespace alpenglow::sandbox {
namespace {

bool same_view(const Camera& a, const Camera& b) {
    return a.position_m == b.position_m && a.yaw_rad == b.yaw_rad && a.pitch_rad == b.pitch_rad &&
           a.fov_y_rad == b.fov_y_rad;
}

bool same(const clouds::Camera& a, const clouds::Camera& b) {
    return a.position_m == b.position_m && a.forward == b.forward && a.up == b.up &&
           a.tan_half_height == b.tan_half_height && a.width == b.width && a.height == b.height;
}

// Of pictures of one view in different resolutions.
bool same_place(const clouds::Camera& a, const clouds::Camera& b) {
    return a.position_m == b.position_m && a.forward == b.forward && a.up == b.up &&
           std::abs(a.tan_half_height - b.tan_half_height) < 0.1F * a.tan_half_height;
}

// The largest way that a cloud has moved between two states; infinite where they are not the same clouds.
double moved_m(std::span<const clouds::LitCloud> a, std::span<const clouds::LitCloud> b) {
    if (a.size() != b.size()) {
        return 1e30;
    }
    double most = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i].volume != b[i].volume || a[i].lighting != b[i].lighting) {
            return 1e30;
        }
        most = std::max(most, glm::length(a[i].offset_m - b[i].offset_m));
    }
    return most;
}

// From the camera to the nearest box of matter; a hundred metres at least.
float nearest_box_m(std::span<const clouds::LitCloud> clouds, const clouds::Camera& camera) {
    double nearest = 1e30;
    for (const clouds::LitCloud& cloud : clouds) {
        const clouds::GridTransform& transform = cloud.volume->transform();
        const glm::dvec3 index = transform.index_from_world(camera.position_m - cloud.offset_m);
        const glm::dvec3 outside = glm::max(
            glm::max(glm::dvec3(cloud.volume->active_low()) - index, index - glm::dvec3(cloud.volume->active_high())),
            glm::dvec3(0.0));
        nearest = std::min(nearest, glm::length(outside * transform.voxel_m));
    }
    return static_cast<float>(std::max(nearest, 100.0));
}

} // namespace

clouds::Camera cloud_camera(const Camera& camera, int width, int height, int divisor) {
    clouds::Camera out;
    out.position_m = glm::dvec3(camera.position_m);
    out.forward = camera.forward();
    out.right = camera.right();
    out.up = camera.up();
    out.width = (width + divisor - 1) / divisor;
    out.height = (height + divisor - 1) / divisor;
    out.tan_half_height =
        std::tan(0.5F * camera.fov_y_rad) * static_cast<float>(out.height * divisor) / static_cast<float>(height);
    return out;
}

// The fields are those of an eye that saw the nearest cell of the cloud within eye_turn_rad of the same direction, a
// voxel at least.
const CloudView::Eye& CloudView::eye_for(const clouds::LitCloud& cloud, std::uint32_t light_revision) {
    const glm::dvec3 eye = camera_.position_m - cloud.offset_m;
    const clouds::GridTransform& transform = cloud.volume->transform();
    const glm::dvec3 index = transform.index_from_world(eye);
    const glm::dvec3 outside = glm::max(
        glm::max(glm::dvec3(cloud.volume->active_low()) - index, index - glm::dvec3(cloud.volume->active_high())),
        glm::dvec3(0.0));
    const double distance = glm::length(outside * transform.voxel_m);
    const double allowed = std::max(transform.voxel_m.x, static_cast<double>(settings.eye_turn_rad) * distance);
    // One a frame, each takes milliseconds; those of a light that was good enough until now can wait.
    constexpr double while_waiting = 2.0;
    Eye* waiting = nullptr;
    for (Eye& known : eyes_) {
        const double off = glm::length(known.at_m - eye);
        if (known.lighting != cloud.lighting || off > while_waiting * allowed) {
            continue;
        }
        if (known.light_revision == light_revision && off <= allowed) {
            known.used = true;
            return known;
        }
        if (waiting == nullptr || off < glm::length(waiting->at_m - eye)) {
            waiting = &known;
        }
    }
    if (contracted_ && waiting != nullptr) {
        waiting->used = true;
        return *waiting;
    }
    contracted_ = true;
    eyes_.push_back({cloud.lighting, light_revision, eye,
                     std::make_unique<const clouds::CloudLighting::ViewFields>(cloud.lighting->contract(index)),
                     next_revision(), true});
    return eyes_.back();
}

bool CloudView::look(const CloudsInView& view) {
    contracted_ = false;
    for (Eye& eye : eyes_) {
        eye.used = false;
    }
    job_.fields.clear();
    job_.fields_revisions.clear();
    bool newest = true;
    for (const clouds::LitCloud& cloud : view.clouds) {
        const Eye& eye = eye_for(cloud, view.light_revision);
        job_.fields.push_back(eye.fields.get());
        job_.fields_revisions.push_back(eye.revision);
        newest = newest && eye.light_revision == view.light_revision;
    }
    std::erase_if(eyes_, [&](const Eye& eye) {
        return !eye.used &&
               std::find(shown_fields_.begin(), shown_fields_.end(), eye.fields.get()) == shown_fields_.end();
    });
    return newest;
}

void CloudView::start(const CloudsInView& view) {
    job_.clouds = view.clouds;
    job_.time_s = view.time_s;
    job_.light_revision = view.light_revision;
    job_.picture = settings.on_device ? clouds::Picture() : clouds::Picture(camera_.width, camera_.height);
    job_.rows_done = 0;
    job_.running = true;
}

clouds::MarchSettings CloudView::march_settings() const {
    clouds::MarchSettings march;
    march.step_voxels = settings.step_voxels;
    march.optical_step = settings.optical_step;
    march.stop_transmittance = 4e-3F; // an 8-bit step
    march.scene_depth_m = landscape_m_;
    if (settings.detail_strength > 0.0F) {
        static const clouds::DetailTexture texture;
        march.detail = &texture;
        march.detail_strength = settings.detail_strength;
        march.detail_cells = settings.detail_cells;
        if (settings.reshape_s > 0.0F) {
            march.detail_offsets = clouds::detail_drift(job_.time_s, static_cast<double>(settings.reshape_s));
        }
    }
    return march;
}

std::size_t CloudView::march_rows(int until) {
    clouds::MarchSettings march = march_settings();
    march.rect = {0, job_.rows_done, camera_.width, std::min(until, camera_.height)};
    if (!march.rect.empty()) {
        const clouds::Picture rows = clouds::march(job_.clouds, camera_, march, job_.fields);
        const auto width = static_cast<std::size_t>(camera_.width);
        const std::size_t from = static_cast<std::size_t>(march.rect.y0) * width;
        const std::size_t count = static_cast<std::size_t>(march.rect.y1 - march.rect.y0) * width;
        const auto copy = [&](const auto& source, auto& target) {
            std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(from), count,
                        target.begin() + static_cast<std::ptrdiff_t>(from));
        };
        copy(rows.radiance, job_.picture.radiance);
        copy(rows.transmittance, job_.picture.transmittance);
        copy(rows.depth_m, job_.picture.depth_m);
        copy(rows.spread_m, job_.picture.spread_m);
    }
    const int done = march.rect.y1 - march.rect.y0;
    job_.rows_done = march.rect.y1;
    return static_cast<std::size_t>(done) * static_cast<std::size_t>(camera_.width);
}

// A lattice of the rays; the rest from the last picture. All of them where too little of it is still in view.
std::size_t CloudView::march_some() {
    const PixelLattice lattice = lattice_of(settings.moving_lattice, turn_++ % 36);
    const clouds::Camera some = lattice_camera(camera_, lattice);
    some_landscape_m_.resize(static_cast<std::size_t>(some.width) * static_cast<std::size_t>(some.height));
    for (int j = 0; j < some.height; ++j) {
        const int y = std::min(lattice.n * j + lattice.first.y, camera_.height - 1);
        for (int i = 0; i < some.width; ++i) {
            const int x = std::min(lattice.n * i + lattice.first.x, camera_.width - 1);
            some_landscape_m_[static_cast<std::size_t>(j * some.width + i)] =
                landscape_m_[static_cast<std::size_t>(y * camera_.width + x)];
        }
    }
    clouds::MarchSettings march = march_settings();
    march.scene_depth_m = some_landscape_m_;
    const clouds::Picture fresh = clouds::march(job_.clouds, some, march, job_.fields);
    const std::size_t without = complete_picture(fresh, lattice, {picture_, shown_camera_, shown_landscape_m_}, camera_,
                                                 landscape_m_, job_.picture);
    const std::size_t all = job_.picture.transmittance.size();
    if (without > all / 5) {
        return fresh.transmittance.size() + march_rows(camera_.height);
    }
    job_.rows_done = camera_.height;
    job_.reprojected = true;
    return fresh.transmittance.size();
}

clouds::Picture CloudView::full_picture() const {
    clouds::MarchSettings march = march_settings();
    return clouds::march(shown_, camera_, march, shown_fields_);
}

void CloudView::hand_over() {
    std::vector<MarchedCloud> marched;
    for (std::size_t i = 0; i < job_.clouds.size(); ++i) {
        marched.push_back({job_.clouds[i], job_.fields[i], job_.light_revision, job_.fields_revisions[i]});
    }
    tables_.update(marched, camera_, march_settings());
}

void CloudView::finish() {
    std::swap(picture_, job_.picture);
    shown_time_s_ = job_.time_s;
    light_revision_ = job_.newest ? job_.light_revision : 0;
    shown_on_device_ = settings.on_device;
    shown_ = std::move(job_.clouds);
    shown_fields_ = std::move(job_.fields);
    reprojected_ = job_.reprojected;
    shown_camera_ = camera_;
    shown_divisor_ = divisor_;
    shown_landscape_m_ = landscape_m_;
    job_ = {};
    job_.time_s = shown_time_s_;
    revision_ = next_revision();
    nearest_m_ = shown_on_device_ ? nearest_box_m(shown_, camera_) : 1e30F; // nobody reads the device's picture back
    for (std::size_t i = 0; i < picture_.depth_m.size(); ++i) {
        if (picture_.transmittance[i] < 0.95F) {
            nearest_m_ = std::min(nearest_m_, picture_.depth_m[i]);
        }
    }
}

// Of the clouds by the wind and of their detail, as far as a voxel's part of the texture goes.
double CloudView::drift_m(const CloudsInView& view) const {
    double most = moved_m(shown_, view.clouds);
    if (settings.reshape_s > 0.0F && settings.detail_strength > 0.0F) {
        constexpr double billow = clouds::DetailTexture::size / 8.0; // cells that it drifts in that time
        double voxel = 0.0;
        for (const clouds::LitCloud& cloud : view.clouds) {
            voxel = std::max(voxel, cloud.volume->transform().voxel_m.x);
        }
        most += std::abs(view.time_s - shown_time_s_) / static_cast<double>(settings.reshape_s) * billow * voxel /
                static_cast<double>(settings.detail_cells);
    }
    return most;
}

std::size_t CloudView::update(const CloudsInView& view, const Camera& camera, int width, int height) {
    const bool moving = has_last_camera_ && !same_view(camera, last_camera_);
    last_camera_ = camera;
    has_last_camera_ = true;
    const int divisor = moving && !settings.on_device ? settings.moving_divisor : settings.still_divisor;
    const clouds::Camera wanted = cloud_camera(camera, width, height, divisor);
    const bool anew = divisor != divisor_ || !same(wanted, camera_) || revision_ == 0 ||
                      moved_m(shown_, view.clouds) > 1e20 || settings.on_device != shown_on_device_;
    // A camera that has come to rest looks at the moving one's last picture until its own is made.
    const bool at_once = anew && (moving || settings.on_device || shown_on_device_ || picture_.width == 0 ||
                                  !same_place(wanted, shown_camera_));
    if (anew) {
        divisor_ = divisor;
        camera_ = wanted;
        landscape_distance(camera_, view.terrain_vertices, view.terrain_indices, landscape_m_);
    } else if (!job_.running && view.light_revision == light_revision_) {
        const float pixel_m = 2.0F * camera_.tan_half_height / static_cast<float>(camera_.height) * nearest_m_;
        if (drift_m(view) <= static_cast<double>(settings.drift_pixels * pixel_m)) {
            return 0;
        }
    }
    if (anew || !job_.running) {
        job_.newest = look(view);
        if (!anew && !job_.newest) {
            return 1; // the new light's fields are being made: what is shown was good enough until now
        }
        start(view);
    }
    std::size_t rays = 0;
    const bool from_last = anew && moving && settings.moving_lattice > 1 && picture_.width > 0 && !shown_on_device_;
    if (settings.on_device) {
        hand_over();
        rays = static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
    } else if (from_last) {
        rays = march_some();
    } else {
        const int rows = (camera_.height + settings.spread_frames - 1) / std::max(1, settings.spread_frames);
        rays = march_rows(at_once ? camera_.height : job_.rows_done + rows);
    }
    if (settings.on_device || job_.rows_done >= camera_.height) {
        finish();
    }
    return rays;
}

} // namespace alpenglow::sandbox
