// update_probes: the light of sky, sun, moon and ground -> light probes. update_probe_receivers: probes -> what they
// light.
#pragma once

#include <alpenglow/components/cloud_cover.hpp>
#include <alpenglow/components/environment_map.hpp>
#include <alpenglow/components/light_probe.hpp>
#include <alpenglow/components/probe_grid.hpp>
#include <alpenglow/components/probe_receiver.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/probes/assemble.hpp>
#include <alpenglow/probes/capture.hpp>
#include <alpenglow/probes/environment.hpp>
#include <alpenglow/probes/light_probe.hpp>
#include <alpenglow/probes/receive.hpp>
#include <alpenglow/probes/update.hpp>
#include <alpenglow/systems/frame.hpp>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace alpenglow {

// Writes ProbeGridSh to every ProbeGrid, LightProbeSh to every LightProbe and EnvironmentMapSh to every EnvironmentMap,
// from the first SkyState and its SkyLightSh, or the first EnvironmentMap in place of that SkyLightSh. Only what lights
// a visible ProbeReceiver is updated, only past its max_error, and of a grid at most its budget a frame (see
// probes::update_grid). Grids and probes ask for the sky by a SkyLightReceiver of their own. `capture` renders for
// those whose source is ProbeSource::captured; without it they are assembled. What probes::check refuses is rejected:
// its previous light stands. A grid or probe with a CloudCoverLight gets the light that clouds leave of that
// SkyLightSh, of sun and of moon. Items of the report are probes and maps.
template <Registry R>
SystemReport update_probes(R& registry, const Frame& /*frame*/, const probes::Capture& capture = {}) {
    SystemReport report{.system = "probes"};
    const double start = thread_cpu_seconds();
    const auto finish = [&] {
        report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
        return report;
    };
    const auto add = [&report](const probes::UpdateCounts& counts) {
        report.considered += counts.considered;
        report.updated += counts.updated;
        report.skipped += counts.skipped;
        report.error_bound = std::max(report.error_bound, counts.error_bound);
    };

    std::vector<glm::vec3> wanted;
    registry.template view<const ProbeReceiver>().each([&](auto /*entity*/, const ProbeReceiver& receiver) {
        if (receiver.visible) {
            wanted.push_back(receiver.position_m);
        }
    });

    ProbeSources sources;
    registry.template view<const SkyState>().each([&, first = true](auto entity, const SkyState& state) mutable {
        if (std::exchange(first, false)) {
            probes::take_sky(state, registry.template try_get<SkyLightSh>(entity), sources);
        }
    });
    registry.template view<const EnvironmentMap>().each(
        [&, first = true](auto entity, const EnvironmentMap& map) mutable {
            if (!registry.template all_of<EnvironmentMapSh>(entity)) {
                registry.template emplace<EnvironmentMapSh>(entity);
            }
            auto& light = registry.template get<EnvironmentMapSh>(entity);
            const bool used = std::exchange(first, false) && !wanted.empty();
            report.rejected += used && !probes::usable(map, light) ? 1U : 0U;
            add(probes::update_environment(map, light, used));
            if (used && light.order > 0) {
                probes::take_environment(light, sources);
            }
        });
    if (!probes::usable(sources)) {
        ++report.rejected;
        return finish();
    }

    // The sources as an entity sees them below clouds.
    const auto seen_from = [&](auto entity) {
        ProbeSources seen = sources;
        const CloudCoverLight* cover = registry.template try_get<CloudCoverLight>(entity);
        if (cover != nullptr && cover->revision > 0 && !seen.whole_sphere) {
            put_below_clouds(*cover, std::span(seen.sky).first(static_cast<std::size_t>(seen.order * seen.order)));
            seen.sun_lux *= cover->sun;
            seen.moon_lux *= cover->moon;
        }
        return seen;
    };

    std::vector<std::pair<typename R::entity_type, int>> asking;
    registry.template view<const ProbeGrid>().each([&](auto entity, const ProbeGrid& grid) {
        if (!registry.template all_of<ProbeGridSh>(entity)) {
            registry.template emplace<ProbeGridSh>(entity);
        }
        auto& light = registry.template get<ProbeGridSh>(entity);
        if (!probes::begin_frame(grid, light)) {
            ++report.rejected;
            return;
        }
        const bool lights = probes::mark_needed(grid, light, wanted);
        asking.emplace_back(entity, lights ? grid.order : 0);
        add(probes::update_grid(grid, light, seen_from(entity), capture));
    });
    registry.template view<const LightProbe>().each([&](auto entity, const LightProbe& probe) {
        if (!registry.template all_of<LightProbeSh>(entity)) {
            registry.template emplace<LightProbeSh>(entity);
        }
        if (!probes::check(probe)) {
            ++report.rejected;
            return;
        }
        const bool lights = probes::reaches_any(probe, wanted);
        asking.emplace_back(entity, lights ? probe.order : 0);
        add(probes::update_light_probe(probe, registry.template get<LightProbeSh>(entity), seen_from(entity), lights,
                                       capture));
    });
    for (const auto& [entity, bands] : asking) {
        registry.template emplace_or_replace<SkyLightReceiver>(entity, SkyLightReceiver{std::max(bands, 1), bands > 0});
    }
    return finish();
}

// Writes ReceiverSh to every visible ProbeReceiver: the light of the grid of finest spacing that contains it, else of
// the nearest LightProbe that reaches it, else of the environment, else none. Receivers that stand where they stood
// under probes that did not change are skipped.
template <Registry R>
SystemReport update_probe_receivers(R& registry, const Frame& /*frame*/) {
    SystemReport report{.system = "probe_receivers"};
    const double start = thread_cpu_seconds();
    probes::LightSources lights;
    registry.template view<const ProbeGrid, const ProbeGridSh>().each(
        [&](auto /*entity*/, const ProbeGrid& grid, const ProbeGridSh& light) { lights.add(grid, light); });
    registry.template view<const LightProbe, const LightProbeSh>().each(
        [&](auto /*entity*/, const LightProbe& probe, const LightProbeSh& light) { lights.add(probe, light); });
    registry.template view<const EnvironmentMapSh>().each(
        [&](auto /*entity*/, const EnvironmentMapSh& light) { lights.add(light); });
    probes::Receiving receiving(lights);
    std::vector<std::pair<typename R::entity_type, const ProbeReceiver*>> newcomers;
    registry.template view<const ProbeReceiver>().each([&](auto entity, const ProbeReceiver& receiver) {
        if (receiver.visible && !registry.template all_of<ReceiverSh>(entity)) {
            newcomers.emplace_back(entity, &receiver);
        }
    });
    for (const auto& [entity, receiver] : newcomers) {
        registry.template emplace<ReceiverSh>(entity);
    }
    registry.template view<const ProbeReceiver, ReceiverSh>().each(
        [&](auto /*entity*/, const ProbeReceiver& receiver, ReceiverSh& light) {
            ++report.considered;
            if (receiver.visible && receiving.add(receiver, light)) {
                ++report.updated;
            } else {
                ++report.skipped;
            }
        });
    receiving.finish();
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
