// update_sky: where sun and moon stand, and the air -> the sky and the light of sun and moon.
#pragma once

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>

namespace alpenglow {

// Writes SkyState to every entity with CelestialState and Atmosphere. A state is kept while its drift bound (see
// sky::drift_bound) is within Atmosphere::max_error. An atmosphere out of range (sky::check names the field) is
// rejected: the previous sky stands.
template <Registry R>
SystemReport update_sky(R& registry, const Frame& /*frame*/) {
    SystemReport report{.system = "sky"};
    const double start = thread_cpu_seconds();
    registry.template view<const CelestialState, const Atmosphere>().each(
        [&](auto entity, const CelestialState& celestial, const Atmosphere& atmosphere) {
            ++report.considered;
            if (!sky::check(atmosphere)) {
                ++report.rejected;
                return;
            }
            const SkyState* previous = registry.template try_get<SkyState>(entity);
            if (previous != nullptr) {
                const double bound = sky::drift_bound(*previous, celestial, atmosphere);
                if (bound <= static_cast<double>(atmosphere.max_error)) {
                    ++report.skipped;
                    report.error_bound = std::max(report.error_bound, bound);
                    return;
                }
            }
            SkyState state = sky::make_sky_state(celestial, atmosphere);
            state.celestial_revision = celestial.revision;
            state.revision = previous != nullptr ? previous->revision + 1 : 1;
            registry.template emplace_or_replace<SkyState>(entity, state);
            ++report.updated;
        });
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
