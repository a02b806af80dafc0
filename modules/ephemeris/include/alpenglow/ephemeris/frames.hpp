// Reference frames: ecliptic, equatorial, local east-north-up, and the rotation of the Earth.
//
// All matrices are rotations that act on column vectors and are named TO_from_FROM. Equatorial frames have x towards
// the vernal equinox and z towards the celestial north pole. T is in Julian centuries since J2000, TT.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::ephemeris {

inline constexpr double arcsecond_rad = 4.848136811095359935899141e-6;
inline constexpr double astronomical_unit_m = 149597870700.0;
inline constexpr double light_m_s = 299792458.0;

// Counter-clockwise rotations about the principal axes.
[[nodiscard]] glm::dmat3 rotation_x(double angle_rad);
[[nodiscard]] glm::dmat3 rotation_y(double angle_rad);
[[nodiscard]] glm::dmat3 rotation_z(double angle_rad);

// Unit vector of a longitude and a latitude (course, eq. 10).
[[nodiscard]] glm::dvec3 from_spherical(double longitude_rad, double latitude_rad);

// Angle between two vectors of any length, 0 .. pi; accurate near 0 and near pi.
[[nodiscard]] double angle_between(const glm::dvec3& a, const glm::dvec3& b);

// Mean obliquity of the ecliptic (IAU 2006; Capitaine et al. 2003, eq. 37).
[[nodiscard]] double mean_obliquity_rad(double t);

// Nutation in longitude and obliquity, the ten largest terms of IAU 2000B: within 0.15 arcseconds over 1900 to 2100.
struct Nutation {
    double longitude_rad = 0.0;
    double obliquity_rad = 0.0;
};
[[nodiscard]] Nutation nutation(double t);

// Mean equator and equinox of J2000 -> those of date (IAU 2006 equatorial angles; Capitaine et al. 2003, eq. 40).
[[nodiscard]] glm::dmat3 date_from_j2000(double t);

// Greenwich mean sidereal time in radians, 0 .. 2 pi (IAU 2006; Capitaine et al. 2003, eq. 42). UT1 and TT in seconds
// since J2000 of their own scale.
[[nodiscard]] double greenwich_mean_sidereal_time_rad(double ut1_j2000_s, double tt_j2000_s);

// Local east-north-up from equatorial coordinates of date, for the geodetic latitude and the local sidereal time.
// With apparent sidereal time the equatorial frame is the true one, with mean time the mean one.
[[nodiscard]] glm::dmat3 local_from_equatorial_of_date(double latitude_rad, double local_sidereal_time_rad);

// The observer's position from the Earth's centre in the observer's own east-north-up axes, metres (WGS84).
// Subtracted from a geocentric position in those axes it makes that topocentric; its east component is 0.
[[nodiscard]] glm::dvec3 observer_in_local_m(double latitude_rad, double height_m);

// Azimuth from north through east (0 .. 2 pi; 0 exactly at the zenith and the nadir) and altitude over the horizon.
struct Horizontal {
    double azimuth_rad = 0.0;
    double altitude_rad = 0.0;
};
[[nodiscard]] Horizontal horizontal_from_local(const glm::dvec3& direction);
[[nodiscard]] glm::dvec3 local_from_horizontal(const Horizontal& horizontal);

} // namespace alpenglow::ephemeris
