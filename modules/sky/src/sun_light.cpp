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

// Of the whole air: molecules, and aerosol with the depth 1 at one micrometre.
struct VerticalDepths {
    Spectrum molecules, aerosol;
};
const VerticalDepths& vertical_depths() {
    static const VerticalDepths depths = [] {
        VerticalDepths out{};
        for (std::size_t i = 0; i < spectrum_samples; ++i) {
            const double um = wavelength_nm(i) * 1e-3;
            out.molecules[i] = 0.008735 * std::pow(um, -4.08);
            out.aerosol[i] = std::pow(um, -1.3);
        }
        return out;
    }();
    return depths;
}

// NaN counts as the least.
double bounded(double value, double least, double most) {
    return value >= least ? std::min(value, most) : least;
}

constexpr double earth_radius_m = 6371e3;
constexpr double highest_m = 1e5;
constexpr double molecule_height_m = 8000.0;

double held_height(double height_m) {
    return bounded(height_m, 0.0, highest_m);
}

double density(double height_m) {
    return std::exp(-height_m / molecule_height_m);
}

// The Chapman function for a ray from radius x (in scale heights) whose altitude has the sine s >= 0: sqrt(pi x / 2)
// e^(y^2) erfc(y), y = s sqrt(x / 2), with the quotients of Smith and Smith 1972.
double chapman(double x, double s) {
    const double y = s * std::sqrt(0.5 * x);
    const double scaled =
        y < 8.0 ? (1.0606963 + 0.55643831 * y) / (1.0619896 + (1.7245609 + y) * y) : 0.56498823 / (0.06651874 + y);
    return std::sqrt(0.5 * pi * x) * scaled;
}

// What a ray crosses of a layer of that scale height, in scale heights of the density at sea level.
double crossed(double scale_m, double height_m, double lowest_m, double sine) {
    const double from = std::exp(-height_m / scale_m) * chapman((earth_radius_m + height_m) / scale_m, std::abs(sine));
    if (sine >= 0.0) {
        return from;
    }
    return 2.0 * std::exp(-lowest_m / scale_m) * chapman((earth_radius_m + lowest_m) / scale_m, 0.0) - from;
}

// Of the ozone column, the part above a height: a tent over 10 .. 40 km.
double ozone_above(double height_m) {
    const double km = 1e-3 * height_m;
    if (km <= 25.0) {
        const double t = std::max(km - 10.0, 0.0) / 15.0;
        return 1.0 - 0.5 * t * t;
    }
    const double t = std::max(40.0 - km, 0.0) / 15.0;
    return 0.5 * t * t;
}

// Bennett 1982: refraction at an apparent altitude of 0 .. 90 degrees, at sea level.
double bennett_rad(double apparent_altitude_rad) {
    const double h = apparent_altitude_rad / degree_rad;
    return std::max(1.0 / std::tan((h + 7.31 / (h + 4.4)) * degree_rad), 0.0) / 60.0 * degree_rad;
}

// The lowest point of a ray that leaves a height downwards, not under the sea.
double lowest_m(double height_m, double cosine) {
    return std::clamp((earth_radius_m + height_m) * cosine - earth_radius_m, 0.0, height_m);
}

double refraction_at_apparent(double apparent, double height_m) {
    if (apparent >= 0.0) {
        return density(height_m) * bennett_rad(apparent);
    }
    return 2.0 * density(lowest_m(height_m, std::cos(apparent))) * bennett_rad(0.0) -
           density(height_m) * bennett_rad(-apparent);
}

glm::dvec3 direct_illuminance(const Spectrum& source, bool darkened_limb, double geometric_altitude_rad,
                              double angular_radius_rad, const AirColumn& air) {
    const double horizon = horizon_altitude_rad(air.observer_height_m);
    const ApparentDisc disc = apparent_disc(geometric_altitude_rad, angular_radius_rad, air.observer_height_m);
    const double over = disc.altitude_rad - horizon;
    const glm::dvec3 visible = darkened_limb ? visible_sun_fraction(over, disc.vertical_radius_rad)
                                             : glm::dvec3(visible_disc_fraction(over, disc.vertical_radius_rad));
    if (!(visible.x > 0.0)) {
        return glm::dvec3(0.0);
    }
    Spectrum spectrum =
        air_transmittance(air, slant_column(std::max(disc.altitude_rad, horizon), air.observer_height_m));
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

double refraction_rad(double geometric_altitude_rad, double height_m) {
    const double height = held_height(height_m);
    const double geometric = bounded(geometric_altitude_rad, -0.5 * pi, 0.5 * pi);
    if (geometric >= 0.0) {
        double refraction = 0.0;
        for (int i = 0; i < 12; ++i) { // refraction falls by a fifth at most of what the altitude rises
            const double next = density(height) * bennett_rad(geometric + refraction);
            const bool settled = std::abs(next - refraction) < 1e-12;
            refraction = next;
            if (settled) {
                break;
            }
        }
        return refraction;
    }
    // geometric = apparent - refraction(apparent), which rises with the apparent altitude.
    double low = geometric;
    double high = geometric + 0.025;
    for (int i = 0; i < 36; ++i) {
        const double middle = 0.5 * (low + high);
        (middle - refraction_at_apparent(middle, height) < geometric ? low : high) = middle;
    }
    return std::max(0.5 * (low + high) - geometric, 0.0);
}

double horizon_altitude_rad(double height_m) {
    const double height = held_height(height_m);
    // atan2 keeps its digits near the ground, where acos has none.
    return -std::atan2(std::sqrt(height * (2.0 * earth_radius_m + height)), earth_radius_m);
}

ApparentDisc apparent_disc(double geometric_altitude_rad, double angular_radius_rad, double height_m) {
    const double radius = bounded(angular_radius_rad, 0.0, 0.1);
    const double up = geometric_altitude_rad + radius;
    const double down = geometric_altitude_rad - radius;
    const double top = up + refraction_rad(up, height_m);
    const double bottom = down + refraction_rad(down, height_m);
    return {0.5 * (top + bottom), 0.5 * (top - bottom), radius};
}

namespace {

// Exponents of mu.
constexpr glm::dvec3 limb_exponent{-0.023 + 0.292 / 0.63, -0.023 + 0.292 / 0.55, -0.023 + 0.292 / 0.45};

// Integral of cos^q from -pi/2 to an angle: the light of a darkened disc (q = 2 + its exponent) below a chord at the
// sine of that angle, whose rows are (1 - y^2)^((q - 1) / 2).
double below_chord(double angle, double q) {
    // Gauss-Legendre on 0 .. 1, eight nodes.
    constexpr double x[4] = {0.01985507175123188, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751};
    constexpr double w[4] = {0.05061426814518813, 0.11119051722668724, 0.15685332293894364, 0.18134189168918099};
    const double length = angle + 0.5 * pi;
    double sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        // cos(-pi/2 + t) = sin t
        sum += w[i] * (std::pow(std::max(std::sin(length * x[i]), 0.0), q) +
                       std::pow(std::max(std::sin(length * (1.0 - x[i])), 0.0), q));
    }
    return sum * length;
}

} // namespace

glm::dvec3 limb_darkening(double radius_fraction) {
    const double r = bounded(radius_fraction, 0.0, 1.0);
    const double mu = std::sqrt((1.0 - r) * (1.0 + r));
    glm::dvec3 out;
    for (int k = 0; k < 3; ++k) {
        out[k] = 0.5 * (limb_exponent[k] + 2.0) * std::pow(mu, limb_exponent[k]);
    }
    return out;
}

glm::dvec3 visible_sun_fraction(double altitude_rad, double vertical_radius_rad) {
    if (!(vertical_radius_rad > 0.0)) {
        return glm::dvec3(altitude_rad >= 0.0 ? 1.0 : 0.0);
    }
    const double u = std::clamp(altitude_rad / vertical_radius_rad, -1.0, 1.0);
    if (std::abs(u) == 1.0) {
        return glm::dvec3(u > 0.0 ? 1.0 : 0.0);
    }
    const double angle = std::asin(u);
    glm::dvec3 out;
    for (int k = 0; k < 3; ++k) {
        const double q = limb_exponent[k] + 2.0;
        out[k] = std::clamp(below_chord(angle, q) / below_chord(0.5 * pi, q), 0.0, 1.0);
    }
    return out;
}

double visible_disc_fraction(double altitude_rad, double radius_rad) {
    if (!(radius_rad > 0.0)) {
        return altitude_rad >= 0.0 ? 1.0 : 0.0;
    }
    const double u = std::clamp(altitude_rad / radius_rad, -1.0, 1.0);
    const double chord = std::sqrt((1.0 - u) * (1.0 + u));
    return std::clamp((std::atan2(chord, -u) + u * chord) / pi, 0.0, 1.0);
}

SlantColumn slant_column(double apparent_altitude_rad, double height_m) {
    const double height = held_height(height_m);
    const double altitude = bounded(apparent_altitude_rad, horizon_altitude_rad(height), 0.5 * pi);
    const double sine = std::sin(altitude);
    const double lowest = lowest_m(height, std::cos(altitude));
    const double sea = relative_optical_length(altitude);
    const double sea_sine = std::max(sine, 0.0);
    const auto amount = [&](double scale_m) {
        return sea * crossed(scale_m, height, lowest, sine) / chapman(earth_radius_m / scale_m, sea_sine);
    };
    const double ozone_part = sine >= 0.0 ? ozone_above(height) : 2.0 * ozone_above(lowest) - ozone_above(height);
    return {amount(molecule_height_m), amount(1250.0), sea * ozone_part, amount(2000.0)};
}

Spectrum air_transmittance(const AirColumn& air, double m) {
    return air_transmittance(air, SlantColumn{m, m, m, m});
}

Spectrum air_transmittance(const AirColumn& air, const SlantColumn& column) {
    const double turbidity = bounded(air.turbidity, 1.0, 20.0);
    const double beta = std::max(0.04608365822050 * turbidity - 0.04586025928522, 0.0);
    const double ozone_cm = bounded(air.ozone_atm_cm, 0.0, 2.0);
    const double water_cm = bounded(air.water_cm, 0.0, 20.0);
    const VerticalDepths& vertical = vertical_depths();
    Spectrum out{};
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        double depth = column.molecules * vertical.molecules[i] + column.aerosol * beta * vertical.aerosol[i] +
                       column.ozone * ozone[i] * ozone_cm;
        const double w = water[i] * water_cm * column.water;
        if (w > 0.0) {
            depth += 0.2385 * w / std::pow(1.0 + 20.07 * w, 0.45);
        }
        const double gas = (i == 38 ? mixed_gas_760nm : i == 39 ? mixed_gas_770nm : 0.0) * column.molecules;
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
    return direct_illuminance(sun_spectrum(), true, geometric_altitude_rad, angular_radius_rad, air) /
           (distance * distance);
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
    return direct_illuminance(moon_spectrum(), false, geometric_altitude_rad, angular_radius_rad, air) *
           (moon_phase_factor(phase_angle_rad) / (distance * distance));
}

} // namespace alpenglow::sky
