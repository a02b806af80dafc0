// The low-precision series of the night-sky course, to the letter: Jensen, Durand, Stark, Premoze, Dorsey and Shirley,
// A Physically-Based Night Sky Model (SIGGRAPH 2001), appendix. Kept as the readable reference beside series.hpp.
//
// T is (JD - 2451545) / 36525: in TT, except for the sidereal time, which takes UT. Angles in radians. Longitude and
// latitude are ecliptic, of the mean equinox of date. Worst errors against ERFA over 1900 to 2100 stand in
// docs/ephemeris.md.
//
// Departures, each found by checking against ERFA and pinned by a test:
// - the moon's argument m: 6.2300 is printed, the sun's mean anomaly at J2000 is 6.2401 (and 6.24 in the
//   course's own sun);
// - the moon's orientation: the printed product R_z(f + pi) R_x(I) R_z(l' - f) is in the order of application, and R_x
//   must turn by -I: R_z(l' - f) R_x(-I) R_z(f + pi) on column vectors;
// - distances: "multiply d_Moon by 23455" belongs to the sun's r, which is in astronomical units.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::ephemeris::course {

inline constexpr double earth_radius_m = 6378137.0;
inline constexpr double earth_radii_per_au = 23455.0;

// Eq. (9), for year > 1582.
[[nodiscard]] double julian_date(int year, int month, int day, int hour, int minute, double second);

[[nodiscard]] double centuries(double jd);

// LMST; t_ut without delta T. Not reduced to one turn.
[[nodiscard]] double local_mean_sidereal_time(double t_ut, double longitude_rad);

[[nodiscard]] double obliquity(double t);

// P, precession from J2000 to date.
[[nodiscard]] glm::dmat3 precession(double t);

// R_y(lat - pi/2) R_z(-LMST): x south, y east, z zenith.
[[nodiscard]] glm::dmat3 horizon_from_equatorial(double latitude_rad, double lmst_rad);

// From the course's horizon axes (south, east, zenith) to ours (east, north, zenith).
[[nodiscard]] glm::dmat3 local_from_horizon();

struct Ecliptic {
    double longitude_rad = 0.0;
    double latitude_rad = 0.0;
    double distance = 0.0; // sun: astronomical units; moon: Earth radii
};
[[nodiscard]] Ecliptic sun(double t);
[[nodiscard]] Ecliptic moon(double t);

// Rectangular position (eq. 10) in the units of `distance`.
[[nodiscard]] glm::dvec3 rectangular(const Ecliptic& position);

// The moon's body axes (x towards the mean Earth, z its north pole) -> ecliptic of date.
[[nodiscard]] glm::dmat3 ecliptic_from_moon(double t);

// Both bodies in the course's horizon axes, in Earth radii: the moon topocentric by subtracting (0, 0, 1), the sun
// geocentric.
struct HorizonPositions {
    glm::dvec3 sun;
    glm::dvec3 moon;
};
[[nodiscard]] HorizonPositions horizon_positions(double t_tt, double t_ut, double latitude_rad, double longitude_rad);

// Direction from the moon's centre to the leading (light to dark) terminator, not normalised: (s - m) x (s x m).
[[nodiscard]] glm::dvec3 leading_terminator(const glm::dvec3& sun, const glm::dvec3& moon);

} // namespace alpenglow::ephemeris::course
