// From clock and observer to the CelestialState component, and how long such a state holds.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/observer.hpp>
#include <alpenglow/core/result.hpp>
#include <alpenglow/ephemeris/series.hpp>

namespace alpenglow::ephemeris {

// Heights that the error bounds hold for.
inline constexpr double min_height_m = -12000.0;
inline constexpr double max_height_m = 100000.0;

// The clock's own delta T, or the built-in model's where that is NaN.
[[nodiscard]] double delta_t_of(const WorldClock& clock) noexcept;

// What evaluate demands: finite inputs, latitude within -90 .. 90 degrees, longitude within -360 .. 360 degrees, height
// within the range above, a date within time.hpp's range, |delta T| <= 1e6 s.
[[nodiscard]] Status check_inputs(const Observer& observer, const WorldClock& clock);
[[nodiscard]] bool inputs_valid(const Observer& observer, const WorldClock& clock) noexcept;

// Where things stand for an observer, in double and in metres: local east-north-up axes, topocentric on WGS84, without
// refraction, diurnal aberration (0.3 arcseconds) and polar motion (0.3 arcseconds).
struct Topocentric {
    glm::dvec3 sun_m{0.0};
    glm::dvec3 moon_m{0.0};
    glm::dmat3 local_from_equatorial{1.0}; // mean equator of J2000 -> local
    glm::dmat3 local_from_moon{1.0};       // the moon's body axes -> local
};
// Precondition: inputs_valid for these values.
[[nodiscard]] Topocentric topocentric(const Observer& observer, double utc_j2000_s, double delta_t_s);
// The same from positions that the caller has, of the instant utc_j2000_s + delta_t_s (GeocentricCache, another
// theory).
[[nodiscard]] Topocentric topocentric(const Observer& observer, double utc_j2000_s, double delta_t_s,
                                      const Geocentric& positions);

// The component: directions rounded to float (6e-8 rad), made_from_* filled in, revision 0. Same precondition.
[[nodiscard]] CelestialState evaluate(const Observer& observer, double utc_j2000_s, double delta_t_s);
[[nodiscard]] CelestialState evaluate(const Observer& observer, double utc_j2000_s, double delta_t_s,
                                      const Geocentric& positions);

// An upper bound in radians on how far any direction of `state` (sun, moon, star, lunar axis) is from what evaluate
// would give now, from the inputs alone and without evaluating: rates of the Earth's rotation and the moon's motion,
// and the observer's displacement with the moon's parallax. Float rounding excluded. Infinite for a state that was
// never made.
[[nodiscard]] double direction_drift_bound_rad(const CelestialState& state, const Observer& observer,
                                               double utc_j2000_s, double delta_t_s) noexcept;

// Bounds that direction_drift_bound_rad uses. The local frame turns at 7.2921e-5 rad/s; seen from the surface the moon
// at its nearest (356 350 km from the centre, 349 870 km from a surface point 100 km up) adds its parallax, a factor
// of 1.0186, and its own motion of at most 3.1e-6 rad/s from the centre.
inline constexpr double max_direction_rate_rad_s = 7.2922e-5 * 1.0186 + 3.1e-6 * 1.0186;
inline constexpr double max_direction_rate_tt_rad_s = 3.2e-6; // by delta T alone
inline constexpr double max_direction_per_arc = 1.0188;       // by the observer's latitude or longitude, rad per rad
inline constexpr double max_direction_per_m = 1.0 / 3.498e8;  // by the observer's height

} // namespace alpenglow::ephemeris
