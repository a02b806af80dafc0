#include <alpenglow/impostors/store.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include <alpenglow/core/timing.hpp>

namespace alpenglow::impostors {

Status CaptureStore::carry_out(const Plan& plan, std::span<const SceneObject> objects, std::span<const SceneView> views,
                               const Lights& lights, Scheduler& scheduler,
                               const std::function<const Drawable*(std::uint64_t)>& drawable) {
    Status status = Ok{};
    for (const SlotId slot : plan.released) {
        captures_.erase(slot);
    }
    const double start = wall_seconds();
    double texels = 0.0;
    for (const CaptureJob& job : plan.captures) {
        const SceneObject& object = objects[job.object];
        const Drawable* draw = drawable(object.id);
        Result<Capture> made =
            draw == nullptr || !*draw
                ? Result<Capture>(Error{"no Drawable for object " + std::to_string(object.id),
                                        "impostors::CaptureStore", "one for every object in the scene"})
                : capture(object.bounds, job.frustum, job.settings, *draw);
        if (!made) {
            status = made.error();
            scheduler.failed(job.slot);
            continue;
        }
        scheduler.measured(job.slot, made->sensitivity, made->mean);
        texels += static_cast<double>(job.texels);
        captures_.insert_or_assign(job.slot, std::move(made.value()));
    }
    for (const InsideJob& job : plan.inside) {
        const SceneObject& object = objects[job.object];
        const Drawable* draw = drawable(object.id);
        if (draw == nullptr || !*draw) {
            continue;
        }
        const CaptureSettings settings{Representation::layers, std::clamp(object.layers, 1, 16), lights, object.content,
                                       true};
        Result<Capture> made = capture(object.bounds, job.frustum, settings, *draw);
        if (!made) {
            status = made.error();
            continue;
        }
        scheduler.measured_inside(object.id, views[job.view].id, made->sensitivity, job.downscale);
        texels += static_cast<double>(job.texels);
        inside_[object.id].insert_or_assign(views[job.view].id, std::move(made.value()));
    }
    scheduler.captured_in(texels, (wall_seconds() - start) * 1e3);
    // Screen-aligned pictures of those who left.
    std::erase_if(inside_, [&](const auto& entry) {
        return std::none_of(plan.draws.begin(), plan.draws.end(), [&](const DrawItem& item) {
            return objects[item.object].id == entry.first && item.impostor_weight < 1.0F;
        });
    });
    return status;
}

const Capture* CaptureStore::find(SlotId slot) const {
    const auto found = captures_.find(slot);
    return found == captures_.end() ? nullptr : &found->second;
}

const Capture* CaptureStore::find_inside(std::uint64_t object, std::uint32_t view) const {
    const auto of = inside_.find(object);
    if (of == inside_.end()) {
        return nullptr;
    }
    const auto picture = of->second.find(view);
    return picture == of->second.end() ? nullptr : &picture->second;
}

void CaptureStore::draw_item(const DrawItem& item, std::span<const SceneObject> objects,
                             std::span<const SceneView> views, const Lights& lights, const DrawSettings& settings,
                             std::span<glm::vec4> image) const {
    const SceneObject& object = objects[item.object];
    const SceneView& view = views[item.view];
    const auto add = [&](const Capture& picture, float weight) {
        DrawSettings s = settings;
        s.gain = light_gain(picture.lights, lights);
        s.weight = weight;
        draw(picture, view.frustum, s, image);
    };
    if (item.impostor_weight < 1.0F) {
        if (const Capture* picture = find_inside(object.id, view.id)) {
            add(*picture, 1.0F - item.impostor_weight);
        }
    }
    const Capture* now = find(item.slot);
    const Capture* before = find(item.before);
    if (now != nullptr && before != nullptr) {
        add(*now, item.impostor_weight * item.weight);
        add(*before, item.impostor_weight * (1.0F - item.weight));
    } else if (now != nullptr || before != nullptr) {
        add(now != nullptr ? *now : *before, item.impostor_weight);
    } else if (item.impostor_weight > 0.0F && item.stand_in.w > 0.0F) {
        // The last picture's mean colour over the bounds: better than a hole for the frames until there is a picture.
        const PixelRect rect = visible_rect(object.bounds, view.frustum);
        for (int y = rect.y0; y < rect.y1; ++y) {
            for (int x = rect.x0; x < rect.x1; ++x) {
                image[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.frustum.width) +
                      static_cast<std::size_t>(x)] += item.impostor_weight * item.stand_in;
            }
        }
    }
}

void CaptureStore::draw_view(const Plan& plan, std::size_t view_index, std::span<const SceneObject> objects,
                             std::span<const SceneView> views, const Lights& lights, const DrawSettings& settings,
                             std::span<glm::vec4> image) const {
    std::vector<glm::vec4> one(image.size());
    std::fill(image.begin(), image.end(), glm::vec4(0.0F));
    for (const DrawItem& item : plan.draws) {
        if (item.view != view_index) {
            continue;
        }
        std::fill(one.begin(), one.end(), glm::vec4(0.0F));
        draw_item(item, objects, views, lights, settings, one);
        over(one, image);
    }
}

} // namespace alpenglow::impostors
