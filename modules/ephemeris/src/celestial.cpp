#include <alpenglow/ephemeris/celestial.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include <alpenglow/core/quiet.hpp>

#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>

#include <glm/geometric.hpp>

namespace alpenglow::ephemeris {
namespace {

constexpr double sun_radius_m = 6.957e8;
constexpr double moon_radius_m = 1.7374e6;
constexpr double max_delta_t_s = 1e6;

} // namespace

double delta_t_of(const WorldClock& clock) noexcept {
    return std::isnan(clock.delta_t_s) ? delta_t_s(clock.utc_j2000_s) : clock.delta_t_s;
}

bool inputs_valid(const Observer& o, const WorldClock& clock) noexcept {
    return within(o.latitude_rad, -0.5 * pi, 0.5 * pi) && within(o.longitude_rad, -two_pi, two_pi) &&
           within(o.height_m, min_height_m, max_height_m) && in_range(clock.utc_j2000_s) &&
           within(delta_t_of(clock), -max_delta_t_s, max_delta_t_s);
}

Status check_inputs(const Observer& o, const WorldClock& clock) {
    const auto error = [](const char* field, double value, const char* expected) {
        std::array<char, 40> text{};
        std::snprintf(text.data(), text.size(), "is %.10g", value);
        return Error{text.data(), field, expected};
    };
    // Of a huge number as of infinity: the conversion must not overflow.
    const auto degrees = [](double x) { return std::isgreater(std::abs(x), 1e300) ? x : x / degree_rad; };
    if (!within(o.latitude_rad, -0.5 * pi, 0.5 * pi)) {
        return error("observer.latitude (degrees)", degrees(o.latitude_rad), "-90 to 90");
    }
    if (!within(o.longitude_rad, -two_pi, two_pi)) {
        return error("observer.longitude (degrees)", degrees(o.longitude_rad), "-360 to 360, east positive");
    }
    if (!within(o.height_m, min_height_m, max_height_m)) {
        return error("observer.height (metres)", o.height_m, "-12000 to 100000");
    }
    if (!in_range(clock.utc_j2000_s)) {
        return error("clock.utc (seconds since J2000)", clock.utc_j2000_s, "a date in the years -1999 to 3000");
    }
    if (!within(delta_t_of(clock), -max_delta_t_s, max_delta_t_s)) {
        return error("clock.delta_t (seconds)", clock.delta_t_s, "-1e6 to 1e6, or NaN for the built-in model");
    }
    return Ok{};
}

Topocentric topocentric(const Observer& observer, double utc_j2000_s, double delta_t_s, const Geocentric& g) {
    assert(in_range(utc_j2000_s) && within(observer.latitude_rad, -0.5 * pi, 0.5 * pi));
    const double tt_j2000_s = utc_j2000_s + delta_t_s;
    const double sidereal = greenwich_mean_sidereal_time_rad(utc_j2000_s, tt_j2000_s) + g.equation_of_equinoxes_rad +
                            observer.longitude_rad;
    const glm::dmat3 local_from_true = local_from_equatorial_of_date(observer.latitude_rad, sidereal);
    const glm::dvec3 here = observer_in_local_m(observer.latitude_rad, observer.height_m);
    Topocentric result;
    result.sun_m = local_from_true * g.sun_m - here;
    result.moon_m = local_from_true * g.moon_m - here;
    result.local_from_equatorial = local_from_true * g.true_from_j2000;
    result.local_from_moon = local_from_true * g.equatorial_from_moon;
    return result;
}

Topocentric topocentric(const Observer& observer, double utc_j2000_s, double delta_t_s) {
    return topocentric(observer, utc_j2000_s, delta_t_s, geocentric(julian_centuries(utc_j2000_s + delta_t_s)));
}

CelestialState evaluate(const Observer& observer, double utc_j2000_s, double delta_t_s) {
    return evaluate(observer, utc_j2000_s, delta_t_s, geocentric(julian_centuries(utc_j2000_s + delta_t_s)));
}

CelestialState evaluate(const Observer& observer, double utc_j2000_s, double delta_t_s, const Geocentric& g) {
    const Topocentric now = topocentric(observer, utc_j2000_s, delta_t_s, g);
    CelestialState state;
    state.sun_distance_m = glm::length(now.sun_m);
    state.moon_distance_m = glm::length(now.moon_m);
    state.to_sun = glm::vec3(now.sun_m / state.sun_distance_m);
    state.to_moon = glm::vec3(now.moon_m / state.moon_distance_m);
    state.sun_angular_radius_rad = static_cast<float>(std::asin(sun_radius_m / state.sun_distance_m));
    state.moon_angular_radius_rad = static_cast<float>(std::asin(moon_radius_m / state.moon_distance_m));
    const double phase_angle = angle_between(now.sun_m - now.moon_m, -now.moon_m);
    state.moon_phase_angle_rad = static_cast<float>(phase_angle);
    state.moon_illuminated_fraction = static_cast<float>(0.5 * (1.0 + std::cos(phase_angle)));
    state.local_from_equatorial = now.local_from_equatorial;
    state.local_from_moon = now.local_from_moon;
    state.made_from_utc_j2000_s = utc_j2000_s;
    state.made_from_latitude_rad = observer.latitude_rad;
    state.made_from_longitude_rad = observer.longitude_rad;
    state.made_from_height_m = observer.height_m;
    state.made_from_delta_t_s = delta_t_s;
    return state;
}

double direction_drift_bound_rad(const CelestialState& state, const Observer& observer, double utc_j2000_s,
                                 double delta_t_s) noexcept {
    if (std::isnan(state.made_from_utc_j2000_s)) {
        return std::numeric_limits<double>::infinity();
    }
    const double turn = std::abs(std::remainder(observer.longitude_rad - state.made_from_longitude_rad, two_pi));
    return max_direction_rate_rad_s * std::abs(utc_j2000_s - state.made_from_utc_j2000_s) +
           max_direction_rate_tt_rad_s * std::abs(delta_t_s - state.made_from_delta_t_s) +
           max_direction_per_arc * (std::abs(observer.latitude_rad - state.made_from_latitude_rad) + turn) +
           max_direction_per_m * std::abs(observer.height_m - state.made_from_height_m);
}

} // namespace alpenglow::ephemeris
