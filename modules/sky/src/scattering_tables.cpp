#include <alpenglow/sky/scattering_tables.hpp>

#include "scattering_simd.hpp"
#include "unit_quadrature.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/phase.hpp>
#include <alpenglow/sky/sun_light.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

constexpr std::size_t max_steps = 128;
constexpr std::size_t sun_rows_per_height = 9;

double mu_horizon(const ScatteringAtmosphere& air, double height_km) {
    const double ratio = air.ground_radius_km / (air.ground_radius_km + std::max(height_km, 0.0));
    return -std::sqrt(std::max((1.0 - ratio) * (1.0 + ratio), 0.0));
}

// A ray cut into steps, with the table rows that its steps read.
struct Ray {
    std::array<MarchStep, max_steps> steps;
    std::array<double, max_steps> heights_km;
    std::size_t count = 0;
    glm::dvec3 end_transmittance{1.0};
    double length_km = 0.0;
    bool ground = false;
};

// Steps crowd where the air is dense: towards the lower end of the path, by a square law. Within a step the light of
// its middle is weighed by the exact integral of transmittance times scattering.
void cut(const ScatteringAtmosphere& air, double height_km, double mu, int steps, Ray& ray) {
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
        const glm::dvec3 depth = sample.extinction * step;
        MarchStep& out = ray.steps[ray.count];
        for (int c = 0; c < 3; ++c) {
            const double weight =
                ray.end_transmittance[c] * (depth[c] > 1e-12 ? -std::expm1(-depth[c]) / depth[c] : 1.0) * step;
            out.rayleigh[c] = static_cast<float>(weight * sample.rayleigh[c]);
            out.mie[c] = static_cast<float>(weight * sample.mie[c]);
        }
        ray.end_transmittance *= glm::exp(-depth);
        out.distance_km = static_cast<float>(middle);
        out.inverse_r = static_cast<float>(1.0 / radius);
        out.mu_horizon = static_cast<float>(mu_horizon(air, h));
        ray.heights_km[ray.count++] = h;
    }
}

// Rows of a table at any height: the mix of two neighbours, weighted by `weights` a row.
class RowMixer {
public:
    // values: [height][row][angle]; heights by the square law.
    RowMixer(std::span<const float> values, int heights, std::size_t rows, int angles, double top_km)
        : values_(values), heights_(heights), rows_(rows), angles_(static_cast<std::size_t>(angles)), top_km_(top_km) {}

    // Into out, the first `rows` rows; row k is multiplied by weights[k] (or not, if null).
    void mix(double height_km, std::size_t rows, const float* weights, float* out) const {
        const double at = std::sqrt(std::clamp(height_km / top_km_, 0.0, 1.0)) * (heights_ - 1);
        const int i = std::min(static_cast<int>(at), heights_ - 2);
        const auto t = static_cast<float>(at - i);
        const float* low = values_.data() + static_cast<std::size_t>(i) * rows_ * angles_;
        const float* high = low + rows_ * angles_;
        for (std::size_t k = 0; k < rows; ++k) {
            const float w = weights != nullptr ? weights[k] : 1.0F;
            const float a = (1.0F - t) * w;
            const float b = t * w;
            for (std::size_t j = 0; j < angles_; ++j) {
                out[k * angles_ + j] = a * low[k * angles_ + j] + b * high[k * angles_ + j];
            }
        }
    }

private:
    std::span<const float> values_;
    int heights_;
    std::size_t rows_, angles_;
    double top_km_;
};

AngleRow angle_row(const float* values, int angles, float low, float high) {
    return {values, static_cast<std::size_t>(angles), low, static_cast<float>(angles - 1) / (high - low),
            static_cast<float>(angles - 1) - 1e-3F};
}

// The sun rows of a ray's steps.
struct SunRows {
    std::vector<float> storage;
    std::array<AngleRow, max_steps> rows;

    // kinds: 1 the light, 2 with its aureole.
    void fill(const RowMixer& mixer, const Ray& ray, int angles, std::size_t kinds) {
        const std::size_t size = kinds * 3 * static_cast<std::size_t>(angles);
        storage.resize(max_steps * size);
        for (std::size_t i = 0; i < ray.count; ++i) {
            float* to = storage.data() + i * size;
            mixer.mix(ray.heights_km[i], kinds * 3, nullptr, to);
            rows[i] = angle_row(to, angles, sun_axis_low, sun_axis_high);
        }
    }
};

// The field rows of a ray's steps, weighted by scattering and by the phase functions' bands (Rayleigh's are 1, 0,
// 1/10). Molecules scatter the whole field, aerosol all but the aureoles, whose scattering is known in closed form.
struct FieldRows {
    std::vector<float> storage, aureoles;
    std::array<AngleRow, max_steps> rows;

    void fill(const RowMixer& smooth, const RowMixer& aureole, const Ray& ray, int angles,
              const std::array<double, 3>& mie_bands) {
        constexpr std::array<std::size_t, field_functions> band{0, 1, 1, 2, 2, 2};
        constexpr std::array<float, 3> rayleigh_bands{1.0F, 0.0F, 0.1F};
        constexpr std::size_t count = static_cast<std::size_t>(field_functions) * 3;
        const std::size_t size = count * static_cast<std::size_t>(angles);
        storage.resize(max_steps * size);
        aureoles.resize(size);
        for (std::size_t i = 0; i < ray.count; ++i) {
            std::array<float, count> all{};
            std::array<float, count> molecules{};
            for (std::size_t k = 0; k < count; ++k) {
                const std::size_t l = band[k / 3];
                molecules[k] = ray.steps[i].rayleigh[k % 3] * rayleigh_bands[l];
                all[k] = molecules[k] + ray.steps[i].mie[k % 3] * static_cast<float>(mie_bands[l]);
            }
            float* to = storage.data() + i * size;
            smooth.mix(ray.heights_km[i], count, all.data(), to);
            aureole.mix(ray.heights_km[i], count, molecules.data(), aureoles.data());
            for (std::size_t j = 0; j < size; ++j) {
                to[j] += aureoles[j];
            }
            rows[i] = angle_row(to, angles, field_axis_low, field_axis_high);
        }
    }
};

// Bands of Cornette-Shanks: the integral of phase times P_l over the sphere; nodes crowd towards the peak.
std::array<double, 3> phase_bands(double g) {
    std::array<double, 3> out{};
    const UnitNodes nodes = unit_quadrature(64);
    for (std::size_t i = 0; i < nodes.x.size(); ++i) {
        const double t = nodes.x[i];
        const double c = std::copysign(1.0, g) * (1.0 - 2.0 * t * t);
        const double w = two_pi * 4.0 * t * nodes.w[i] * phase_cornette_shanks(c, g);
        out[0] += w;
        out[1] += w * c;
        out[2] += w * 0.5 * (3.0 * c * c - 1.0);
    }
    return {1.0, out[1] / out[0], out[2] / out[0]};
}

double field_angle(int j, int angles) {
    const double w = field_axis_low + (static_cast<double>(field_axis_high) - field_axis_low) * j / (angles - 1);
    return std::clamp(field_centre + w * std::abs(w), -1.0, 1.0);
}

double height_of(double top_km, int i, int heights) {
    const double t = static_cast<double>(i) / (heights - 1);
    return top_km * t * t;
}

} // namespace

ScatteringTables::ScatteringTables(const ScatteringAtmosphere& air, const ScatteringResolution& resolution)
    : air_(air), resolution_(resolution) {
    assert(resolution.sun_heights >= 2 && resolution.sun_angles >= 2 && resolution.field_heights >= 2);
    assert(resolution.field_angles % static_cast<int>(march_lanes) == 0);
    build_sun();
    build_field();
}

void ScatteringTables::build_sun() {
    const int heights = resolution_.sun_heights;
    const int angles = resolution_.sun_angles;
    const auto stride = static_cast<std::size_t>(angles);
    sun_.resize(static_cast<std::size_t>(heights) * sun_rows_per_height * stride);
    ShellKernel shell{};
    shell.radius_km = static_cast<float>(air_.ground_radius_km);
    shell.top_km = static_cast<float>(air_.top_km);
    shell.rayleigh_height_km = static_cast<float>(air_.rayleigh_height_km);
    shell.mie_height_km = static_cast<float>(air_.mie_height_km);
    for (int c = 0; c < 3; ++c) {
        shell.rayleigh[c] = static_cast<float>(air_.rayleigh_per_km[c]);
        shell.mie[c] = static_cast<float>(air_.mie_scattering_per_km[c] + air_.mie_absorption_per_km[c]);
        shell.ozone[c] = static_cast<float>(air_.ozone_per_km[c]);
        shell.mie_scattering[c] = static_cast<float>(air_.mie_scattering_per_km[c]);
    }
    std::array<float, march_lanes> mu{};
    std::array<float, march_lanes> visible{};
    float out[9][march_lanes];
    for (int i = 0; i < heights; ++i) {
        const double h = height_of(air_.top_km, i, heights);
        const double horizon = mu_horizon(air_, h);
        const double dip = std::asin(-horizon);
        for (std::size_t j0 = 0; j0 < stride; j0 += march_lanes) {
            for (std::size_t k = 0; k < march_lanes; ++k) {
                const double w = sun_axis_low + (static_cast<double>(sun_axis_high) - sun_axis_low) *
                                                    static_cast<double>(j0 + k) / (angles - 1);
                const double mu_s = std::clamp(horizon + w * std::abs(w), -1.0, 1.0);
                // The disc is small: only near the horizon does its visible part need more than 1 or 0.
                const bool near = std::abs(mu_s - horizon) < 0.02;
                visible[k] =
                    near ? static_cast<float>(visible_disc_fraction(std::asin(mu_s) + dip, air_.sun_angular_radius_rad))
                    : mu_s > horizon ? 1.0F
                                     : 0.0F;
                mu[k] = static_cast<float>(std::max(mu_s, horizon));
            }
            shell_transmittance(shell, static_cast<float>(h), mu.data(), out);
            for (std::size_t c = 0; c < sun_rows_per_height; ++c) {
                for (std::size_t k = 0; k < march_lanes && j0 + k < stride; ++k) {
                    sun_[(static_cast<std::size_t>(i) * sun_rows_per_height + c) * stride + j0 + k] =
                        out[c][k] * visible[k];
                }
            }
        }
    }
}

void ScatteringTables::build_field() {
    const int heights = resolution_.field_heights;
    const int angles = resolution_.field_angles;
    const auto stride = static_cast<std::size_t>(angles);
    const std::size_t rows = static_cast<std::size_t>(field_functions) * 3;
    std::vector<float> first(static_cast<std::size_t>(heights) * rows * stride, 0.0F);
    std::vector<float> first_ground(3 * stride, 0.0F);
    const RowMixer sun(sun_, resolution_.sun_heights, sun_rows_per_height, resolution_.sun_angles, air_.top_km);
    const std::array<double, 3> mie_bands = phase_bands(air_.mie_g);
    const auto g = static_cast<float>(air_.mie_g);
    const auto mean = static_cast<float>(mie_bands[1]);
    aureole_.assign(first.size(), 0.0F);
    const RowMixer aureole_mixer(aureole_, heights, rows, angles, air_.top_km);

    // Directions: half of the nodes above the horizon and half below it, azimuths over half the circle.
    const int half = resolution_.field_zeniths / 2;
    const UnitNodes zeniths = unit_quadrature(half);
    const int azimuths = resolution_.field_azimuths;
    std::vector<float> mu_s(stride);
    std::vector<float> sine_s(stride);
    for (int j = 0; j < angles; ++j) {
        const double m = field_angle(j, angles);
        mu_s[static_cast<std::size_t>(j)] = static_cast<float>(m);
        sine_s[static_cast<std::size_t>(j)] = static_cast<float>(std::sqrt(std::max(1.0 - m * m, 0.0)));
    }
    // The ground's direct light on the field's angles, for rays that end there.
    for (int j = 0; j < angles; ++j) {
        const float m = mu_s[static_cast<std::size_t>(j)];
        const glm::vec3 light = sun_transmittance(0.0F, m) * std::max(m, 0.0F);
        for (int c = 0; c < 3; ++c) {
            first_ground[static_cast<std::size_t>(c) * stride + static_cast<std::size_t>(j)] = light[c];
        }
    }

    Ray ray;
    SunRows sun_rows;
    FieldRows field_rows;
    std::array<float, march_lanes> nu{};
    std::array<float, march_lanes> base{};
    float single[3][3][march_lanes];
    float again[3][march_lanes];
    std::vector<float> peak(6 * stride);

    // One order: gathers light from all directions at every point. `source` null: the sun's, else the field of the
    // order before; `source_ground`: what the ground receives. Adds to `field` and to `ground` (downward light at
    // height 0).
    const auto gather = [&](const std::vector<float>* source, const std::vector<float>& source_ground,
                            std::vector<float>& field, std::vector<float>& ground) {
        std::optional<RowMixer> smooth;
        if (source != nullptr) {
            smooth.emplace(*source, heights, rows, angles, air_.top_km);
        }
        const AngleRow ground_row = angle_row(source_ground.data(), angles, field_axis_low, field_axis_high);
        for (int i = 0; i < heights; ++i) {
            const double h = std::max(height_of(air_.top_km, i, heights), i == 0 ? 1e-3 : 0.0);
            const double r = air_.ground_radius_km + h;
            const double horizon = mu_horizon(air_, h);
            if (source == nullptr) {
                // The aureole is too sharp for these few directions: what single scattering would be if it were all
                // around as it is towards the sun is known in closed form, and only the rest is gathered.
                for (std::size_t j = 0; j < stride; ++j) {
                    const float m = mu_s[j];
                    const float q = sine_s[j];
                    const std::array<float, field_functions> y{
                        0.2820947918F,         0.4886025119F * m,
                        0.4886025119F * q,     0.3153915653F * (3.0F * m * m - 1.0F),
                        1.0925484306F * m * q, 0.5462742153F * q * q};
                    // Scattered once, and twice: the second is wide enough for the bands of the field.
                    for (std::size_t n = 0; n < 2; ++n) {
                        const glm::vec3 light = sun_row(static_cast<float>(h), m, n == 0 ? 1 : 2);
                        std::vector<float>& to = n == 0 ? aureole_ : field;
                        const float power = n == 0 ? mean : mean * mean;
                        const std::array<float, 3> bands{1.0F, power,
                                                         n == 0 ? static_cast<float>(mie_bands[2]) : power * power};
                        for (std::size_t c = 0; c < 3; ++c) {
                            const float amount = light[static_cast<int>(c)];
                            peak[(3 * n + c) * stride + j] = amount;
                            for (std::size_t f = 0; f < static_cast<std::size_t>(field_functions); ++f) {
                                const std::size_t l = f == 0 ? 0 : f < 3 ? 1 : 2;
                                to[((static_cast<std::size_t>(i) * field_functions + f) * 3 + c) * stride + j] +=
                                    amount * bands[l] * y[f];
                            }
                            if (i == 0) { // its irradiance, by the first bands of the clamped cosine
                                ground[c * stride + j] +=
                                    amount *
                                    std::max(0.25F + 0.5F * bands[1] * m + 0.15625F * bands[2] * (3.0F * m * m - 1.0F),
                                             0.0F);
                            }
                        }
                    }
                }
            }
            for (int a = 0; a < 2 * half; ++a) {
                // Crowded towards the horizon from both sides.
                const double t = zeniths.x[static_cast<std::size_t>(a % half)];
                const bool up = a < half;
                const double room = up ? 1.0 - horizon : 1.0 + horizon;
                const double mu = up ? horizon + room * t * t : horizon - room * t * t;
                const double weight = zeniths.w[static_cast<std::size_t>(a % half)] * 2.0 * t * room;
                const double sine = std::sqrt(std::max(1.0 - mu * mu, 0.0));
                cut(air_, h, mu, resolution_.field_steps, ray);
                if (source == nullptr) {
                    sun_rows.fill(sun, ray, resolution_.sun_angles, 2);
                } else {
                    field_rows.fill(*smooth, aureole_mixer, ray, angles, mie_bands);
                    for (std::size_t s = 0; s < ray.count; ++s) {
                        ray.steps[s].mu_horizon = field_centre;
                    }
                }
                for (int b = 0; b < azimuths; ++b) {
                    const double azimuth = pi * (b + 0.5) / azimuths;
                    const auto x = static_cast<float>(sine * std::cos(azimuth));
                    const auto z = static_cast<float>(mu);
                    const auto w = static_cast<float>(weight * two_pi / azimuths);
                    // For m > 0 the mirrored half adds the same: cos(m phi) is even.
                    const std::array<float, field_functions> y{
                        0.2820947918F,         0.4886025119F * z,
                        0.4886025119F * x,     0.3153915653F * (3.0F * z * z - 1.0F),
                        1.0925484306F * z * x, 0.5462742153F * (2.0F * x * x + z * z - 1.0F)};
                    for (std::size_t j0 = 0; j0 < stride; j0 += march_lanes) {
                        for (std::size_t k = 0; k < march_lanes; ++k) {
                            nu[k] = std::clamp(z * mu_s[j0 + k] + x * sine_s[j0 + k], -1.0F, 1.0F);
                            base[k] = static_cast<float>(r) * mu_s[j0 + k];
                        }
                        if (source == nullptr) {
                            march_single(ray.steps.data(), ray.count, sun_rows.rows.data(), 2, base.data(), nu.data(),
                                         single);
                            for (std::size_t k = 0; k < march_lanes; ++k) {
                                const float pr = phase_rayleigh(nu[k]);
                                const float pm = phase_cornette_shanks(nu[k], g);
                                const float twice = phase_henyey_greenstein(nu[k], mean * mean);
                                for (std::size_t c = 0; c < 3; ++c) {
                                    const float* at = &peak[c * stride + j0 + k];
                                    again[c][k] = pr * single[0][c][k] + pm * (single[1][c][k] - at[0]) +
                                                  twice * (single[2][c][k] - at[3 * stride]);
                                }
                            }
                        } else {
                            march_field(ray.steps.data(), ray.count, field_rows.rows.data(), field_functions,
                                        static_cast<float>(r), z, mu_s.data() + j0, nu.data(), again);
                        }
                        if (ray.ground) {
                            for (std::size_t k = 0; k < march_lanes; ++k) {
                                const float local = std::clamp((base[k] + static_cast<float>(ray.length_km) * nu[k]) /
                                                                   static_cast<float>(air_.ground_radius_km),
                                                               -1.0F, 1.0F);
                                const float d = local - field_centre;
                                const float at = std::clamp(
                                    (std::copysign(std::sqrt(std::abs(d)), d) - ground_row.low) * ground_row.scale,
                                    0.0F, ground_row.last);
                                const auto cell = static_cast<std::size_t>(at);
                                const float part = at - static_cast<float>(cell);
                                for (std::size_t c = 0; c < 3; ++c) {
                                    const float* row = ground_row.values + c * stride + cell;
                                    const auto albedo =
                                        static_cast<float>(air_.ground_albedo[static_cast<int>(c)] / pi *
                                                           ray.end_transmittance[static_cast<int>(c)]);
                                    again[c][k] += albedo * (row[0] + part * (row[1] - row[0]));
                                }
                            }
                        }
                        for (std::size_t c = 0; c < 3; ++c) {
                            for (std::size_t f = 0; f < static_cast<std::size_t>(field_functions); ++f) {
                                float* to = field.data() +
                                            ((static_cast<std::size_t>(i) * field_functions + f) * 3 + c) * stride + j0;
                                const float wy = w * y[f];
                                for (std::size_t k = 0; k < march_lanes; ++k) {
                                    to[k] += wy * again[c][k];
                                }
                            }
                            if (i == 0 && up) {
                                float* to = ground.data() + c * stride + j0;
                                for (std::size_t k = 0; k < march_lanes; ++k) {
                                    to[k] += w * z * again[c][k];
                                }
                            }
                        }
                    }
                }
            }
        }
    };

    std::vector<float> sky_on_ground(3 * stride, 0.0F);
    gather(nullptr, first_ground, first, sky_on_ground);
    // The second order in full, and the rest of the series from the ratio of its mean to that of the first.
    std::vector<float> second(first.size(), 0.0F);
    std::vector<float> second_ground(3 * stride, 0.0F);
    gather(&first, sky_on_ground, second, second_ground);
    field_ = first;
    for (std::size_t k = 0; k < field_.size(); ++k) {
        field_[k] += second[k];
    }
    ground_.resize(3 * stride);
    for (std::size_t k = 0; k < ground_.size(); ++k) {
        ground_[k] = first_ground[k] + sky_on_ground[k] + second_ground[k];
    }
    add_higher_orders(second, second_ground);
}

// Orders three and up hardly move sideways: they obey x = K (x_2 + x), where K couples the heights, the bands and (for
// m = 0) the ground. It keeps m apart and is the same for every sun angle.
void ScatteringTables::add_higher_orders(const std::vector<float>& second, const std::vector<float>& second_ground) {
    const auto heights = static_cast<std::size_t>(resolution_.field_heights);
    const auto stride = static_cast<std::size_t>(resolution_.field_angles);
    const int half = resolution_.field_zeniths / 2;
    const UnitNodes zeniths = unit_quadrature(half);
    const std::array<double, 3> mie_bands = phase_bands(air_.mie_g);
    constexpr std::array<double, 3> rayleigh_bands{1.0, 0.0, 0.1};
    constexpr std::array<std::array<std::size_t, 3>, 3> function{{{0, 1, 3}, {0, 2, 4}, {0, 0, 5}}}; // [m][l]
    // Y_l^m without its azimuth, for l = m .. 2.
    const auto shape = [](std::size_t m, double z) {
        const double s2 = std::max(1.0 - z * z, 0.0);
        const double s1 = std::sqrt(s2);
        return m == 0   ? std::array<double, 3>{0.2820947918, 0.4886025119 * z, 0.3153915653 * (3.0 * z * z - 1.0)}
               : m == 1 ? std::array<double, 3>{0.0, 0.4886025119 * s1, 1.0925484306 * z * s1}
                        : std::array<double, 3>{0.0, 0.0, 0.5462742153 * s2};
    };
    const auto size = [&](std::size_t m) { return heights * (3 - m) + (m == 0 ? 1 : 0); };
    const auto at = [&](std::size_t m, std::size_t i, std::size_t l) { return i * (3 - m) + l - m; };
    std::array<std::array<std::vector<double>, 3>, 3> k; // [m][channel]
    for (std::size_t m = 0; m < 3; ++m) {
        for (auto& matrix : k[m]) {
            matrix.assign(size(m) * size(m), 0.0);
        }
    }
    Ray ray;
    for (std::size_t i = 0; i < heights; ++i) {
        const double h =
            std::max(height_of(air_.top_km, static_cast<int>(i), static_cast<int>(heights)), i == 0 ? 1e-3 : 0.0);
        const double r = air_.ground_radius_km + h;
        const double horizon = mu_horizon(air_, h);
        for (int a = 0; a < 2 * half; ++a) {
            const double t = zeniths.x[static_cast<std::size_t>(a % half)];
            const bool up = a < half;
            const double room = up ? 1.0 - horizon : 1.0 + horizon;
            const double mu = up ? horizon + room * t * t : horizon - room * t * t;
            const double weight = zeniths.w[static_cast<std::size_t>(a % half)] * 2.0 * t * room;
            cut(air_, h, mu, resolution_.field_steps, ray);
            for (std::size_t m = 0; m < 3; ++m) {
                const std::size_t n = size(m);
                const std::array<double, 3> here = shape(m, mu);
                const double around = weight * (m == 0 ? two_pi : pi);
                for (std::size_t s = 0; s < ray.count; ++s) {
                    const MarchStep& step = ray.steps[s];
                    const double place = std::sqrt(std::clamp(ray.heights_km[s] / air_.top_km, 0.0, 1.0)) *
                                         static_cast<double>(heights - 1);
                    const std::size_t low = std::min(static_cast<std::size_t>(place), heights - 2);
                    const double part = place - static_cast<double>(low);
                    const std::array<double, 3> there = shape(m, (r * mu + static_cast<double>(step.distance_km)) *
                                                                     static_cast<double>(step.inverse_r));
                    for (std::size_t c = 0; c < 3; ++c) {
                        for (std::size_t l = m; l < 3; ++l) {
                            const double source =
                                there[l] * (static_cast<double>(step.rayleigh[c]) * rayleigh_bands[l] +
                                            static_cast<double>(step.mie[c]) * mie_bands[l]);
                            const std::array<double, 2> share{source * (1.0 - part), source * part};
                            for (std::size_t e = 0; e < 2; ++e) {
                                const std::size_t column = at(m, low + e, l);
                                for (std::size_t to = m; to < 3; ++to) {
                                    k[m][c][at(m, i, to) * n + column] += around * here[to] * share[e];
                                }
                                if (m == 0 && i == 0 && up) {
                                    k[m][c][(n - 1) * n + column] += around * mu * share[e];
                                }
                            }
                        }
                    }
                }
                if (m == 0 && ray.ground) {
                    for (std::size_t c = 0; c < 3; ++c) {
                        const int channel = static_cast<int>(c);
                        for (std::size_t to = 0; to < 3; ++to) {
                            k[m][c][at(m, i, to) * n + n - 1] +=
                                around * here[to] * air_.ground_albedo[channel] / pi * ray.end_transmittance[channel];
                        }
                    }
                }
            }
        }
    }
    for (std::size_t m = 0; m < 3; ++m) {
        const std::size_t n = size(m);
        const std::size_t width = n + stride;
        for (std::size_t c = 0; c < 3; ++c) {
            // (I - K) x = K x_2 for all sun angles at once. K is a contraction: elimination needs no pivoting.
            std::vector<double> x2(n * stride);
            for (std::size_t i = 0; i < heights; ++i) {
                for (std::size_t l = m; l < 3; ++l) {
                    const float* from = second.data() + ((i * field_functions + function[m][l]) * 3 + c) * stride;
                    std::copy_n(from, stride, x2.data() + at(m, i, l) * stride);
                }
            }
            if (m == 0) {
                std::copy_n(second_ground.data() + c * stride, stride, x2.data() + (n - 1) * stride);
            }
            std::vector<double> a(n * width, 0.0);
            for (std::size_t i = 0; i < n; ++i) {
                for (std::size_t j = 0; j < n; ++j) {
                    const double q = k[m][c][i * n + j];
                    a[i * width + j] = (i == j ? 1.0 : 0.0) - q;
                    for (std::size_t v = 0; v < stride; ++v) {
                        a[i * width + n + v] += q * x2[j * stride + v];
                    }
                }
            }
            for (std::size_t p = 0; p < n; ++p) {
                for (std::size_t i = p + 1; i < n; ++i) {
                    const double q = a[i * width + p] / a[p * width + p];
                    for (std::size_t j = p; q != 0.0 && j < width; ++j) {
                        a[i * width + j] -= q * a[p * width + j];
                    }
                }
            }
            for (std::size_t p = n; p-- > 0;) {
                for (std::size_t v = n; v < width; ++v) {
                    double sum = a[p * width + v];
                    for (std::size_t j = p + 1; j < n; ++j) {
                        sum -= a[p * width + j] * a[j * width + v];
                    }
                    a[p * width + v] = sum / a[p * width + p];
                }
            }
            for (std::size_t v = 0; v < stride; ++v) {
                for (std::size_t i = 0; i < heights; ++i) {
                    for (std::size_t l = m; l < 3; ++l) {
                        field_[((i * field_functions + function[m][l]) * 3 + c) * stride + v] +=
                            static_cast<float>(a[at(m, i, l) * width + n + v]);
                    }
                }
                if (m == 0) {
                    ground_[c * stride + v] += static_cast<float>(a[(n - 1) * width + n + v]);
                }
            }
        }
    }
}

glm::vec3 ScatteringTables::sun_transmittance(float height_km, float mu_s) const {
    return sun_row(height_km, mu_s, 0);
}

glm::vec3 ScatteringTables::sun_row(float height_km, float mu_s, int kind) const {
    const int heights = resolution_.sun_heights;
    const auto stride = static_cast<std::size_t>(resolution_.sun_angles);
    const double h = std::clamp(static_cast<double>(height_km), 0.0, air_.top_km);
    const double at = std::sqrt(h / air_.top_km) * (heights - 1);
    const int i = std::min(static_cast<int>(at), heights - 2);
    const auto t = static_cast<float>(at - i);
    const auto x = static_cast<float>(static_cast<double>(mu_s) - mu_horizon(air_, h));
    const float w = std::copysign(std::sqrt(std::abs(x)), x);
    const float y =
        std::clamp((w - sun_axis_low) / (sun_axis_high - sun_axis_low), 0.0F, 1.0F) * static_cast<float>(stride - 1);
    const auto j = std::min(static_cast<std::size_t>(y), stride - 2);
    const float u = y - static_cast<float>(j);
    glm::vec3 out;
    for (std::size_t c = 0; c < 3; ++c) {
        const float* low =
            sun_.data() +
            (static_cast<std::size_t>(i) * sun_rows_per_height + static_cast<std::size_t>(3 * kind) + c) * stride + j;
        const float* high = low + sun_rows_per_height * stride;
        out[static_cast<int>(c)] =
            (1.0F - t) * (low[0] + u * (low[1] - low[0])) + t * (high[0] + u * (high[1] - high[0]));
    }
    return out;
}

glm::vec3 ScatteringTables::ground_illuminance_lux(float mu_s) const {
    const auto stride = static_cast<std::size_t>(resolution_.field_angles);
    const float d = mu_s - field_centre;
    const float w = std::copysign(std::sqrt(std::abs(d)), d);
    const float y = std::clamp((w - field_axis_low) / (field_axis_high - field_axis_low), 0.0F, 1.0F) *
                    static_cast<float>(stride - 1);
    const auto j = std::min(static_cast<std::size_t>(y), stride - 2);
    const float u = y - static_cast<float>(j);
    glm::vec3 out;
    for (std::size_t c = 0; c < 3; ++c) {
        const float* row = ground_.data() + c * stride + j;
        out[static_cast<int>(c)] =
            (row[0] + u * (row[1] - row[0])) * static_cast<float>(air_.sun_lux[static_cast<int>(c)]);
    }
    return out;
}

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
    const ScatteringResolution& size = tables.resolution();
    const double h = std::clamp(static_cast<double>(height_km), 1e-3, air.top_km);
    const double r = air.ground_radius_km + h;
    const std::array<double, 3> mie_bands = phase_bands(air.mie_g);
    horizon_ = static_cast<float>(mu_horizon(air, h));
    mie_g_ = static_cast<float>(air.mie_g);
    mie_mean_cosine_ = static_cast<float>(mie_bands[1]);
    const std::size_t columns = static_cast<std::size_t>(columns_);
    values_.assign(static_cast<std::size_t>(rows_) * sky_view_values * columns, 0.0F);
    const RowMixer sun(tables.sun(), size.sun_heights, sun_rows_per_height, size.sun_angles, air.top_km);
    const RowMixer field(tables.field(), size.field_heights, static_cast<std::size_t>(field_functions) * 3,
                         size.field_angles, air.top_km);
    const RowMixer aureole(tables.aureole(), size.field_heights, static_cast<std::size_t>(field_functions) * 3,
                           size.field_angles, air.top_km);
    Ray ray;
    SunRows sun_rows;
    FieldRows field_rows;
    std::array<float, march_lanes> nu{};
    std::array<float, march_lanes> base{};
    std::array<float, march_lanes> suns{};
    float single[3][3][march_lanes];
    float again[3][march_lanes];
    const float sine_s = std::sqrt(std::max(1.0F - mu_s * mu_s, 0.0F));
    suns.fill(mu_s);
    base.fill(static_cast<float>(r) * mu_s);
    for (int row = 0; row < rows_; ++row) {
        const float mu = cosine_of(static_cast<float>(row));
        const float sine = std::sqrt(std::max(1.0F - mu * mu, 0.0F));
        cut(air, h, mu, std::min<int>(steps, max_steps), ray);
        sun_rows.fill(sun, ray, size.sun_angles, 2);
        field_rows.fill(field, aureole, ray, size.field_angles, mie_bands);
        Ray again_ray = ray;
        for (std::size_t s = 0; s < ray.count; ++s) {
            again_ray.steps[s].mu_horizon = field_centre;
        }
        for (std::size_t j0 = 0; j0 < columns; j0 += march_lanes) {
            for (std::size_t k = 0; k < march_lanes; ++k) {
                const double azimuth = pi * std::min<double>(static_cast<double>(j0 + k) / (columns_ - 1), 1.0);
                nu[k] = std::clamp(mu * mu_s + sine * sine_s * static_cast<float>(std::cos(azimuth)), -1.0F, 1.0F);
            }
            march_single(ray.steps.data(), ray.count, sun_rows.rows.data(), 2, base.data(), nu.data(), single);
            march_field(again_ray.steps.data(), ray.count, field_rows.rows.data(), field_functions,
                        static_cast<float>(r), mu, suns.data(), nu.data(), again);
            for (std::size_t k = 0; k < march_lanes && j0 + k < columns; ++k) {
                if (ray.ground) {
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
                float* to = values_.data() + static_cast<std::size_t>(row) * sky_view_values * columns + j0 + k;
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto lux = static_cast<float>(air.sun_lux[static_cast<int>(c)]);
                    to[c * columns] = single[0][c][k] * lux;
                    to[(3 + c) * columns] = single[1][c][k] * lux;
                    to[(6 + c) * columns] = single[2][c][k] * lux;
                    to[(9 + c) * columns] = std::max(again[c][k], 0.0F) * lux;
                }
            }
        }
    }
}

glm::vec3 SkyView::radiance(const glm::vec3& direction, const glm::vec3& to_sun) const {
    assert(!values_.empty());
    const float mu = std::clamp(direction.z, -1.0F, 1.0F);
    const float nu = std::clamp(glm::dot(direction, to_sun), -1.0F, 1.0F);
    const float across = std::hypot(direction.x, direction.y) * std::hypot(to_sun.x, to_sun.y);
    const float cosine =
        across > 1e-12F ? std::clamp((direction.x * to_sun.x + direction.y * to_sun.y) / across, -1.0F, 1.0F) : 1.0F;
    const float x = std::acos(cosine) / static_cast<float>(pi) * static_cast<float>(columns_ - 1);
    const auto j = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(columns_ - 2));
    const float u = x - static_cast<float>(j);
    const float y = row_of(mu);
    const float half = 0.5F * static_cast<float>(rows_);
    const auto last = static_cast<std::size_t>(mu >= horizon_ ? half - 1.0F : static_cast<float>(rows_ - 1));
    const auto i = std::min(static_cast<std::size_t>(y), last);
    const auto next = std::min(i + 1, last);
    const float v = y - static_cast<float>(i);
    const std::size_t columns = static_cast<std::size_t>(columns_);
    const auto at = [&](std::size_t k) {
        const float* low = values_.data() + (i * sky_view_values + k) * columns + j;
        const float* high = values_.data() + (next * sky_view_values + k) * columns + j;
        return (1.0F - v) * (low[0] + u * (low[1] - low[0])) + v * (high[0] + u * (high[1] - high[0]));
    };
    const float pr = phase_rayleigh(nu);
    const float pm = phase_cornette_shanks(nu, mie_g_);
    const float twice = phase_henyey_greenstein(nu, mie_mean_cosine_ * mie_mean_cosine_);
    glm::vec3 out;
    for (std::size_t c = 0; c < 3; ++c) {
        out[static_cast<int>(c)] = std::max(pr * at(c) + pm * at(3 + c) + twice * at(6 + c) + at(9 + c), 0.0F);
    }
    return out;
}

} // namespace alpenglow::sky
