#include <alpenglow/sky/sun_light.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>

namespace alpenglow::sky {
namespace {

// Preetham et al. 1999, table 2: the sun's spectral radiance (relative here), ozone and water absorption, from 380 nm.
// Beyond 750 nm the sun continues with the slope of a 5778 K black body.
constexpr Spectrum sun_shape{165.5, 162.3, 211.2, 258.8, 258.2, 242.3, 267.6, 296.6, 305.4, 300.6, 306.6,
                             288.3, 287.1, 278.2, 271.0, 272.3, 263.6, 255.0, 250.6, 253.1, 253.5, 251.3,
                             246.3, 241.7, 236.8, 232.1, 228.2, 223.4, 219.7, 215.3, 211.0, 207.3, 202.4,
                             198.7, 194.3, 190.7, 186.3, 182.6, 178.9, 175.3, 171.8};
// cm^-1
constexpr Spectrum ozone{0.0,   0.0,   0.0,   0.0,   0.0,   0.0,   0.0,   0.003, 0.006, 0.009, 0.014,
                         0.021, 0.030, 0.040, 0.048, 0.063, 0.075, 0.085, 0.103, 0.120, 0.120, 0.115,
                         0.125, 0.120, 0.090, 0.079, 0.067, 0.057, 0.048, 0.036, 0.028, 0.023, 0.018,
                         0.014, 0.011, 0.010, 0.009, 0.007, 0.004, 0.0,   0.0};
constexpr Spectrum water{0, 0, 0, 0,     0,     0,      0,   0,    0,     0,     0,    0,    0,   0,
                         0, 0, 0, 0,     0,     0,      0,   0,    0,     0,     0,    0,    0,   0,
                         0, 0, 0, 0.016, 0.024, 0.0125, 1.0, 0.87, 0.061, 0.001, 1e-5, 1e-5, 6e-4};
constexpr double mixed_gas_760nm = 3.0;
constexpr double mixed_gas_770nm = 0.21;

double wavelength_nm(std::size_t i) {
    return spectrum_first_nm + spectrum_step_nm * static_cast<double>(i);
}

Spectrum scaled_to_lux(Spectrum spectrum, double lux) {
    const double scale = lux / spectrum_to_xyz(spectrum).y;
    for (double& value : spectrum) {
        value *= scale;
    }
    return spectrum;
}

// NaN counts as the least.
double bounded(double value, double least, double most) {
    return value >= least ? std::min(value, most) : least;
}

glm::dvec3 direct_illuminance(const Spectrum& source, double geometric_altitude_rad, double angular_radius_rad,
                              const AirColumn& air) {
    const double apparent = geometric_altitude_rad + refraction_rad(geometric_altitude_rad);
    const double visible = visible_disc_fraction(apparent, angular_radius_rad);
    if (visible <= 0.0) {
        return glm::dvec3(0.0);
    }
    Spectrum spectrum = air_transmittance(air, relative_optical_length(apparent));
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        spectrum[i] *= source[i];
    }
    return visible * into_gamut(xyz_to_rec709(spectrum_to_xyz(spectrum)));
}

} // namespace

double relative_optical_length(double apparent_altitude_rad) {
    const double altitude = bounded(apparent_altitude_rad, 0.0, 0.5 * pi);
    return 1.0 / (std::sin(altitude) + 0.15 * std::pow(3.885 + altitude / degree_rad, -1.253));
}

double refraction_rad(double geometric_altitude_rad) {
    const double h = bounded(geometric_altitude_rad / degree_rad, -1.0, 90.0);
    const double arcmin = 1.02 / std::tan((h + 10.3 / (h + 5.11)) * degree_rad);
    return std::max(arcmin, 0.0) / 60.0 * degree_rad;
}

double visible_disc_fraction(double altitude_rad, double radius_rad) {
    if (!(radius_rad > 0.0)) {
        return altitude_rad >= 0.0 ? 1.0 : 0.0;
    }
    const double u = std::clamp(altitude_rad / radius_rad, -1.0, 1.0);
    const double chord = std::sqrt((1.0 - u) * (1.0 + u));
    return std::clamp((std::atan2(chord, -u) + u * chord) / pi, 0.0, 1.0);
}

Spectrum air_transmittance(const AirColumn& air, double m) {
    const double turbidity = bounded(air.turbidity, 1.0, 20.0);
    const double beta = std::max(0.04608365822050 * turbidity - 0.04586025928522, 0.0);
    const double ozone_cm = bounded(air.ozone_atm_cm, 0.0, 2.0);
    const double water_cm = bounded(air.water_cm, 0.0, 20.0);
    Spectrum out{};
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        const double log_um = std::log(wavelength_nm(i) * 1e-3);
        double depth = m * (0.008735 * std::exp(-4.08 * log_um) + beta * std::exp(-1.3 * log_um) + ozone[i] * ozone_cm);
        const double w = water[i] * water_cm * m;
        if (w > 0.0) {
            depth += 0.2385 * w / std::pow(1.0 + 20.07 * w, 0.45);
        }
        const double gas = i == 38 ? mixed_gas_760nm * m : i == 39 ? mixed_gas_770nm * m : 0.0;
        if (gas > 0.0) {
            depth += 1.41 * gas / std::pow(1.0 + 118.93 * gas, 0.45);
        }
        out[i] = std::exp(-depth);
    }
    return out;
}

const Spectrum& sun_spectrum() {
    static const Spectrum spectrum = scaled_to_lux(sun_shape, solar_illuminance_constant_lux);
    return spectrum;
}

const Spectrum& moon_spectrum() {
    static const Spectrum spectrum = [] {
        Spectrum ramp = sun_shape;
        for (std::size_t i = 0; i < spectrum_samples; ++i) {
            ramp[i] *= 0.70 + 0.65 * (wavelength_nm(i) - 340.0) / 400.0;
        }
        return scaled_to_lux(ramp, full_moon_illuminance_lux);
    }();
    return spectrum;
}

glm::dvec3 sun_illuminance_lux(double geometric_altitude_rad, double angular_radius_rad, double distance_au,
                               const AirColumn& air) {
    const double distance = bounded(distance_au, 0.1, 1e3);
    return direct_illuminance(sun_spectrum(), geometric_altitude_rad, angular_radius_rad, air) / (distance * distance);
}

double moon_phase_factor(double phase_angle_rad) {
    const double a = bounded(std::abs(phase_angle_rad), 0.0, pi) / degree_rad;
    return std::pow(10.0, -0.4 * (0.026 * a + 4e-9 * a * a * a * a));
}

double lommel_seeliger_phase_factor(double phase_angle_rad) {
    const double a = bounded(std::abs(phase_angle_rad), 0.0, pi);
    if (a < 1e-6) {
        return 1.0;
    }
    if (a > pi - 1e-6) {
        return 0.0;
    }
    return 1.0 - std::sin(0.5 * a) * std::tan(0.5 * a) * std::log(1.0 / std::tan(0.25 * a));
}

glm::dvec3 moon_illuminance_lux(double geometric_altitude_rad, double angular_radius_rad, double distance_m,
                                double phase_angle_rad, const AirColumn& air) {
    const double distance = bounded(distance_m, 1e8, 1e9) / 3.844e8;
    return direct_illuminance(moon_spectrum(), geometric_altitude_rad, angular_radius_rad, air) *
           (moon_phase_factor(phase_angle_rad) / (distance * distance));
}

} // namespace alpenglow::sky
