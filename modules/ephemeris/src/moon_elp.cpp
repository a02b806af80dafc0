#include <alpenglow/ephemeris/series.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include "elp_tables.hpp"
#include "harmonics.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace alpenglow::ephemeris {
namespace {

template <std::size_t N>
double sum(const std::array<elp::PeriodicTerm, N>& terms, double t) {
    double total = 0.0;
    for (const elp::PeriodicTerm& term : terms) {
        total += term.amplitude * std::cos(term.phase + term.frequency * t);
    }
    return total;
}

} // namespace

glm::dvec3 moon_elp_m(double t_now) {
    // The moon is seen where it was: 1.28 s on average, and the 0.09 s that its distance adds or takes are 0.05".
    const double t = t_now - 385000.5e3 / light_m_s / century_s;
    const auto argument = [t](double c0, double c1, double c2, double c3, double c4) {
        return arcsecond_rad * std::fmod(c0 + t * (c1 + t * (c2 + t * (c3 + t * c4))), 1296000.0);
    };
    // Mean longitudes of moon, perigee and node, of the Earth and its perihelion (ELP/MPP02, section 4, fitted to
    // DE405).
    const double w1 = argument(-510060.11437, 1732559343.38498, -6.8458, 0.006415, -4.193e-5);
    const double w2 = argument(300071.88269, 14643420.39317, -38.2584, -0.045299, 2.1301e-4);
    const double w3 = argument(450160.32601, -6967919.58147, 6.3564, 0.007518, -3.586e-5);
    const double earth = argument(361679.13852, 129597742.30032, -0.0202, 9e-6, 1.5e-7);
    const double perihelion = argument(370574.45017, 1161.24342, 0.529265, -1.1814e-4, 1.1379e-5);
    const LunarHarmonics harmonics{Harmonics<6>(w1 - earth + pi), Harmonics<6>(earth - perihelion),
                                   Harmonics<6>(w1 - w2), Harmonics<6>(w1 - w3)};
    double longitude = sum(elp::perturbed_longitude, t) + t * sum(elp::perturbed_longitude_t, t);
    for (const elp::MainTerm& term : elp::main_longitude) {
        longitude += term.amplitude * harmonics(term).sine;
    }
    double latitude = sum(elp::perturbed_latitude, t);
    for (const elp::MainTerm& term : elp::main_latitude) {
        latitude += term.amplitude * harmonics(term).sine;
    }
    double distance_km = 385000.509715 + sum(elp::perturbed_distance, t);
    for (const elp::MainTerm& term : elp::main_distance) {
        distance_km += term.amplitude * harmonics(term).cosine;
    }
    const glm::dvec3 of_date =
        1e3 * distance_km * from_spherical(w1 + arcsecond_rad * longitude, arcsecond_rad * latitude);
    // Inertial mean ecliptic of date -> that of J2000 (Laskar's P and Q; ELP/MPP02, section 6).
    const double p =
        t * (1.0180391e-5 + t * (4.7020439e-7 + t * (-5.417367e-10 + t * (-2.507948e-12 + t * 4.63486e-15))));
    const double q =
        t * (-1.13469002e-4 + t * (1.2372674e-7 + t * (1.265417e-9 + t * (-1.371808e-12 + t * -3.20334e-15))));
    const double s = std::sqrt(1.0 - p * p - q * q);
    const glm::dmat3 j2000_from_date{1.0 - 2.0 * p * p, 2.0 * p * q,       -2.0 * p * s,
                                     2.0 * p * q,       1.0 - 2.0 * q * q, 2.0 * q * s,
                                     2.0 * p * s,       -2.0 * q * s,      1.0 - 2.0 * p * p - 2.0 * q * q};
    constexpr double obliquity = 84381.40928 * arcsecond_rad; // DE405's
    return rotation_x(obliquity) * (j2000_from_date * of_date);
}

} // namespace alpenglow::ephemeris
