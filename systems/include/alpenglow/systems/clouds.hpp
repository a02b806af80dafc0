// update_clouds: sun, moon and sky -> the light inside clouds, within a budget a frame.
#pragma once

#include <alpenglow/clouds/update.hpp>
#include <alpenglow/components/cloud.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace alpenglow {

// Writes CloudLight to every entity with CloudVolume, from the first SkyState, its SkyLightSh and, for the light that
// the ground sends up, its Atmosphere; asks for that sky by a SkyLightReceiver where a visible cloud is skylit.
// Skipped: clouds without a volume, not visible, smaller than a pixel, or whose light is within max_error of what it
// should be (clouds::staleness). Colours of sun and moon, and what other clouds leave of them, follow at once;
// directions and sky start slices of work, the stalest cloud first, at most CloudBudget a frame. What clouds::check
// refuses is rejected: its previous light stands.
template <Registry R>
SystemReport update_clouds(R& registry, const Frame& /*frame*/) {
    SystemReport report{.system = "clouds"};
    const double start = thread_cpu_seconds();
    clouds::CloudSources sources;
    registry.template view<const SkyState>().each([&, first = true](auto entity, const SkyState& state) mutable {
        if (std::exchange(first, false)) {
            const Atmosphere* air = registry.template try_get<Atmosphere>(entity);
            sources = clouds::cloud_sources(state, registry.template try_get<SkyLightSh>(entity),
                                            air != nullptr ? air->ground_albedo : glm::vec3(0.0F));
        }
    });
    struct Item {
        typename R::entity_type entity;
        bool seen;
        float urgency;
    };
    std::vector<Item> items;
    registry.template view<const CloudVolume>().each([&](auto entity, const CloudVolume& cloud) {
        items.push_back({entity, cloud.visible && cloud.size_px >= 1.0F && cloud.volume != nullptr, 0.0F});
    });
    for (Item& item : items) {
        const CloudVolume& cloud = registry.template get<CloudVolume>(item.entity);
        if (!registry.template all_of<CloudLight>(item.entity)) {
            registry.template emplace<CloudLight>(item.entity);
        }
        registry.template emplace_or_replace<SkyLightReceiver>(item.entity,
                                                               SkyLightReceiver{4, item.seen && cloud.skylit});
        if (item.seen && !clouds::check(cloud)) {
            item.seen = false;
            ++report.rejected;
        }
        if (item.seen) {
            item.urgency = clouds::staleness(cloud, registry.template get<CloudLight>(item.entity), sources).bound() /
                           std::max(cloud.max_error, 1e-6F);
        }
    }
    std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.urgency > b.urgency; });
    const CloudBudget* limit = registry.ctx().template find<CloudBudget>();
    int slices = (limit != nullptr ? *limit : CloudBudget{}).slices_per_frame;
    int depths = (limit != nullptr ? *limit : CloudBudget{}).depths_per_frame;
    for (const Item& item : items) {
        ++report.considered;
        CloudLight& light = registry.template get<CloudLight>(item.entity);
        const CloudVolume& cloud = registry.template get<CloudVolume>(item.entity);
        bool worked = false;
        if (item.seen) {
            clouds::CloudSources seen = sources;
            for (int i = 0; i < seen.count; ++i) {
                seen.lights[i].irradiance *= seen.kind[i] == 1 ? cloud.sun_share : cloud.moon_share;
            }
            worked = clouds::refresh(cloud, light, seen, clouds::staleness(cloud, light, seen), depths);
            while (slices > 0 && light.lighting != nullptr && light.lighting->advance()) {
                --slices;
                worked = true;
            }
            light.error_bound = clouds::staleness(cloud, light, sources).bound();
            report.error_bound = std::max(report.error_bound, static_cast<double>(light.error_bound));
        }
        light.revision += worked ? 1U : 0U;
        ++(worked ? report.updated : report.skipped);
    }
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
