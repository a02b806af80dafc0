// Sun, moon and the Earth's rotation by ERFA (Essential Routines for Fundamental Astronomy): the oracle of the
// ephemeris tests and benchmarks. IAU 2006 precession, IAU 2000A nutation, eraEpv00 for the Earth, eraMoon98 for the
// moon.
#pragma once

#include <cmath>

#include <erfa.h>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::test {

inline constexpr double erfa_au_m = 149597870700.0;
inline constexpr double erfa_light_m_s = 299792458.0;

inline glm::dmat3 from_rows(const double (&r)[3][3]) {
    glm::dmat3 m;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            m[j][i] = r[i][j];
        }
    }
    return m;
}

// GCRS -> true equator and equinox of date.
inline glm::dmat3 erfa_true_from_gcrs(double tt_j2000_s) {
    double r[3][3];
    eraPnm06a(2451545.0, tt_j2000_s / 86400.0, r);
    return from_rows(r);
}

// Apparent geocentric sun in GCRS, metres.
inline glm::dvec3 erfa_sun_gcrs_m(double tt_j2000_s) {
    double heliocentric[2][3];
    double barycentric[2][3];
    eraEpv00(2451545.0, tt_j2000_s / 86400.0, heliocentric, barycentric);
    const glm::dvec3 sun = -glm::dvec3(heliocentric[0][0], heliocentric[0][1], heliocentric[0][2]);
    const double distance = glm::length(sun);
    double natural[3] = {sun.x / distance, sun.y / distance, sun.z / distance};
    double velocity[3];
    double v2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        velocity[i] = barycentric[1][i] * erfa_au_m / 86400.0 / erfa_light_m_s;
        v2 += velocity[i] * velocity[i];
    }
    double proper[3];
    eraAb(natural, velocity, distance, std::sqrt(1.0 - v2), proper);
    return distance * erfa_au_m * glm::dvec3(proper[0], proper[1], proper[2]);
}

// Apparent geocentric moon in GCRS, metres.
inline glm::dvec3 erfa_moon_gcrs_m(double tt_j2000_s) {
    const auto at = [](double s) {
        double pv[2][3];
        eraMoon98(2451545.0, s / 86400.0, pv);
        return erfa_au_m * glm::dvec3(pv[0][0], pv[0][1], pv[0][2]);
    };
    const double light_time_s = glm::length(at(tt_j2000_s)) / erfa_light_m_s;
    return at(tt_j2000_s - light_time_s);
}

// True equator and equinox of date -> local east-north-up.
inline glm::dmat3 erfa_local_from_true(double ut1_j2000_s, double tt_j2000_s, double latitude_rad,
                                       double longitude_rad) {
    const double sidereal =
        eraGst06a(2451545.0, ut1_j2000_s / 86400.0, 2451545.0, tt_j2000_s / 86400.0) + longitude_rad;
    const double s = std::sin(sidereal);
    const double c = std::cos(sidereal);
    const double sp = std::sin(latitude_rad);
    const double cp = std::cos(latitude_rad);
    const double rows[3][3] = {{-s, c, 0.0}, {-sp * c, -sp * s, cp}, {cp * c, cp * s, sp}};
    return from_rows(rows);
}

// The observer from the Earth's centre, in the observer's local axes, metres (WGS84).
inline glm::dvec3 erfa_observer_local_m(double latitude_rad, double longitude_rad, double height_m) {
    double xyz[3];
    eraGd2gc(1, longitude_rad, latitude_rad, height_m, xyz);
    const double s = std::sin(longitude_rad);
    const double c = std::cos(longitude_rad);
    const double sp = std::sin(latitude_rad);
    const double cp = std::cos(latitude_rad);
    const double rows[3][3] = {{-s, c, 0.0}, {-sp * c, -sp * s, cp}, {cp * c, cp * s, sp}};
    return from_rows(rows) * glm::dvec3(xyz[0], xyz[1], xyz[2]);
}

// Topocentric sun and moon in local east-north-up, metres, without refraction and diurnal aberration.
struct ErfaTopocentric {
    glm::dvec3 sun_m;
    glm::dvec3 moon_m;
};
inline ErfaTopocentric erfa_topocentric(double utc_j2000_s, double delta_t_s, double latitude_rad, double longitude_rad,
                                        double height_m) {
    const double tt = utc_j2000_s + delta_t_s;
    const glm::dmat3 local =
        erfa_local_from_true(utc_j2000_s, tt, latitude_rad, longitude_rad) * erfa_true_from_gcrs(tt);
    const glm::dvec3 here = erfa_observer_local_m(latitude_rad, longitude_rad, height_m);
    return {local * erfa_sun_gcrs_m(tt) - here, local * erfa_moon_gcrs_m(tt) - here};
}

} // namespace alpenglow::test
