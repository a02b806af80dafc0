#include <alpenglow/ephemeris/course.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/frames.hpp>

#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::ephemeris::course {
namespace {

// The moon's mean arguments.
struct Arguments {
    double l; // mean longitude
    double m_moon;
    double m_sun;
    double d;
    double f;
};

Arguments arguments(double t) {
    return {3.8104 + 8399.7091 * t, 2.3554 + 8328.6911 * t, 6.2400 + 628.3019 * t, 5.1985 + 7771.3772 * t,
            1.6280 + 8433.4663 * t};
}

} // namespace

double julian_date(int year, int month, int day, int hour, int minute, double second) {
    const double y = month <= 2 ? year - 1 : year;
    const double m = month <= 2 ? month + 12 : month;
    return 1720996.5 - std::floor(y / 100.0) + std::floor(y / 400.0) + std::floor(365.25 * y) +
           std::floor(30.6001 * (m + 1.0)) + day + (hour + (minute + second / 60.0) / 60.0) / 24.0;
}

double centuries(double jd) {
    return (jd - 2451545.0) / 36525.0;
}

double local_mean_sidereal_time(double t_ut, double longitude_rad) {
    return 4.894961 + 230121.675315 * t_ut + longitude_rad;
}

double obliquity(double t) {
    return 0.409093 - 0.000227 * t;
}

glm::dmat3 precession(double t) {
    return rotation_z(0.01118 * t) * rotation_y(-0.00972 * t) * rotation_z(0.01118 * t);
}

glm::dmat3 horizon_from_equatorial(double latitude_rad, double lmst_rad) {
    return rotation_y(latitude_rad - 0.5 * pi) * rotation_z(-lmst_rad);
}

glm::dmat3 local_from_horizon() {
    return {0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
}

Ecliptic sun(double t) {
    const double m = 6.24 + 628.302 * t;
    return {4.895048 + 628.331951 * t + (0.033417 - 0.000084 * t) * std::sin(m) + 0.000351 * std::sin(2.0 * m), 0.0,
            1.000140 - (0.016708 - 0.000042 * t) * std::cos(m) - 0.000141 * std::cos(2.0 * m)};
}

Ecliptic moon(double t) {
    const auto [l, m_moon, m_sun, d, f] = arguments(t);
    const double longitude = l + 0.1098 * std::sin(m_moon) + 0.0222 * std::sin(2.0 * d - m_moon) +
                             0.0115 * std::sin(2.0 * d) + 0.0037 * std::sin(2.0 * m_moon) - 0.0032 * std::sin(m_sun) -
                             0.0020 * std::sin(2.0 * f) + 0.0010 * std::sin(2.0 * d - 2.0 * m_moon) +
                             0.0010 * std::sin(2.0 * d - m_sun - m_moon) + 0.0009 * std::sin(2.0 * d + m_moon) +
                             0.0008 * std::sin(2.0 * d - m_sun) + 0.0007 * std::sin(m_moon - m_sun) -
                             0.0006 * std::sin(d) - 0.0005 * std::sin(m_sun + m_moon);
    const double latitude = 0.0895 * std::sin(f) + 0.0049 * std::sin(m_moon + f) + 0.0048 * std::sin(m_moon - f) +
                            0.0030 * std::sin(2.0 * d - f) + 0.0010 * std::sin(2.0 * d + f - m_moon) +
                            0.0008 * std::sin(2.0 * d - f - m_moon) + 0.0006 * std::sin(2.0 * d + f);
    const double parallax = 0.016593 + 0.000904 * std::cos(m_moon) + 0.000166 * std::cos(2.0 * d - m_moon) +
                            0.000137 * std::cos(2.0 * d) + 0.000049 * std::cos(2.0 * m_moon) +
                            0.000015 * std::cos(2.0 * d + m_moon) + 0.000009 * std::cos(2.0 * d - m_sun);
    return {longitude, latitude, 1.0 / parallax};
}

glm::dvec3 rectangular(const Ecliptic& p) {
    return p.distance * from_spherical(p.longitude_rad, p.latitude_rad);
}

glm::dmat3 ecliptic_from_moon(double t) {
    const Arguments a = arguments(t);
    return rotation_z(a.l - a.f) * rotation_x(-0.026920) * rotation_z(a.f + pi);
}

HorizonPositions horizon_positions(double t_tt, double t_ut, double latitude_rad, double longitude_rad) {
    const glm::dmat3 horizon_from_ecliptic =
        horizon_from_equatorial(latitude_rad, local_mean_sidereal_time(t_ut, longitude_rad)) *
        rotation_x(obliquity(t_tt));
    return {earth_radii_per_au * (horizon_from_ecliptic * rectangular(sun(t_tt))),
            horizon_from_ecliptic * rectangular(moon(t_tt)) - glm::dvec3(0.0, 0.0, 1.0)};
}

glm::dvec3 leading_terminator(const glm::dvec3& s, const glm::dvec3& m) {
    return glm::cross(s - m, glm::cross(s, m));
}

} // namespace alpenglow::ephemeris::course
