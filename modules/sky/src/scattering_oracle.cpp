#include <alpenglow/sky/scattering_oracle.hpp>

#include "scattering_field.hpp"
#include "unit_quadrature.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/phase.hpp>

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>

namespace alpenglow::sky {

struct ScatteringOracle::Field {
    ScatteringAtmosphere air;
    double zenith = 0.0;
    ScatteredField<double> field;

    // Place of a sun angle on the grid, and Lagrange's cubic weights.
    bool place(double theta, std::size_t& j, double (&w)[4]) const {
        const double x = (theta - field.angles.low_rad) / field.angles.step_rad;
        if (x > field.angles.count - 3.0) {
            return false;
        }
        j = static_cast<std::size_t>(std::max(x, 1.0));
        const double u = std::max(x, 0.0) - static_cast<double>(j);
        w[0] = -u * (u - 1.0) * (u - 2.0) / 6.0;
        w[1] = (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0;
        w[2] = -(u + 1.0) * u * (u - 2.0) / 2.0;
        w[3] = (u + 1.0) * u * (u - 1.0) / 6.0;
        return true;
    }

    // Light that scatters again towards a direction, per km, over the sun's light outside.
    glm::dvec3 again(const AirSample& sample, double h, double mu, double mu_s, double nu) const {
        const double theta = std::acos(std::clamp(mu_s, -1.0, 1.0));
        std::size_t j = 0;
        double w[4];
        if (!place(theta, j, w)) {
            return glm::dvec3(0.0);
        }
        const int heights = field.heights;
        const double at = std::sqrt(std::clamp(h / air.top_km, 0.0, 1.0)) * (heights - 1);
        const int i = std::min(static_cast<int>(at), heights - 2);
        const double n = heights - 1;
        const double h0 = air.top_km * (i / n) * (i / n);
        const double h1 = air.top_km * ((i + 1) / n) * ((i + 1) / n);
        const double u = std::clamp((h - h0) / (h1 - h0), 0.0, 1.0);
        const auto bands = static_cast<std::size_t>(field.bands);
        const std::size_t functions = bands * (bands + 1) / 2;
        const auto count = static_cast<std::size_t>(field.angles.count);
        const auto read = [&](const std::vector<double>& values, std::size_t row, std::size_t rows) {
            double sum = 0.0;
            for (std::size_t e = 0; e < 2; ++e) {
                const double* from = values.data() + ((static_cast<std::size_t>(i) + e) * rows + row) * count + j - 1;
                sum += (e == 0 ? 1.0 - u : u) * (w[0] * from[0] + w[1] * from[1] + w[2] * from[2] + w[3] * from[3]);
            }
            return sum;
        };
        const double s = std::sqrt(std::max(1.0 - mu * mu, 0.0));
        const double sine_s = std::sin(theta);
        std::array<double, most_field_functions> y{};
        std::array<double, most_field_functions> sun{};
        field_shapes(field.bands, mu, s, y);
        field_shapes(field.bands, mu_s, sine_s, sun);
        const double azimuth =
            s * sine_s > 1e-9 ? std::acos(std::clamp((nu - mu * mu_s) / (s * sine_s), -1.0, 1.0)) : 0.0;
        const double mean = field.phase_bands[1];
        const double peak =
            phase_henyey_greenstein(nu, mean * mean) - field.forward * phase_cornette_shanks(nu, air.mie_g);
        glm::dvec3 out;
        for (std::size_t c = 0; c < 3; ++c) {
            const double aureole = read(field.aureole, c, 3);
            double molecules = 0.0;
            double aerosol = aureole * peak;
            for (std::size_t m = 0; m < bands; ++m) {
                const double around = std::cos(static_cast<double>(m) * azimuth);
                for (std::size_t l = m; l < bands; ++l) {
                    const double beta = field.phase_bands[l];
                    const double value = read(field.field, field_function(field.bands, l, m) * 3 + c, functions * 3);
                    const double k = y[l * (l + 1) / 2 + m] * around;
                    const double in_peak = aureole * sun[l * (l + 1) / 2 + m];
                    if (l == 0 || l == 2) {
                        molecules += k * (l == 0 ? 1.0 : 0.1) * (value + in_peak * beta);
                    }
                    aerosol += k * ((beta - field.forward) * value +
                                    in_peak * (beta * beta - std::pow(mean, 2.0 * static_cast<double>(l))));
                }
            }
            const int k = static_cast<int>(c);
            out[k] = std::max(sample.rayleigh[k] * molecules + sample.mie[k] * aerosol, 0.0);
        }
        return out;
    }
};

ScatteringOracle::ScatteringOracle(const ScatteringAtmosphere& air, double sun_zenith_rad,
                                   const OracleResolution& resolution)
    : field_(std::make_unique<Field>()) {
    field_->air = air;
    field_->zenith = sun_zenith_rad;
    FieldResolution size;
    size.heights = resolution.heights;
    size.zeniths = resolution.zeniths;
    size.azimuths = resolution.azimuths;
    size.orders = resolution.orders;
    size.bands = size.late_bands = resolution.bands;
    size.late_azimuths = resolution.azimuths;
    size.all_tangents = resolution.heights;
    const FieldAngles angles{sun_zenith_rad - 0.55 * resolution.angles * resolution.step_rad, resolution.step_rad,
                             resolution.angles};
    const SunAt sun_at = [&](double h, double zenith, glm::dvec3& light, glm::dvec3& depth) {
        exact_sun_at(air, h, zenith, light, depth);
    };
    build_scattered_field<double>(air, size, std::span(&angles, 1), sun_at, std::span(&field_->field, 1));
}

ScatteringOracle::~ScatteringOracle() = default;
ScatteringOracle::ScatteringOracle(ScatteringOracle&&) noexcept = default;

glm::dvec3 ScatteringOracle::radiance(double height_km, double mu, double azimuth_rad, int steps) const {
    const ScatteringAtmosphere& air = field_->air;
    const double forward = field_->field.forward;
    const double mu_s = std::cos(field_->zenith);
    const double nu = std::clamp(
        mu * mu_s + std::sqrt(std::max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 0.0)) * std::cos(azimuth_rad), -1.0, 1.0);
    const RaySpan span = ray_span(air, height_km, mu);
    const double r = air.ground_radius_km + height_km;
    const double length = span.end_km - span.begin_km;
    const bool down = span.ground && height_km > 0.0;
    const double rayleigh = phase_rayleigh(nu);
    const double mie = phase_cornette_shanks(nu, air.mie_g);
    glm::dvec3 through(1.0);
    glm::dvec3 sum(0.0);
    double before = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double x = static_cast<double>(i + 1) / steps;
        const double t = down ? 1.0 - (1.0 - x) * (1.0 - x) : x * x;
        const double s = span.begin_km + length * 0.5 * (before + t);
        const double step = length * (t - before);
        before = t;
        const double squared = s * (s + 2.0 * r * mu);
        const double radius = std::sqrt(r * r + squared);
        const double h = std::max(height_km + squared / (radius + r), 0.0);
        const AirSample sample = sample_air(air, h);
        const glm::dvec3 extinction = sample.extinction - forward * sample.mie;
        const double local = (r * mu_s + s * nu) / radius;
        const glm::dvec3 light = field_->again(sample, h, (r * mu + s) / radius, local, nu) +
                                 (sample.rayleigh * rayleigh + sample.mie * mie) *
                                     sun_transmittance(air, h, std::clamp(local, -1.0, 1.0), 16);
        for (int c = 0; c < 3; ++c) {
            const double depth = extinction[c] * step;
            sum[c] += through[c] * light[c] * (depth > 1e-9 ? -std::expm1(-depth) / depth : 1.0) * step;
            through[c] *= std::exp(-depth);
        }
    }
    if (span.ground) {
        const double local = (r * mu_s + span.end_km * nu) / air.ground_radius_km;
        std::size_t j = 0;
        double w[4];
        if (field_->place(std::acos(std::clamp(local, -1.0, 1.0)), j, w)) {
            const auto count = static_cast<std::size_t>(field_->field.angles.count);
            for (std::size_t c = 0; c < 3; ++c) {
                const double* at = field_->field.ground.data() + c * count + j - 1;
                const int k = static_cast<int>(c);
                sum[k] += through[k] * air.ground_albedo[k] / pi *
                          std::max(w[0] * at[0] + w[1] * at[1] + w[2] * at[2] + w[3] * at[3], 0.0);
            }
        }
    }
    return sum * air.sun_lux;
}

glm::dvec3 ScatteringOracle::ground_illuminance_lux() const {
    std::size_t j = 0;
    double w[4];
    glm::dvec3 out(0.0);
    if (field_->place(field_->zenith, j, w)) {
        const auto count = static_cast<std::size_t>(field_->field.angles.count);
        for (std::size_t c = 0; c < 3; ++c) {
            const double* at = field_->field.ground.data() + c * count + j - 1;
            out[static_cast<int>(c)] = w[0] * at[0] + w[1] * at[1] + w[2] * at[2] + w[3] * at[3];
        }
    }
    return out * field_->air.sun_lux;
}

ScatteringOracle::Balance ScatteringOracle::flat_balance() const {
    const ScatteringAtmosphere& air = field_->air;
    const double mu_s = std::cos(field_->zenith);
    Balance out{};
    out.ground = (1.0 - air.ground_albedo) * ground_illuminance_lux() / (air.sun_lux * mu_s);
    // To space: radiance from above, looking down, over all directions.
    const UnitNodes nodes = unit_quadrature(12);
    constexpr int azimuths = 16;
    for (std::size_t k = 0; k < nodes.x.size(); ++k) {
        const double mu = nodes.x[k];
        for (int n = 0; n < azimuths; ++n) {
            out.space += radiance(air.top_km, -mu, pi * (n + 0.5) / azimuths, 200) *
                         (nodes.w[k] * mu * two_pi / azimuths) / (air.sun_lux * mu_s);
        }
    }
    // In the air: absorbed by aerosol and ozone, of the sun's light and of what has been scattered. Between shells all
    // is mean light times absorption.
    const UnitNodes heights = unit_quadrature(48);
    const auto bands = static_cast<std::size_t>(field_->field.bands);
    const std::size_t functions = bands * (bands + 1) / 2;
    const auto count = static_cast<std::size_t>(field_->field.angles.count);
    std::size_t j = 0;
    double w[4];
    if (!field_->place(field_->zenith, j, w)) {
        return out;
    }
    for (std::size_t k = 0; k < heights.x.size(); ++k) {
        const double t = heights.x[k];
        const double h = air.top_km * t * t;
        const AirSample sample = sample_air(air, h);
        const double at = t * (field_->field.heights - 1);
        const int i = std::min(static_cast<int>(at), field_->field.heights - 2);
        const double n = field_->field.heights - 1;
        const double u = (h / air.top_km - (i / n) * (i / n)) / ((2.0 * i + 1.0) / (n * n));
        const glm::dvec3 sun = sun_transmittance(air, h, mu_s, 32);
        for (std::size_t c = 0; c < 3; ++c) {
            double mean = 0.0;
            for (std::size_t e = 0; e < 2; ++e) {
                const std::size_t shell = static_cast<std::size_t>(i) + e;
                const double* field = field_->field.field.data() + (shell * functions * 3 + c) * count + j - 1;
                const double* aureole = field_->field.aureole.data() + (shell * 3 + c) * count + j - 1;
                for (std::size_t q = 0; q < 4; ++q) {
                    mean += (e == 0 ? 1.0 - u : u) * w[q] * (field[q] / 0.28209479177387814 + aureole[q]);
                }
            }
            const int q = static_cast<int>(c);
            const double absorption = sample.extinction[q] - sample.rayleigh[q] - sample.mie[q];
            out.air[q] += absorption * (mean + sun[q]) * heights.w[k] * 2.0 * t * air.top_km / mu_s;
        }
    }
    return out;
}

} // namespace alpenglow::sky
