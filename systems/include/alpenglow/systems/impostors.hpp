// update_impostors: cameras, objects and lights -> which pictures hold, and which are drawn again this frame.
#pragma once

#include <alpenglow/components/impostor.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/impostors/scheduler.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace alpenglow {

// In the registry's context: this frame's plan, and what its indices mean. Whoever draws carries the plan out
// (impostors::CaptureStore on the CPU) and tells `scheduler` what the captures measured. Emplace one with a scheduler
// of your own settings before the first update, or get the defaults.
struct ImpostorFrame {
    impostors::Scheduler scheduler = impostors::Scheduler::create().value();
    std::vector<impostors::SceneObject> objects; // in the order of their ids
    std::vector<impostors::SceneView> views;
    impostors::Lights lights;
    impostors::Plan plan;
    double now_s = 0.0;
    std::uint64_t ids = 0; // given out
};

// Writes ImpostorState to every entity with Impostor, and ImpostorFrame in the context. No camera (ImpostorView), no
// work. considered: objects x views; updated: pictures to take; error_bound: the worst error shown, over its tolerance.
template <Registry R>
SystemReport update_impostors(R& registry, const Frame& frame) {
    SystemReport report{.system = "impostors"};
    const double start = thread_cpu_seconds();
    ImpostorFrame& f = registry.ctx().template emplace<ImpostorFrame>();
    f.now_s += std::max(0.0, frame.dt_s);
    f.views.clear();
    registry.template view<const ImpostorView>().each([&](auto, const ImpostorView& v) {
        const auto id = static_cast<std::uint32_t>(f.views.size()) + 1;
        f.views.push_back({id,
                           {v.eye_m, v.right, v.up, v.forward, v.tan_left, v.tan_right, v.tan_bottom, v.tan_top,
                            v.width_px, v.height_px}});
    });
    registry.template view<const ImpostorLight>().each([&](auto, const ImpostorLight& light) {
        f.lights = {light.to_key, light.key_lux, light.fill_lux};
    });
    f.objects.clear();
    registry.template view<const Impostor>().each([&](auto entity, const Impostor& i) {
        ImpostorState* state = registry.template try_get<ImpostorState>(entity);
        if (state == nullptr) {
            state = &registry.template emplace<ImpostorState>(entity, ImpostorState{.id = ++f.ids});
        }
        state->error = 0.0;
        state->inside = false;
        f.objects.push_back({state->id,
                             {i.centre_m, i.radius_m},
                             {i.max_angle_rad, i.max_shift_px, i.max_error, i.max_light_error, i.max_content_error},
                             static_cast<impostors::Representation>(i.kind),
                             i.layers,
                             i.content,
                             i.phase_g,
                             i.visible});
    });
    std::sort(f.objects.begin(), f.objects.end(),
              [](const impostors::SceneObject& a, const impostors::SceneObject& b) { return a.id < b.id; });
    f.scheduler.plan(f.objects, f.views, f.lights, f.now_s, f.plan);

    std::vector<ImpostorState> states(f.objects.size());
    for (const impostors::DrawItem& item : f.plan.draws) {
        ImpostorState& s = states[item.object];
        const bool nothing = item.impostor_weight > 0.0F && item.slot == impostors::no_slot;
        s.error = std::max(s.error, nothing ? std::numeric_limits<double>::infinity() : item.urgency);
        s.inside = s.inside || item.impostor_weight < 1.0F;
    }
    for (const impostors::CaptureJob& job : f.plan.captures) {
        ++states[job.object].captures;
    }
    registry.template view<ImpostorState, const Impostor>().each([&](auto, ImpostorState& state, const Impostor&) {
        const auto at = std::partition_point(f.objects.begin(), f.objects.end(),
                                             [&](const impostors::SceneObject& o) { return o.id < state.id; });
        const ImpostorState& s = states[static_cast<std::size_t>(at - f.objects.begin())];
        state.error = s.error;
        state.inside = s.inside;
        state.captures += s.captures;
    });
    report.considered = f.plan.report.considered;
    report.updated = f.plan.report.captured + f.plan.report.inside;
    report.rejected = f.plan.report.rejected;
    report.skipped = report.considered - std::min(report.considered, report.updated + report.rejected);
    report.error_bound = f.plan.report.worst_urgency;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

static_assert(static_cast<int>(ImpostorKind::plane) == static_cast<int>(impostors::Representation::plane) &&
              static_cast<int>(ImpostorKind::layers) == static_cast<int>(impostors::Representation::layers) &&
              static_cast<int>(ImpostorKind::depth_warp) == static_cast<int>(impostors::Representation::depth_warp) &&
              static_cast<int>(ImpostorKind::warped_layers) ==
                  static_cast<int>(impostors::Representation::warped_layers));

} // namespace alpenglow
