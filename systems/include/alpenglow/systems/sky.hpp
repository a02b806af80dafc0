// update_sky: where sun and moon stand, and the air -> the sky and the light of sun and moon.
#pragma once

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/observer.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>

namespace alpenglow {

// Writes SkyState to every entity with CelestialState and Atmosphere, for the model that the Atmosphere names, at the
// height of the entity's Observer (0 without one). A state is kept while its drift bound (see sky::drift_bound) is
// within Atmosphere::max_error. An atmosphere out of range (sky::check names the field) is rejected: the previous sky
// stands. For SkyModel::scattering also writes SkyTables: those that a visible SkyTableReader asks for or that the SH
// of the sky need, each rebuilt only when it could be off by more than max_error; the report counts them.
template <Registry R>
SystemReport update_sky(R& registry, const Frame& /*frame*/) {
    SystemReport report{.system = "sky"};
    const double start = thread_cpu_seconds();
    sky::SkyTableNeeds needs;
    registry.template view<const SkyTableReader>().each([&](auto /*entity*/, const SkyTableReader& reader) {
        needs.sky_view = needs.sky_view || (reader.visible && reader.sky_view);
        needs.aerial_perspective = needs.aerial_perspective || (reader.visible && reader.aerial_perspective);
        needs.transmittance = needs.transmittance || (reader.visible && reader.transmittance);
    });
    bool lit = false;
    registry.template view<const SkyLightReceiver>().each(
        [&](auto /*entity*/, const SkyLightReceiver& receiver) { lit = lit || receiver.visible; });

    registry.template view<const CelestialState, const Atmosphere>().each(
        [&](auto entity, const CelestialState& celestial, const Atmosphere& atmosphere) {
            ++report.considered;
            const Observer* observer = registry.template try_get<Observer>(entity);
            const double height_m = observer != nullptr ? observer->height_m : 0.0;
            if (!sky::check(atmosphere, height_m)) {
                ++report.rejected;
                return;
            }
            const SkyState* previous = registry.template try_get<SkyState>(entity);
            const double bound =
                previous != nullptr ? sky::drift_bound(*previous, celestial, atmosphere, height_m) : 0.0;
            if (previous != nullptr && bound <= static_cast<double>(atmosphere.max_error)) {
                ++report.skipped;
                report.error_bound = std::max(report.error_bound, bound);
            } else {
                SkyState state = sky::make_sky_state(celestial, atmosphere, height_m);
                state.celestial_revision = celestial.revision;
                state.revision = previous != nullptr ? previous->revision + 1 : 1;
                registry.template emplace_or_replace<SkyState>(entity, state);
                ++report.updated;
            }
            const SkyState& state = registry.template get<SkyState>(entity);
            sky::SkyTableNeeds here = needs;
            here.sky_view = needs.sky_view || (lit && sky::sh_needs_sky_view(state));
            if (atmosphere.model == SkyModel::scattering || registry.template all_of<SkyTables>(entity)) {
                if (!registry.template all_of<SkyTables>(entity)) {
                    registry.template emplace<SkyTables>(entity);
                }
                const sky::SkyTableWork work =
                    sky::update_sky_tables(state, celestial, here, registry.template get<SkyTables>(entity));
                report.tables_rebuilt += work.rebuilt;
                report.tables_kept += work.kept;
                report.error_bound = std::max(report.error_bound, work.error_bound);
            }
        });
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
