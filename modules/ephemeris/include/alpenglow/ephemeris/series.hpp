// Sun and moon by truncated analytic theories.
//
// Errors over 1900 to 2100 stand in docs/ephemeris.md. T is in Julian centuries since J2000, TT.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::ephemeris {

// Apparent ecliptic coordinates but for nutation: mean ecliptic and equinox of date.
struct EclipticPosition {
    double longitude_rad = 0.0; // any number of turns
    double latitude_rad = 0.0;
    double distance_m = 0.0;
};
// The largest terms of the Earth's VSOP87D (Bretagnon & Francou 1988; Meeus, Astronomical Algorithms, appendix III),
// with annual aberration.
[[nodiscard]] EclipticPosition sun_series(double t);
// Meeus, chapter 47: ELP 2000-82 (Chapront-Touze & Chapront 1983) with light-time. The theory of eraMoon98; 12
// arcseconds from ELP/MPP02.
[[nodiscard]] EclipticPosition moon_series(double t);

// The moon from the Earth's centre in metres, mean equator and equinox of J2000, with light-time: ELP/MPP02 fitted to
// DE405 (Chapront & Francou, A&A 404, 735, 2003), its terms above 0.05 arcseconds and 0.2 km.
[[nodiscard]] glm::dvec3 moon_elp_m(double t);

// Sun (sun_series) and moon (moon_elp_m) from the Earth's centre in the true equator and equinox of date, metres; and
// the moon's body axes (x to the mean Earth, z its north pole; mean rotation by Cassini's laws, physical libration of
// up to 0.04 degrees left out).
struct Geocentric {
    glm::dvec3 sun_m{0.0};
    glm::dvec3 moon_m{0.0};
    glm::dmat3 equatorial_from_moon{1.0};
    glm::dmat3 true_from_j2000{1.0};        // precession and nutation: mean equator of J2000 -> true equator of date
    double equation_of_equinoxes_rad = 0.0; // apparent minus mean sidereal time
};
[[nodiscard]] Geocentric geocentric(double t);

} // namespace alpenglow::ephemeris
