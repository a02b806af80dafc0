// Sun and moon by truncated analytic theories: what update_ephemeris uses.
//
// Sun: the largest terms of the Earth's VSOP87D (Bretagnon & Francou 1988; Meeus, Astronomical Algorithms, appendix
// III) with annual aberration. Moon: the terms of ELP 2000-82 in Meeus's chapter 47 (Chapront-Touze & Chapront 1983),
// light-time included. Errors over 1900 to 2100 stand in docs/ephemeris.md.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::ephemeris {

// Apparent ecliptic coordinates but for nutation: mean ecliptic and equinox of date. T in Julian centuries TT.
struct EclipticPosition {
    double longitude_rad = 0.0; // any number of turns
    double latitude_rad = 0.0;
    double distance_m = 0.0;
};
[[nodiscard]] EclipticPosition sun_series(double t);
[[nodiscard]] EclipticPosition moon_series(double t);

// Sun and moon from the Earth's centre in the true equator and equinox of date, metres; and the moon's body axes
// (x to the mean Earth, z its north pole; mean rotation by Cassini's laws, physical libration of up to 0.04 degrees
// left out).
struct Geocentric {
    glm::dvec3 sun_m{0.0};
    glm::dvec3 moon_m{0.0};
    glm::dmat3 equatorial_from_moon{1.0};
    glm::dmat3 true_from_j2000{1.0};        // precession and nutation: mean equator of J2000 -> true equator of date
    double equation_of_equinoxes_rad = 0.0; // apparent minus mean sidereal time
};
[[nodiscard]] Geocentric geocentric(double t);

} // namespace alpenglow::ephemeris
