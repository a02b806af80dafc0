#include <alpenglow/sky/aerial_table.hpp>
#include <alpenglow/sky/scattering_tables.hpp>

#include "scattering_field.hpp"
#include "scattering_simd.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/phase.hpp>
#include <alpenglow/sky/sun_light.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

double mu_horizon(const ScatteringAtmosphere& air, double height_km) {
    const double ratio = air.ground_radius_km / (air.ground_radius_km + std::max(height_km, 0.0));
    return -std::sqrt(std::max((1.0 - ratio) * (1.0 + ratio), 0.0));
}

ShellKernel shell_of(const ScatteringAtmosphere& air, double forward) {
    ShellKernel shell{};
    shell.radius_km = static_cast<float>(air.ground_radius_km);
    shell.top_km = static_cast<float>(air.top_km);
    shell.rayleigh_height_km = static_cast<float>(air.rayleigh_height_km);
    shell.mie_height_km = static_cast<float>(air.mie_height_km);
    for (int c = 0; c < 3; ++c) {
        shell.rayleigh[c] = static_cast<float>(air.rayleigh_per_km[c]);
        shell.mie[c] = static_cast<float>(air.mie_scattering_per_km[c] + air.mie_absorption_per_km[c]);
        shell.ozone[c] = static_cast<float>(air.ozone_per_km[c]);
        shell.mie_scattering[c] = static_cast<float>(air.mie_scattering_per_km[c]);
    }
    shell.forward = static_cast<float>(forward);
    shell.inverse_disc = static_cast<float>(1.0 / std::max(air.sun_angular_radius_rad, 1e-6));
    return shell;
}

// Where a height lies among `heights` of a square law.
struct Place {
    std::size_t low;
    double part;
};
Place place_of(double top_km, double height_km, int heights) {
    const double at = std::sqrt(std::clamp(height_km / top_km, 0.0, 1.0)) * (heights - 1);
    const auto low = static_cast<std::size_t>(std::min(static_cast<int>(at), heights - 2));
    return {low, at - static_cast<double>(low)};
}
// Three neighbours and their weights: the columns of air bend with height.
struct Bent {
    std::size_t low;
    double w[3];
};
Bent bent_place_of(double top_km, double height_km, int heights) {
    const double at = std::sqrt(std::clamp(height_km / top_km, 0.0, 1.0)) * (heights - 1);
    const int middle = std::clamp(static_cast<int>(at + 0.5), 1, heights - 2);
    const double u = at - middle;
    return {static_cast<std::size_t>(middle - 1), {0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)}};
}
// The same, linear in height between two of them, as the field is made.
Place linear_place_of(double top_km, double height_km, int heights) {
    const Place place = place_of(top_km, height_km, heights);
    const double n = heights - 1;
    const auto low = static_cast<double>(place.low);
    const double h0 = top_km * (low / n) * (low / n);
    const double h1 = top_km * ((low + 1.0) / n) * ((low + 1.0) / n);
    return {place.low, std::clamp((height_km - h0) / (h1 - h0), 0.0, 1.0)};
}

void cubic_weights(double u, double (&w)[4]) {
    w[0] = -u * (u - 1.0) * (u - 2.0) / 6.0;
    w[1] = (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0;
    w[2] = -(u + 1.0) * u * (u - 2.0) / 2.0;
    w[3] = (u + 1.0) * u * (u - 1.0) / 6.0;
}

} // namespace

ScatteringTables::ScatteringTables(const ScatteringAtmosphere& air, const ScatteringResolution& resolution)
    : air_(air), resolution_(resolution) {
    assert(resolution.sun_heights >= 3 && resolution.sun_angles >= 2);
    build_sun();
    build_field();
}

void ScatteringTables::build_sun() {
    const int heights = resolution_.sun_heights;
    const auto angles = static_cast<std::size_t>(resolution_.sun_angles);
    sun_.resize(static_cast<std::size_t>(heights) * 3 * angles);
    const ShellKernel shell = shell_of(air_, 0.0);
    std::array<float, march_lanes> mu{};
    float out[3][march_lanes];
    for (int i = 0; i < heights; ++i) {
        const double t = static_cast<double>(i) / (heights - 1);
        const double h = air_.top_km * t * t;
        const double horizon = mu_horizon(air_, h);
        for (std::size_t j0 = 0; j0 < angles; j0 += march_lanes) {
            for (std::size_t k = 0; k < march_lanes; ++k) {
                const double w =
                    static_cast<double>(sun_axis_high) * static_cast<double>(j0 + k) / static_cast<double>(angles - 1);
                mu[k] = static_cast<float>(std::min(horizon + w * w, 1.0));
            }
            shell_columns(shell, static_cast<float>(h), mu.data(), out);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t k = 0; k < march_lanes && j0 + k < angles; ++k) {
                    sun_[(static_cast<std::size_t>(i) * 3 + c) * angles + j0 + k] = out[c][k];
                }
            }
        }
    }
}

void ScatteringTables::build_field() {
    FieldResolution resolution;
    resolution.heights = resolution_.field_heights;
    resolution.zeniths = resolution_.field_zeniths;
    resolution.azimuths = resolution_.field_azimuths;
    resolution.orders = resolution_.field_orders;
    resolution.bands = resolution_.field_bands;
    auto zones = std::make_shared<ScatteredZones>();
    const SunAt sun_at = [this](double height_km, double zenith, glm::dvec3& light, glm::dvec3& depth) {
        const auto h = static_cast<float>(height_km);
        const auto mu_s = static_cast<float>(std::cos(zenith));
        light = glm::dvec3(sun_transmittance(h, mu_s));
        depth = air_.mie_scattering_per_km * static_cast<double>(columns(h, mu_s).y);
    };
    const std::array<FieldAngles, 2> angles{{{-16.0 * degree_rad, 4.0 * degree_rad, 32},  // the day
                                             {72.0 * degree_rad, 0.5 * degree_rad, 80}}}; // dusk and dawn
    build_scattered_field<float>(air_, resolution, angles, sun_at, zones->zones);
    field_ = std::move(zones);
}

std::size_t ScatteringTables::field_bytes() const {
    std::size_t bytes = 0;
    for (const ScatteredField<float>& zone : field_->zones) {
        bytes += 4 * (zone.field.size() + zone.aureole.size() + zone.ground.size() + zone.sun.size());
    }
    return bytes;
}

glm::vec3 ScatteringTables::columns(float height_km, float mu) const {
    const auto stride = static_cast<std::size_t>(resolution_.sun_angles);
    const double h = std::clamp(static_cast<double>(height_km), 0.0, air_.top_km);
    const Bent place = bent_place_of(air_.top_km, h, resolution_.sun_heights);
    const auto over = static_cast<float>(static_cast<double>(mu) - mu_horizon(air_, h));
    const float y =
        std::clamp(std::sqrt(std::max(over, 0.0F)) / sun_axis_high, 0.0F, 1.0F) * static_cast<float>(stride - 1);
    const auto j = std::min(static_cast<std::size_t>(y), stride - 2);
    const float u = y - static_cast<float>(j);
    glm::vec3 out;
    for (std::size_t c = 0; c < 3; ++c) {
        float sum = 0.0F;
        for (std::size_t k = 0; k < 3; ++k) {
            const float* row = sun_.data() + ((place.low + k) * 3 + c) * stride + j;
            sum += static_cast<float>(place.w[k]) * (row[0] + u * (row[1] - row[0]));
        }
        out[static_cast<int>(c)] = std::max(sum, 0.0F);
    }
    return out;
}

glm::vec3 ScatteringTables::transmittance(float height_km, float mu) const {
    const glm::dvec3 n(columns(height_km, mu));
    return glm::vec3(
        glm::exp(-(air_.rayleigh_per_km * n.x + (air_.mie_scattering_per_km + air_.mie_absorption_per_km) * n.y +
                   air_.ozone_per_km * n.z)));
}

glm::vec3 ScatteringTables::sun_transmittance(float height_km, float mu_s) const {
    const double h = std::clamp(static_cast<double>(height_km), 0.0, air_.top_km);
    const double horizon = mu_horizon(air_, h);
    const double altitude = std::asin(std::clamp(static_cast<double>(mu_s), -1.0, 1.0)) - std::asin(horizon);
    const double visible = visible_disc_fraction(altitude, air_.sun_angular_radius_rad);
    return visible > 0.0 ? static_cast<float>(visible) * transmittance(height_km, mu_s) : glm::vec3(0.0F);
}

glm::vec3 ScatteringTables::ground_illuminance_lux(float mu_s) const {
    const double zenith = std::acos(std::clamp(static_cast<double>(mu_s), -1.0, 1.0));
    const ScatteredField<float>& zone = field_->at(zenith);
    const int count = zone.angles.count;
    const double x = std::clamp((zenith - zone.angles.low_rad) / zone.angles.step_rad, 1.0, count - 2.001);
    const auto j = static_cast<std::size_t>(x);
    double w[4];
    cubic_weights(x - static_cast<double>(j), w);
    glm::dvec3 out(0.0);
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 4; ++k) {
            out[static_cast<int>(c)] +=
                w[k] * static_cast<double>(zone.ground[c * static_cast<std::size_t>(count) + j - 1 + k]);
        }
    }
    return glm::vec3(glm::max(out, glm::dvec3(0.0)) * air_.sun_lux);
}

// The view ----------------------------------------------------------------------------------------------------------

namespace {

constexpr std::size_t max_steps = 128;
constexpr std::size_t window = 64;                 // sun angles around the view's own
constexpr std::size_t view_azimuths = march_lanes; // at which multiple scattering is marched

// A ray cut into steps.
struct Ray {
    std::array<MarchStep, max_steps> steps;
    std::array<double, max_steps> heights_km, angles_rad; // the angle at the Earth's centre from the viewer
    std::size_t count = 0;
    glm::dvec3 end_transmittance{1.0};
    double length_km = 0.0;
    bool ground = false;
};

// Steps crowd where the air is dense: towards the lower end of the path, by a square law. Within a step the light of
// its middle is weighed by the exact integral of transmittance times scattering. `forward` of the aerosol's scattering
// goes straight on.
void cut(const ScatteringAtmosphere& air, double forward, double height_km, double mu, int steps, Ray& ray) {
    const RaySpan span = ray_span(air, height_km, mu);
    ray.ground = span.ground;
    ray.length_km = span.end_km;
    ray.count = 0;
    ray.end_transmittance = glm::dvec3(1.0);
    const double length = span.end_km - span.begin_km;
    if (!(length > 0.0)) {
        return;
    }
    const double r = air.ground_radius_km + height_km;
    const bool down = span.ground && height_km > 0.0;
    double before = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double u = static_cast<double>(i + 1) / steps;
        const double t = down ? 1.0 - (1.0 - u) * (1.0 - u) : u * u;
        const double middle = span.begin_km + length * 0.5 * (before + t);
        const double step = length * (t - before);
        before = t;
        const double squared = middle * (middle + 2.0 * r * mu);
        const double radius = std::sqrt(r * r + squared);
        const double h = std::max(height_km + squared / (radius + r), 0.0);
        const AirSample sample = sample_air(air, h);
        const glm::dvec3 depth = (sample.extinction - forward * sample.mie) * step;
        MarchStep& out = ray.steps[ray.count];
        for (int c = 0; c < 3; ++c) {
            const double left = std::exp(-depth[c]);
            const double weight =
                ray.end_transmittance[c] * (depth[c] > 1e-4 ? (1.0 - left) / depth[c] : 1.0 - 0.5 * depth[c]) * step;
            out.rayleigh[c] = static_cast<float>(weight * sample.rayleigh[c]);
            out.mie[c] = static_cast<float>(weight * sample.mie[c]);
            ray.end_transmittance[c] *= left;
        }
        out.distance_km = static_cast<float>(middle);
        out.inverse_r = static_cast<float>(1.0 / radius);
        const double horizon = mu_horizon(air, h);
        out.mu_horizon = static_cast<float>(horizon);
        out.inverse_sine = static_cast<float>(1.0 / std::sqrt(1.0 - horizon * horizon));
        ray.angles_rad[ray.count] =
            std::asin(std::clamp(middle * std::sqrt(std::max(1.0 - mu * mu, 0.0)) / radius, -1.0, 1.0));
        ray.heights_km[ray.count++] = h;
    }
}

// The field around one sun angle, finer: what molecules scatter and what aerosol scatters, by phase bands.
struct FieldWindow {
    double low_rad = 0.0, step_rad = 0.0;
    int heights = 0, bands = 0;
    std::size_t functions = 0;
    // [height][function][channel][window]; of the molecules' only bands 0 and 2, by m: (0,0) (2,0) (2,1) (2,2)
    std::vector<float> molecules, aerosol;
};

// `reach_rad`: how far from the view's own sun angle.
FieldWindow make_window(const ScatteredField<float>& zone, double zenith, double reach_rad) {
    FieldWindow out;
    const int count = zone.angles.count;
    const auto stride = static_cast<std::size_t>(count);
    out.step_rad = 2.0 * reach_rad / static_cast<double>(window);
    out.low_rad = zenith - 0.5 * static_cast<double>(window) * out.step_rad;
    out.heights = zone.heights;
    out.bands = zone.bands;
    const auto bands = static_cast<std::size_t>(zone.bands);
    out.functions = bands * (bands + 1) / 2;
    const auto heights = static_cast<std::size_t>(zone.heights);
    out.molecules.resize(heights * 4 * 3 * window);
    out.aerosol.resize(heights * out.functions * 3 * window);

    std::array<std::size_t, window> cell{};
    std::array<std::array<float, 4>, window> w{};
    std::vector<std::array<double, most_field_functions>> sun(window);
    for (std::size_t j = 0; j < window; ++j) {
        const double theta = out.low_rad + out.step_rad * static_cast<double>(j);
        field_shapes(zone.bands, std::cos(theta), std::sin(theta), sun[j]);
        const double x = (theta - zone.angles.low_rad) / zone.angles.step_rad;
        const double held = std::clamp(x, 0.0, static_cast<double>(count - 1)); // constant beyond the ends
        cell[j] = static_cast<std::size_t>(std::clamp(static_cast<int>(held), 1, count - 3));
        double weights[4];
        cubic_weights(held - static_cast<double>(cell[j]), weights);
        for (std::size_t k = 0; k < 4; ++k) {
            w[j][k] = static_cast<float>(weights[k]);
        }
    }
    std::array<float, window> row{};
    std::array<std::array<float, window>, 3> peak{};
    const auto resample = [&](const float* from, std::array<float, window>& to) {
        for (std::size_t j = 0; j < window; ++j) {
            const float* at = from + cell[j] - 1;
            to[j] = w[j][0] * at[0] + w[j][1] * at[1] + w[j][2] * at[2] + w[j][3] * at[3];
        }
    };
    const double mean = zone.phase_bands[1];
    for (std::size_t i = 0; i < heights; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            resample(zone.aureole.data() + (i * 3 + c) * stride, peak[c]);
        }
        for (std::size_t m = 0; m < bands; ++m) {
            for (std::size_t l = m; l < bands; ++l) {
                const std::size_t f = field_function(zone.bands, l, m);
                const double beta = zone.phase_bands[l];
                const auto of_field = static_cast<float>(beta - zone.forward);
                const auto of_peak = static_cast<float>(beta * beta - std::pow(mean, 2.0 * static_cast<double>(l)));
                for (std::size_t c = 0; c < 3; ++c) {
                    resample(zone.field.data() + ((i * out.functions + f) * 3 + c) * stride, row);
                    float* to = out.aerosol.data() + ((i * out.functions + f) * 3 + c) * window;
                    for (std::size_t j = 0; j < window; ++j) {
                        const float y = static_cast<float>(sun[j][l * (l + 1) / 2 + m]);
                        to[j] = of_field * row[j] + of_peak * peak[c][j] * y;
                    }
                    if (l == 0 || (l == 2 && m < 3)) {
                        const std::size_t k = l == 0 ? 0 : 1 + m;
                        const float share = l == 0 ? 1.0F : 0.1F;
                        float* molecules = out.molecules.data() + ((i * 4 + k) * 3 + c) * window;
                        for (std::size_t j = 0; j < window; ++j) {
                            const float y = static_cast<float>(sun[j][l * (l + 1) / 2 + m] * beta);
                            molecules[j] = share * (row[j] + peak[c][j] * y);
                        }
                    }
                }
            }
        }
    }
    return out;
}

// For each step of a ray the source along it: rows [mode][channel] over the sun angles that the step can see.
struct FieldRows {
    std::vector<float> storage;
    std::array<FieldRow, max_steps> rows;

    void fill(const FieldWindow& field, const Ray& ray, double top_km, double r0, double mu) {
        const auto bands = static_cast<std::size_t>(field.bands);
        const std::size_t size = bands * 3 * window;
        storage.resize(max_steps * size);
        std::array<double, most_field_functions> y{};
        std::array<float, most_field_bands> low{};
        std::array<float, most_field_bands> high{};
        for (std::size_t i = 0; i < ray.count; ++i) {
            const MarchStep& step = ray.steps[i];
            const Place place = linear_place_of(top_km, ray.heights_km[i], field.heights);
            const double z = std::clamp(
                (r0 * mu + static_cast<double>(step.distance_km)) * static_cast<double>(step.inverse_r), -1.0, 1.0);
            field_shapes(field.bands, z, std::sqrt(1.0 - z * z), y);
            // Only the angles within reach of the step, in whole vectors.
            const double reach = std::abs(ray.angles_rad[i]) / field.step_rad + 2.0;
            const double middle = 0.5 * static_cast<double>(window);
            const auto first = static_cast<std::size_t>(std::max(middle - reach, 0.0));
            const std::size_t last = std::min(static_cast<std::size_t>(std::max(middle + reach, 0.0)) + 1, window);
            const std::size_t count = std::min((last - first + 15) / 16 * 16, window);
            const std::size_t begin = std::min(first, window - count);
            float* to = storage.data() + i * size;
            rows[i] = {to, count, static_cast<float>(field.low_rad + field.step_rad * static_cast<double>(begin)),
                       static_cast<float>(1.0 / field.step_rad), static_cast<float>(count - 1) - 1e-3F};
            for (std::size_t m = 0; m < bands; ++m) {
                const std::size_t terms = bands - m;
                for (std::size_t c = 0; c < 3; ++c) {
                    const double mie = static_cast<double>(step.mie[c]);
                    for (std::size_t k = 0; k < terms; ++k) {
                        const double v = mie * y[(m + k) * (m + k + 1) / 2 + m];
                        low[k] = static_cast<float>(v * (1.0 - place.part));
                        high[k] = static_cast<float>(v * place.part);
                    }
                    const float* from =
                        field.aerosol.data() +
                        ((place.low * field.functions + field_function(field.bands, m, m)) * 3 + c) * window + begin;
                    float* row = to + (m * 3 + c) * count;
                    blend_rows(from, from + field.functions * 3 * window, low.data(), high.data(), 3 * window, terms,
                               count, row);
                    if (m < 3) {
                        const std::size_t one = m == 0 ? 0 : 1 + m;
                        for (std::size_t k = one; k <= (m == 0 ? 1 : one); ++k) {
                            const double v = static_cast<double>(step.rayleigh[c]) * (k == 0 ? y[0] : y[3 + m]);
                            const auto a = static_cast<float>(v * (1.0 - place.part));
                            const auto b = static_cast<float>(v * place.part);
                            const float* x = field.molecules.data() + ((place.low * 4 + k) * 3 + c) * window + begin;
                            const float* above = x + 4 * 3 * window;
                            for (std::size_t j = 0; j < count; ++j) {
                                row[j] += a * x[j] + b * above[j];
                            }
                        }
                    }
                }
            }
        }
    }
};

// The sun's columns at a ray's steps.
struct SunRows {
    std::vector<float> storage;
    std::array<SunRow, max_steps> rows;

    // Only the angles that a step can see: its sun's zenith angle is within the ray's angle of `zenith`.
    void fill(const ScatteringTables& tables, const Ray& ray, double zenith) {
        const auto angles = static_cast<std::size_t>(tables.resolution().sun_angles);
        storage.resize(max_steps * 3 * angles, 0.0F);
        for (std::size_t i = 0; i < ray.count; ++i) {
            const Bent place = bent_place_of(tables.air().top_km, ray.heights_km[i], tables.resolution().sun_heights);
            const float* from = tables.sun().data() + place.low * 3 * angles;
            const auto a = static_cast<float>(place.w[0]);
            const auto b = static_cast<float>(place.w[1]);
            const auto c = static_cast<float>(place.w[2]);
            float* to = storage.data() + i * 3 * angles;
            const double horizon = static_cast<double>(ray.steps[i].mu_horizon);
            const double turn = std::abs(ray.angles_rad[i]) + 1e-4;
            const double per = static_cast<double>(angles - 1) / static_cast<double>(sun_axis_high);
            const auto index = [&](double mu) { return std::sqrt(std::max(mu - horizon, 0.0)) * per; };
            const double least = index(std::cos(std::min(zenith + turn, pi)));
            const double most = index(std::cos(std::max(zenith - turn, 0.0)));
            const auto first = std::min(static_cast<std::size_t>(least), angles - 2);
            const std::size_t end = std::min(static_cast<std::size_t>(most) + 3, angles);
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t j = k * angles + first; j < k * angles + end; ++j) {
                    to[j] = std::max(a * from[j] + b * from[3 * angles + j] + c * from[6 * angles + j], 0.0F);
                }
            }
            const auto last = static_cast<float>(angles - 1);
            rows[i] = {to, angles, last / sun_axis_high, last - 1e-3F};
        }
    }
};

// Weights that bring values at the view's azimuths to `columns` of them, by their cosine series.
std::vector<float> azimuth_spread(std::size_t columns) {
    std::vector<float> spread(view_azimuths * columns);
    for (std::size_t j = 0; j < columns; ++j) {
        const double azimuth = pi * static_cast<double>(j) / static_cast<double>(columns - 1);
        for (std::size_t n = 0; n < view_azimuths; ++n) {
            const double at = pi * (static_cast<double>(n) + 0.5) / static_cast<double>(view_azimuths);
            double sum = 1.0;
            for (std::size_t m = 1; m < view_azimuths; ++m) {
                sum += 2.0 * std::cos(static_cast<double>(m) * at) * std::cos(static_cast<double>(m) * azimuth);
            }
            spread[n * columns + j] = static_cast<float>(sum / static_cast<double>(view_azimuths));
        }
    }
    return spread;
}

} // namespace

float SkyView::cosine_of(float row) const {
    const float half = 0.5F * static_cast<float>(rows_);
    if (row < half) { // from the zenith down to the horizon
        const float t = std::max((half - 0.5F - row) / (half - 0.5F), 0.0F);
        return horizon_ + (1.0F - horizon_) * t * t;
    }
    const float t = std::min((row - half) / (half - 1.0F) + 0.0F, 1.0F);
    return horizon_ - 1e-5F - (1.0F + horizon_ - 1e-5F) * t * t;
}

float SkyView::row_of(float mu) const {
    const float half = 0.5F * static_cast<float>(rows_);
    if (mu >= horizon_) {
        const float t = std::sqrt(std::max(mu - horizon_, 0.0F) / (1.0F - horizon_));
        return std::clamp(half - 0.5F - t * (half - 0.5F), 0.0F, half - 1.0F);
    }
    const float t = std::sqrt(std::max(horizon_ - 1e-5F - mu, 0.0F) / std::max(1.0F + horizon_ - 1e-5F, 1e-6F));
    return std::clamp(half + t * (half - 1.0F), half, static_cast<float>(rows_ - 1));
}

void SkyView::build(const ScatteringTables& tables, float height_km, float mu_s, int steps) {
    const ScatteringAtmosphere& air = tables.air();
    const double h = std::clamp(static_cast<double>(height_km), 1e-3, air.top_km);
    const double r = air.ground_radius_km + h;
    const double zenith = std::acos(std::clamp(static_cast<double>(mu_s), -1.0, 1.0));
    const ScatteredField<float>& zone = tables.field().at(zenith);
    const double forward = zone.forward;
    const ShellKernel shell = shell_of(air, forward);
    horizon_ = static_cast<float>(mu_horizon(air, h));
    mie_g_ = static_cast<float>(air.mie_g);
    mie_mean_cosine_ = static_cast<float>(zone.phase_bands[1]);
    const auto columns = static_cast<std::size_t>(columns_);
    values_.assign(static_cast<std::size_t>(rows_) * sky_view_values * columns, 0.0F);
    const FieldWindow field = make_window(zone, zenith, std::min(4.0 + 0.5 * h, 10.0) * degree_rad);

    // Multiple scattering is smooth over the azimuth: marched at few, and brought to all by its cosines.
    std::array<float, view_azimuths> suns{};
    suns.fill(mu_s);
    const std::vector<float> spread = azimuth_spread(columns);
    std::vector<float> cosines((columns + march_lanes - 1) / march_lanes * march_lanes, -1.0F);
    for (std::size_t j = 0; j < columns; ++j) {
        cosines[j] = static_cast<float>(std::cos(pi * static_cast<double>(j) / static_cast<double>(columns - 1)));
    }

    const int field_steps = (steps + 1) / 2; // scattered light is smooth
    Ray ray;
    Ray coarse;
    SunRows sun_rows;
    FieldRows field_rows;
    std::array<float, march_lanes> nu{};
    std::array<float, march_lanes> base{};
    float single[3][3][march_lanes];
    float again[3][march_lanes];
    const float sine_s = std::sqrt(std::max(1.0F - mu_s * mu_s, 0.0F));
    base.fill(static_cast<float>(r) * mu_s);
    for (int row = 0; row < rows_; ++row) {
        const float mu = cosine_of(static_cast<float>(row));
        const float sine = std::sqrt(std::max(1.0F - mu * mu, 0.0F));
        cut(air, forward, h, mu, std::min<int>(steps, max_steps), ray);
        sun_rows.fill(tables, ray, zenith);
        cut(air, forward, h, mu, std::min<int>(field_steps, max_steps), coarse);
        field_rows.fill(field, coarse, air.top_km, r, mu);
        for (std::size_t k = 0; k < view_azimuths; ++k) {
            const double azimuth = pi * (static_cast<double>(k) + 0.5) / static_cast<double>(view_azimuths);
            nu[k] = std::clamp(mu * mu_s + sine * sine_s * static_cast<float>(std::cos(azimuth)), -1.0F, 1.0F);
        }
        march_field(coarse.steps.data(), coarse.count, field_rows.rows.data(), static_cast<std::size_t>(field.bands),
                    static_cast<float>(r), mu, suns.data(), nu.data(), again);
        if (ray.ground) {
            for (std::size_t k = 0; k < view_azimuths; ++k) {
                const float local = std::clamp((base[k] + static_cast<float>(ray.length_km) * nu[k]) /
                                                   static_cast<float>(air.ground_radius_km),
                                               -1.0F, 1.0F);
                const glm::vec3 lux = tables.ground_illuminance_lux(local);
                for (int c = 0; c < 3; ++c) {
                    again[c][k] += static_cast<float>(air.ground_albedo[c] / pi * ray.end_transmittance[c] /
                                                      std::max(air.sun_lux[c], 1e-30)) *
                                   lux[c];
                }
            }
        }
        float* to_row = values_.data() + static_cast<std::size_t>(row) * sky_view_values * columns;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto lux = static_cast<float>(air.sun_lux[static_cast<int>(c)]);
            for (std::size_t j = 0; j < columns; ++j) {
                float sum = 0.0F;
                for (std::size_t n = 0; n < view_azimuths; ++n) {
                    sum += again[c][n] * spread[n * columns + j];
                }
                to_row[(9 + c) * columns + j] = sum * lux;
            }
        }
        for (std::size_t j0 = 0; j0 < columns; j0 += march_lanes) {
            for (std::size_t k = 0; k < march_lanes; ++k) {
                nu[k] = std::clamp(mu * mu_s + sine * sine_s * cosines[j0 + k], -1.0F, 1.0F);
            }
            march_single(shell, ray.steps.data(), ray.count, sun_rows.rows.data(), base.data(), nu.data(), single);
            for (std::size_t k = 0; k < march_lanes && j0 + k < columns; ++k) {
                float* to = to_row + j0 + k;
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto lux = static_cast<float>(air.sun_lux[static_cast<int>(c)]);
                    to[c * columns] = single[0][c][k] * lux;
                    // What goes straight on is in the ray already.
                    to[(3 + c) * columns] = (single[1][c][k] - shell.forward * single[2][c][k]) * lux;
                    to[(6 + c) * columns] = single[2][c][k] * lux;
                }
            }
        }
    }
}

void AerialTable::build(const ScatteringTables& tables, float height_km, float mu_s) {
    const ScatteringAtmosphere& air = tables.air();
    const double h = std::clamp(static_cast<double>(height_km), 1e-3, air.top_km);
    const double r = air.ground_radius_km + h;
    const double zenith = std::acos(std::clamp(static_cast<double>(mu_s), -1.0, 1.0));
    const ScatteredField<float>& zone = tables.field().at(zenith);
    const double forward = zone.forward;
    const ShellKernel shell = shell_of(air, forward);
    mie_g_ = static_cast<float>(air.mie_g);
    mie_mean_cosine_ = static_cast<float>(zone.phase_bands[1]);
    const auto rows = static_cast<std::size_t>(rows_);
    const auto columns = static_cast<std::size_t>(columns_);
    const auto slices = static_cast<std::size_t>(slices_);
    light_.assign(slices * rows * 4 * columns, glm::vec3(0.0F));
    extinction_.assign(slices * rows, glm::vec3(0.0F));
    const FieldWindow field = make_window(zone, zenith, 1.5 * degree_rad);
    const std::vector<float> spread = azimuth_spread(columns);
    std::vector<float> cosines((columns + march_lanes - 1) / march_lanes * march_lanes, -1.0F);
    for (std::size_t j = 0; j < columns; ++j) {
        cosines[j] = static_cast<float>(std::cos(pi * static_cast<double>(j) / static_cast<double>(columns - 1)));
    }
    const float sine_s = std::sqrt(std::max(1.0F - mu_s * mu_s, 0.0F));
    std::array<float, march_lanes> suns{};
    suns.fill(mu_s);
    std::array<float, march_lanes> base{};
    base.fill(static_cast<float>(r) * mu_s);
    std::array<float, march_lanes> nu{};
    const glm::vec3 lux(air.sun_lux);
    // The scattered light's source changes little on the way: known at three places, by their distances' roots.
    constexpr std::array<double, 3> places{0.0, 0.5, 1.0};
    Ray ray;
    Ray sparse;
    SunRows sun_rows;
    FieldRows field_rows;
    std::vector<glm::vec3> source(places.size() * columns);
    std::vector<glm::vec3> sums(4 * columns);
    float single[3][3][march_lanes];
    float again[3][march_lanes];
    const auto step_at = [&](double distance, double mu, Ray& to) {
        const double squared = distance * (distance + 2.0 * r * mu);
        const double radius = std::sqrt(r * r + squared);
        MarchStep& step = to.steps[to.count];
        step.distance_km = static_cast<float>(distance);
        step.inverse_r = static_cast<float>(1.0 / radius);
        const double height = std::clamp(h + squared / (radius + r), 0.0, air.top_km);
        const double horizon = mu_horizon(air, height);
        step.mu_horizon = static_cast<float>(horizon);
        step.inverse_sine = static_cast<float>(1.0 / std::sqrt(1.0 - horizon * horizon));
        to.angles_rad[to.count] =
            std::asin(std::clamp(distance * std::sqrt(std::max(1.0 - mu * mu, 0.0)) / radius, -1.0, 1.0));
        to.heights_km[to.count++] = height;
        return sample_air(air, height);
    };
    for (std::size_t row = 0; row < rows; ++row) {
        const double root = 2.0 * static_cast<double>(row) / static_cast<double>(rows - 1) - 1.0;
        const double mu = root * std::abs(root);
        const auto z = static_cast<float>(mu);
        const float sine = std::sqrt(std::max(1.0F - z * z, 0.0F));
        // The scattered light's source is known as far as the air reaches. Slices go on into the ground, in air as at
        // its surface, so that the last distance before it lies between two good ones.
        const RaySpan span = ray_span(air, h, mu);
        const auto reach = static_cast<double>(reach_km_);
        const double end = std::min(reach, span.end_km);
        const double slices_end = span.ground ? reach : end;
        sparse.count = 0;
        for (const double place : places) {
            const AirSample sample = step_at(end * place * place, mu, sparse);
            MarchStep& step = sparse.steps[sparse.count - 1];
            for (int c = 0; c < 3; ++c) {
                step.rayleigh[c] = static_cast<float>(sample.rayleigh[c]);
                step.mie[c] = static_cast<float>(sample.mie[c]);
            }
        }
        field_rows.fill(field, sparse, air.top_km, r, mu);
        for (std::size_t k = 0; k < view_azimuths; ++k) {
            const double azimuth = pi * (static_cast<double>(k) + 0.5) / static_cast<double>(view_azimuths);
            nu[k] = std::clamp(z * mu_s + sine * sine_s * static_cast<float>(std::cos(azimuth)), -1.0F, 1.0F);
        }
        for (std::size_t p = 0; p < places.size(); ++p) {
            march_field(sparse.steps.data() + p, 1, field_rows.rows.data() + p, static_cast<std::size_t>(field.bands),
                        static_cast<float>(r), z, suns.data(), nu.data(), again);
            // Per scattering, so that the air's thinning on the way stays exact.
            for (std::size_t c = 0; c < 3; ++c) {
                const float scattering = sparse.steps[p].rayleigh[c] + sparse.steps[p].mie[c];
                const float per = scattering > 1e-12F ? 1.0F / scattering : 0.0F;
                for (std::size_t j = 0; j < columns; ++j) {
                    float sum = 0.0F;
                    for (std::size_t n = 0; n < view_azimuths; ++n) {
                        sum += again[c][n] * spread[n * columns + j];
                    }
                    source[p * columns + j][static_cast<int>(c)] = std::max(sum, 0.0F) * per;
                }
            }
        }
        // One step from each slice to the next; the first slice has the limit at the viewer.
        glm::dvec3 through(1.0);
        std::array<glm::dvec3, max_steps> weights{};
        std::array<double, max_steps> far{};
        std::array<glm::dvec3, max_steps> left{};
        ray.count = 0;
        for (std::size_t k = 0; k < slices && k < max_steps; ++k) {
            const double t = static_cast<double>(k) / static_cast<double>(slices - 1);
            const double before = k > 0 ? static_cast<double>(k - 1) / static_cast<double>(slices - 1) : 0.0;
            const double near = std::min(reach * before * before, slices_end);
            far[k] = std::min(reach * t * t, slices_end);
            const double length = k > 0 ? far[k] - near : 0.0;
            const AirSample sample = step_at(k > 0 ? 0.5 * (near + far[k]) : 0.0, mu, ray);
            MarchStep& step = ray.steps[ray.count - 1];
            for (int c = 0; c < 3; ++c) {
                const double depth = (sample.extinction[c] - forward * sample.mie[c]) * length;
                const double weight =
                    k > 0 ? through[c] * length * (depth > 1e-4 ? (1.0 - std::exp(-depth)) / depth : 1.0 - 0.5 * depth)
                          : 1.0;
                step.rayleigh[c] = static_cast<float>(weight * sample.rayleigh[c]);
                step.mie[c] = static_cast<float>(weight * sample.mie[c]);
                weights[k][c] = weight * (sample.rayleigh[c] + sample.mie[c]);
                through[c] *= std::exp(-depth);
                left[k][c] = depth + (k > 0 ? left[k - 1][c] : 0.0);
            }
            const glm::dvec3 here = sample.extinction - forward * sample.mie;
            extinction_[k * rows + row] = glm::vec3(k > 0 && far[k] > 0.0 ? left[k] / far[k] : here);
        }
        sun_rows.fill(tables, ray, zenith);
        std::fill(sums.begin(), sums.end(), glm::vec3(0.0F));
        for (std::size_t k = 0; k < ray.count; ++k) {
            const double at =
                end > 0.0 ? std::min(std::sqrt(static_cast<double>(ray.steps[k].distance_km) / end), 1.0) : 0.0;
            // Lagrange's parabola through the three places.
            const auto a = static_cast<float>(2.0 * (at - 0.5) * (at - 1.0));
            const auto b = static_cast<float>(4.0 * at * (1.0 - at));
            const auto e = static_cast<float>(2.0 * at * (at - 0.5));
            const glm::vec3 weight(weights[k]);
            const float per_km = k > 0 ? static_cast<float>(1.0 / std::max(far[k], 1e-9)) : 1.0F;
            glm::vec3* to = light_.data() + (k * rows + row) * 4 * columns;
            for (std::size_t j0 = 0; j0 < columns; j0 += march_lanes) {
                for (std::size_t n = 0; n < march_lanes; ++n) {
                    nu[n] = std::clamp(z * mu_s + sine * sine_s * cosines[j0 + n], -1.0F, 1.0F);
                }
                march_single(shell, ray.steps.data() + k, 1, sun_rows.rows.data() + k, base.data(), nu.data(), single);
                for (std::size_t n = 0; n < march_lanes && j0 + n < columns; ++n) {
                    const std::size_t j = j0 + n;
                    glm::vec3 now[4];
                    for (int c = 0; c < 3; ++c) {
                        now[0][c] = single[0][c][n];
                        now[1][c] = single[1][c][n] - shell.forward * single[2][c][n];
                        now[2][c] = single[2][c][n];
                    }
                    now[3] = weight * glm::max(a * source[j] + b * source[columns + j] + e * source[2 * columns + j],
                                               glm::vec3(0.0F));
                    for (std::size_t term = 0; term < 4; ++term) {
                        glm::vec3& sum = sums[term * columns + j];
                        sum = k > 0 ? sum + now[term] : glm::vec3(0.0F);
                        to[term * columns + j] = lux * per_km * (k > 0 ? sum : now[term]);
                    }
                }
            }
        }
    }
}

// What the shaders read, compiled here: the functions of sky_view.glsl as members of something that fetches.
namespace {

struct ViewReader {
    const float* values;
    std::size_t columns;

    using vec3 = glm::vec3;
    [[nodiscard]] vec3 fetch(int column, int line) const {
        const float* at = values + static_cast<std::size_t>(line) * 3 * columns + static_cast<std::size_t>(column);
        return {at[0], at[columns], at[2 * columns]};
    }
    [[nodiscard]] vec3 light(float column, float row, float slice, int term) const {
        const auto split = [](float at, std::size_t count, float& part) {
            const std::size_t low = std::min(static_cast<std::size_t>(std::max(at, 0.0F)), count - 2);
            part = at - static_cast<float>(low);
            return low;
        };
        float u = 0.0F;
        float v = 0.0F;
        float w = 0.0F;
        const std::size_t j = split(column, columns, u);
        const std::size_t i = split(row, rows, v);
        const std::size_t k = split(slice, slices, w);
        const auto line = [&](std::size_t at_slice, std::size_t at_row) {
            const vec3* at = lights + ((at_slice * rows + at_row) * 4 + static_cast<std::size_t>(term)) * columns + j;
            return glm::mix(at[0], at[1], u);
        };
        return glm::mix(glm::mix(line(k, i), line(k, i + 1), v), glm::mix(line(k + 1, i), line(k + 1, i + 1), v), w);
    }
    [[nodiscard]] vec3 extinction_at(float row, float slice) const {
        const std::size_t i = std::min(static_cast<std::size_t>(std::max(row, 0.0F)), rows - 2);
        const std::size_t k = std::min(static_cast<std::size_t>(std::max(slice, 0.0F)), slices - 2);
        const float v = row - static_cast<float>(i);
        const vec3* at = extinction + k * rows + i;
        return glm::mix(glm::mix(at[0], at[1], v), glm::mix(at[rows], at[rows + 1], v), slice - static_cast<float>(k));
    }
    const vec3* lights = nullptr;
    const vec3* extinction = nullptr;
    std::size_t rows = 0, slices = 0;

    static float min(float a, float b) { return std::min(a, b); }
    static int min(int a, int b) { return std::min(a, b); }
    static float max(float a, float b) { return std::max(a, b); }
    static vec3 min(const vec3& a, const vec3& b) { return glm::min(a, b); }
    static vec3 max(const vec3& a, const vec3& b) { return glm::max(a, b); }
    static float clamp(float x, float low, float high) { return std::clamp(x, low, high); }
    static vec3 clamp(const vec3& x, const vec3& low, const vec3& high) { return glm::clamp(x, low, high); }
    static vec3 clamp(const vec3& x, float low, float high) { return glm::clamp(x, low, high); }
    static float exp(float x) { return std::exp(x); }
    static vec3 exp(const vec3& x) { return glm::exp(x); }
    static float sqrt(float x) { return std::sqrt(x); }
    static float acos(float x) { return std::acos(x); }
    static float abs(float x) { return std::abs(x); }
    static float dot(const vec3& a, const vec3& b) { return glm::dot(a, b); }
    static vec3 mix(const vec3& a, const vec3& b, float t) { return glm::mix(a, b, t); }
    static vec3 mix(const vec3& a, const vec3& b, const vec3& t) { return glm::mix(a, b, t); }
    static vec3 step(const vec3& a, const vec3& b) { return glm::step(a, b); }

#define ALPENGLOW_SKY_VIEW_FETCH(column, line) fetch(column, line)
#define ALPENGLOW_AERIAL_LIGHT(column, row, slice, term) light(column, row, slice, term)
#define ALPENGLOW_AERIAL_EXTINCTION(row, slice) extinction_at(row, slice)
#include "sky_view.glsl"
};

} // namespace

glm::vec3 SkyView::radiance(const glm::vec3& direction, const glm::vec3& to_sun) const {
    assert(!values_.empty());
    ViewReader reader{values_.data(), static_cast<std::size_t>(columns_)};
    return reader.alpenglow_sky_view({horizon_, mie_g_, mie_mean_cosine_, rows_, columns_}, direction, to_sun);
}

AerialPerspective AerialTable::evaluate(const glm::vec3& direction, float distance_km, const glm::vec3& to_sun) const {
    assert(!light_.empty());
    ViewReader reader{nullptr, static_cast<std::size_t>(columns_)};
    reader.lights = light_.data();
    reader.extinction = extinction_.data();
    reader.rows = static_cast<std::size_t>(rows_);
    reader.slices = static_cast<std::size_t>(slices_);
    const ViewReader::AlpenglowAerial got = reader.alpenglow_aerial_table(
        {reach_km_, mie_g_, mie_mean_cosine_, rows_, columns_, slices_}, direction, distance_km, to_sun);
    return {got.transmittance, got.in_scatter};
}

} // namespace alpenglow::sky
