// Clock and observer -> where sun, moon and stars stand.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/observer.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/ephemeris/celestial.hpp>
#include <alpenglow/ephemeris/geocentric_cache.hpp>
#include <alpenglow/systems/frame.hpp>

namespace alpenglow {

// For every entity with WorldClock, Observer and CelestialState: recomputes the state when a direction in it could be
// off by more than Observer::max_error_rad (a negative or NaN limit means 0: whenever an input changed). Inputs that
// ephemeris::check_inputs refuses leave the last valid state as it is. error_bound: radians, over the states left alone
// whose inputs are valid. Recomputing raises the state's revision by one. Sun and
// moon come from a GeocentricCache in the registry's context (1.5e-8 rad from ephemeris::evaluate).
template <Registry R>
SystemReport update_ephemeris(R& registry, const Frame&) {
    SystemReport report{.system = "ephemeris"};
    const double start = thread_cpu_seconds();
    auto& cache = registry.ctx().template emplace<ephemeris::GeocentricCache>();
    registry.template view<const WorldClock, const Observer, CelestialState>().each(
        [&report, &cache](auto, const WorldClock& clock, const Observer& observer, CelestialState& state) {
            ++report.considered;
            if (!ephemeris::inputs_valid(observer, clock)) {
                ++report.skipped;
                return;
            }
            const double delta_t_s = ephemeris::delta_t_of(clock);
            const double bound = ephemeris::direction_drift_bound_rad(state, observer, clock.utc_j2000_s, delta_t_s);
            const double limit = std::isgreater(observer.max_error_rad, 0.0) ? observer.max_error_rad : 0.0; // NaN: 0
            if (bound <= limit) {
                ++report.skipped;
                report.error_bound = std::max(report.error_bound, bound);
                return;
            }
            const std::uint32_t revision = state.revision;
            state =
                ephemeris::evaluate(observer, clock.utc_j2000_s, delta_t_s, cache.at(clock.utc_j2000_s + delta_t_s));
            state.revision = revision + 1;
            ++report.updated;
        });
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow
