#include "sandbox/app/day_chart.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/celestial.hpp>
#include <alpenglow/ephemeris/geocentric_cache.hpp>
#include <alpenglow/sky/sky_state.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr double day_s = 86400.0;

float luminance(const glm::vec3& rgb) {
    return glm::dot(rgb, glm::vec3(0.2126F, 0.7152F, 0.0722F));
}

} // namespace

std::vector<DaySample> day_light(const Observer& observer, const Atmosphere& atmosphere, double utc_j2000_s,
                                 int count) {
    // Seconds since local mean midnight; J2000 is a noon.
    const double local = utc_j2000_s + 0.5 * day_s + observer.longitude_rad / (2.0 * pi) * day_s;
    const double start = utc_j2000_s - (local - std::floor(local / day_s) * day_s);
    Atmosphere level = atmosphere;
    if (level.model == SkyModel::scattering) {
        level.ozone_atm_cm = 0.35F;
        level.turbidity = std::clamp(level.turbidity, 2.0F, 8.0F);
        level.ground_albedo = glm::min(level.ground_albedo, glm::vec3(0.8F));
    }
    ephemeris::GeocentricCache cache;
    std::vector<DaySample> day;
    for (int i = 0; i < count; ++i) {
        WorldClock clock;
        clock.utc_j2000_s = start + day_s * i / (count - 1);
        if (!ephemeris::inputs_valid(observer, clock)) {
            return {};
        }
        const double delta_t_s = ephemeris::delta_t_of(clock);
        const CelestialState bodies =
            ephemeris::evaluate(observer, clock.utc_j2000_s, delta_t_s, cache.at(clock.utc_j2000_s + delta_t_s));
        const sky::DayLight here =
            sky::level_illuminance(sky::make_sky_state(bodies, atmosphere, observer.height_m), nullptr);
        const sky::DayLight below = atmosphere.model == SkyModel::scattering
                                        ? sky::level_illuminance(sky::make_sky_state(bodies, level), nullptr)
                                        : here;
        day.push_back({clock.utc_j2000_s, luminance(here.sun_lux), luminance(below.sky_lux), luminance(here.moon_lux),
                       std::atan2(bodies.to_sun.z, std::hypot(bodies.to_sun.x, bodies.to_sun.y))});
    }
    return day;
}

} // namespace alpenglow::sandbox
