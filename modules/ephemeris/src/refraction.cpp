#include <alpenglow/ephemeris/refraction.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>

namespace alpenglow::ephemeris {
namespace {

constexpr double lowest_deg = -1.0;

double cot_deg(double x) {
    return 1.0 / std::tan(degree_rad * x);
}

double weather(double pressure_hpa, double temperature_c) {
    return pressure_hpa / 1010.0 * 283.0 / (273.0 + temperature_c);
}

// `arcminutes` above the lowest altitude, then a straight line to 0 at the nadir.
template <class Formula>
double extended_rad(double altitude_rad, Formula arcminutes) {
    const double h = std::clamp(altitude_rad / degree_rad, -90.0, 90.0);
    const double r = std::max(0.0, arcminutes(std::max(h, lowest_deg)));
    return r * degree_rad / 60.0 * (h < lowest_deg ? (h + 90.0) / (lowest_deg + 90.0) : 1.0);
}

} // namespace

double refraction_from_true_rad(double altitude_rad, double pressure_hpa, double temperature_c) {
    const auto saemundsson = [](double h) { return 1.02 * cot_deg(h + 10.3 / (h + 5.11)) + 0.0019279; };
    return weather(pressure_hpa, temperature_c) * extended_rad(altitude_rad, saemundsson);
}

double refraction_from_apparent_rad(double altitude_rad, double pressure_hpa, double temperature_c) {
    const auto bennett = [](double h) { return cot_deg(h + 7.31 / (h + 4.4)) + 0.0013515; };
    return weather(pressure_hpa, temperature_c) * extended_rad(altitude_rad, bennett);
}

} // namespace alpenglow::ephemeris
