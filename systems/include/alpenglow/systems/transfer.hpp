// update_transfer: light -> each object's frame -> radiance at its points.
#pragma once

#include <alpenglow/components/transfer.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/prt/update.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>
#include <vector>

namespace alpenglow {

// Writes TransferResult to entities with TransferMesh, TransferVolume or NeighbourhoodTransfer, and ObjectLight.
// Skipped: what is not visible, has no table or no light, whose light and rotation are those of its result, or whose
// result is provably within max_error (prt::relative_change). See TransferBudget for the spreading over frames.
template <Registry R>
SystemReport update_transfer(R& registry, const Frame& /*frame*/) {
    SystemReport report{.system = "transfer"};
    const double start = thread_cpu_seconds();
    struct Due {
        const TransferSource* source;
        const prt::LightSamples* samples;
        const ObjectLight* light;
        typename R::entity_type entity;
        float urgency; // error over max_error
    };
    std::vector<Due> due;
    const auto consider = [&](auto entity, const TransferSource& source, const prt::LightSamples* samples,
                              const ObjectLight& light) {
        ++report.considered;
        TransferResult* result = registry.template try_get<TransferResult>(entity);
        const float urgency = prt::urgency(source, light, result);
        if (urgency > 0.5F) {
            due.push_back({&source, samples, &light, entity, urgency});
        } else {
            ++report.skipped;
            report.error_bound = std::max(report.error_bound, static_cast<double>(urgency * source.max_error));
        }
    };
    registry.template view<const TransferMesh, const ObjectLight>().each(
        [&](auto entity, const TransferMesh& mesh, const ObjectLight& light) {
            consider(entity, mesh, mesh.samples.get(), light);
        });
    registry.template view<const TransferVolume, const ObjectLight>().each(
        [&](auto entity, const TransferVolume& volume, const ObjectLight& light) {
            consider(entity, volume, nullptr, light);
        });
    registry.template view<const NeighbourhoodTransfer, const ObjectLight>().each(
        [&](auto entity, const NeighbourhoodTransfer& around, const ObjectLight& light) {
            consider(entity, around, nullptr, light);
        });
    std::stable_sort(due.begin(), due.end(), [](const Due& a, const Due& b) { return a.urgency > b.urgency; });
    const TransferBudget* limit = registry.ctx().template find<TransferBudget>();
    std::uint64_t left = (limit != nullptr ? *limit : TransferBudget{}).points_per_frame;
    for (const Due& item : due) {
        const std::uint64_t cost = prt::cost_points(*item.source);
        if (item.urgency <= 1.0F && cost > left) {
            ++report.skipped;
            report.error_bound =
                std::max(report.error_bound, static_cast<double>(item.urgency * item.source->max_error));
            continue;
        }
        left -= std::min(left, cost);
        TransferResult* result = registry.template try_get<TransferResult>(item.entity);
        if (result == nullptr) {
            result = &registry.template emplace<TransferResult>(item.entity);
        }
        prt::recompute(*item.source, item.samples, *item.light, *result);
        ++report.updated;
    }
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
