// update_sky_light: the sky -> spherical harmonics, at the bands that somebody reads.
#pragma once

#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>

namespace alpenglow {

// Writes SkyLightSh to every entity with SkyState, whatever its model, at the most bands that a visible SkyLightReceiver asks for; without
// one there is no work. Coefficients are kept while the SkyState they were made from stands and they have bands enough,
// so that their error is that of the SkyState (update_sky keeps it within Atmosphere::max_error).
template <Registry R>
SystemReport update_sky_light(R& registry, const Frame& /*frame*/) {
    SystemReport report{.system = "sky_light"};
    const double start = thread_cpu_seconds();
    int demand = 0;
    registry.template view<const SkyLightReceiver>().each([&](auto /*entity*/, const SkyLightReceiver& receiver) {
        if (receiver.visible) {
            demand = std::max(demand, std::clamp(receiver.bands, 1, SkyLightSh::max_bands));
        }
    });
    registry.template view<const SkyState>().each([&](auto entity, const SkyState& state) {
        ++report.considered;
        const SkyLightSh* previous = registry.template try_get<SkyLightSh>(entity);
        if (demand == 0 ||
            (previous != nullptr && previous->sky_revision == state.revision && previous->bands >= demand)) {
            ++report.skipped;
            return;
        }
        SkyLightSh light;
        sky::project_sky_state(state, registry.template try_get<SkyTables>(entity), demand, light.coefficients);
        light.bands = demand;
        light.made_from_to_sun = state.to_sun;
        light.sky_revision = state.revision;
        light.revision = previous != nullptr ? previous->revision + 1 : 1;
        registry.template emplace_or_replace<SkyLightSh>(entity, light);
        ++report.updated;
    });
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
