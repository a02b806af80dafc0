#include <alpenglow/ephemeris/frames.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::ephemeris {

glm::dmat3 rotation_x(double a) {
    const double c = std::cos(a);
    const double s = std::sin(a);
    return {1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c};
}

glm::dmat3 rotation_y(double a) {
    const double c = std::cos(a);
    const double s = std::sin(a);
    return {c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c};
}

glm::dmat3 rotation_z(double a) {
    const double c = std::cos(a);
    const double s = std::sin(a);
    return {c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0};
}

glm::dvec3 from_spherical(double longitude_rad, double latitude_rad) {
    const double c = std::cos(latitude_rad);
    return {c * std::cos(longitude_rad), c * std::sin(longitude_rad), std::sin(latitude_rad)};
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

double mean_obliquity_rad(double t) {
    return arcsecond_rad *
           (84381.406 +
            t * (-46.836769 + t * (-0.0001831 + t * (0.00200340 + t * (-0.000000576 + t * -0.0000000434)))));
}

Nutation nutation(double t) {
    // Delaunay arguments (Simon et al. 1994), linear parts.
    const double m_moon = degree_rad * (134.96340251 + 477198.8675605 * t);
    const double m_sun = degree_rad * (357.52910918 + 35999.0502911 * t);
    const double f = degree_rad * (93.27209062 + 483202.0174577 * t);
    const double d = degree_rad * (297.85019547 + 445267.1114469 * t);
    const double node = degree_rad * (125.04455501 - 1934.1362619 * t);
    struct Term {
        double argument;
        double sine;   // arcseconds of longitude
        double cosine; // arcseconds of obliquity
    };
    const std::array<Term, 10> terms{{{node, -17.2064 - 0.01747 * t, 9.2052},
                                      {2.0 * (f - d + node), -1.3171, 0.5730},
                                      {2.0 * (f + node), -0.2276, 0.0978},
                                      {2.0 * node, 0.2075, -0.0897},
                                      {m_sun, 0.1476, 0.0074},
                                      {m_sun + 2.0 * (f - d + node), -0.0517, 0.0224},
                                      {m_moon, 0.0711, -0.0007},
                                      {2.0 * f + node, -0.0387, 0.0201},
                                      {m_moon + 2.0 * (f + node), -0.0301, 0.0129},
                                      {2.0 * (f - d + node) - m_sun, 0.0216, -0.0096}}};
    Nutation sum;
    for (const Term& term : terms) {
        sum.longitude_rad += arcsecond_rad * term.sine * std::sin(term.argument);
        sum.obliquity_rad += arcsecond_rad * term.cosine * std::cos(term.argument);
    }
    return sum;
}

glm::dmat3 date_from_j2000(double t) {
    const double zeta =
        2.650545 + t * (2306.083227 + t * (0.2988499 + t * (0.01801828 + t * (-0.000005971 + t * -0.0000003173))));
    const double z =
        -2.650545 + t * (2306.077181 + t * (1.0927348 + t * (0.01826837 + t * (-0.000028596 + t * -0.0000002904))));
    const double theta =
        t * (2004.191903 + t * (-0.4294934 + t * (-0.04182264 + t * (-0.000007089 + t * -0.0000001274))));
    return rotation_z(arcsecond_rad * z) * rotation_y(-arcsecond_rad * theta) * rotation_z(arcsecond_rad * zeta);
}

double greenwich_mean_sidereal_time_rad(double ut1_j2000_s, double tt_j2000_s) {
    // The Earth rotation angle with its whole turns taken out first: 1e6 days times a turn would cost six digits.
    const double days = ut1_j2000_s / day_s;
    const double turns = 0.7790572732640 + (days - std::floor(days)) + 0.00273781191135448 * days;
    const double t = julian_centuries(tt_j2000_s);
    const double precession =
        0.014506 + t * (4612.156534 + t * (1.3915817 + t * (-0.00000044 + t * (-0.000029956 + t * -0.0000000368))));
    const double angle = std::fmod(two_pi * (turns - std::floor(turns)) + arcsecond_rad * precession, two_pi);
    return angle < 0.0 ? angle + two_pi : angle;
}

glm::dmat3 local_from_equatorial_of_date(double latitude_rad, double local_sidereal_time_rad) {
    const double sp = std::sin(latitude_rad);
    const double cp = std::cos(latitude_rad);
    const double st = std::sin(local_sidereal_time_rad);
    const double ct = std::cos(local_sidereal_time_rad);
    // Columns: the images of x, y and z.
    return {-st, -sp * ct, cp * ct, ct, -sp * st, cp * st, 0.0, cp, sp};
}

glm::dvec3 observer_in_local_m(double latitude_rad, double height_m) {
    constexpr double a = 6378137.0;
    constexpr double f = 1.0 / 298.257223563;
    constexpr double e2 = f * (2.0 - f);
    const double s = std::sin(latitude_rad);
    const double c = std::cos(latitude_rad);
    const double n = a / std::sqrt(1.0 - e2 * s * s);
    return {0.0, -n * e2 * s * c, n * (1.0 - e2 * s * s) + height_m};
}

Horizontal horizontal_from_local(const glm::dvec3& d) {
    const double across = std::hypot(d.x, d.y);
    double azimuth = across > 0.0 ? std::atan2(d.x, d.y) : 0.0;
    if (azimuth < 0.0) {
        azimuth += two_pi;
    }
    return {azimuth, std::atan2(d.z, across)};
}

glm::dvec3 local_from_horizontal(const Horizontal& h) {
    return from_spherical(0.5 * pi - h.azimuth_rad, h.altitude_rad);
}

} // namespace alpenglow::ephemeris
