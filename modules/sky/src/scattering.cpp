#include <alpenglow/sky/scattering.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/phase.hpp>
#include <alpenglow/sky/sun_light.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

constexpr std::array<double, 4> gauss_x{0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                        0.9305681557970263};
constexpr std::array<double, 4> gauss_w{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                        0.17392742256872693};

double height_at(const ScatteringAtmosphere& air, double height_km, double mu, double s) {
    const double r = air.ground_radius_km + height_km;
    const double squared = s * (s + 2.0 * r * mu); // r'^2 - r^2
    return height_km + squared / (std::sqrt(std::max(r * r + squared, 0.0)) + r);
}

// splitmix64: seeded, the same everywhere.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double operator()() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
        z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
        return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

// Sun's light on a grid fine enough for the path tracer: heights by a square law, mu_s by a signed square root.
class SunTable {
public:
    static constexpr int heights = 128;
    static constexpr int angles = 512;

    explicit SunTable(const ScatteringAtmosphere& air) : air_(air), values_(heights * angles) {
        for (int i = 0; i < heights; ++i) {
            const double t = static_cast<double>(i) / (heights - 1);
            for (int j = 0; j < angles; ++j) {
                const double w = -1.0 + 2.0 * j / (angles - 1);
                values_[static_cast<std::size_t>(i * angles + j)] =
                    sun_transmittance(air, air.top_km * t * t, w * std::abs(w), 24);
            }
        }
    }
    [[nodiscard]] glm::dvec3 operator()(double height_km, double mu_s) const {
        const double x = std::sqrt(std::clamp(height_km / air_.top_km, 0.0, 1.0)) * (heights - 1);
        const double y = (std::copysign(std::sqrt(std::min(std::abs(mu_s), 1.0)), mu_s) + 1.0) * 0.5 * (angles - 1);
        const int i = std::min(static_cast<int>(x), heights - 2);
        const int j = std::min(static_cast<int>(y), angles - 2);
        const double u = x - i;
        const double v = y - j;
        const glm::dvec3* at = &values_[static_cast<std::size_t>(i * angles + j)];
        return (1.0 - u) * ((1.0 - v) * at[0] + v * at[1]) + u * ((1.0 - v) * at[angles] + v * at[angles + 1]);
    }

private:
    const ScatteringAtmosphere& air_;
    std::vector<glm::dvec3> values_;
};

glm::dvec3 any_perpendicular(const glm::dvec3& v) {
    return glm::normalize(std::abs(v.x) < 0.7 ? glm::cross(v, glm::dvec3(1, 0, 0))
                                              : glm::cross(v, glm::dvec3(0, 1, 0)));
}

// A direction at an angle of cosine c around v.
glm::dvec3 around(const glm::dvec3& v, double c, double azimuth) {
    const glm::dvec3 a = any_perpendicular(v);
    const glm::dvec3 b = glm::cross(v, a);
    const double s = std::sqrt(std::max(1.0 - c * c, 0.0));
    return glm::normalize(v * c + (a * std::cos(azimuth) + b * std::sin(azimuth)) * s);
}

// Cosine sampled from Rayleigh's or Henyey-Greenstein's law.
double rayleigh_cosine(double u) {
    const double q = 4.0 * u - 2.0;
    const double root = std::sqrt(q * q + 1.0);
    return std::clamp(std::cbrt(q + root) + std::cbrt(q - root), -1.0, 1.0);
}
double henyey_greenstein_cosine(double u, double g) {
    if (std::abs(g) < 1e-3) {
        return 2.0 * u - 1.0;
    }
    const double k = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
    return std::clamp((1.0 + g * g - k * k) / (2.0 * g), -1.0, 1.0);
}

} // namespace

Result<ScatteringAtmosphere> make_scattering_atmosphere(double turbidity, double ozone_atm_cm,
                                                        const glm::dvec3& ground_albedo) {
    const auto wrong = [](const char* field, double v, const char* expected) {
        return Error{std::string(field) + " is " + std::to_string(v), "scattering atmosphere", expected};
    };
    if (!(turbidity >= 1.0 && turbidity <= 10.0)) {
        return wrong("turbidity", turbidity, "a number from 1 to 10");
    }
    if (!(ozone_atm_cm >= 0.0 && ozone_atm_cm <= 2.0)) {
        return wrong("ozone_atm_cm", ozone_atm_cm, "a number from 0 to 2");
    }
    for (int k = 0; k < 3; ++k) {
        if (!(ground_albedo[k] >= 0.0 && ground_albedo[k] <= 1.0)) {
            return wrong("ground_albedo", ground_albedo[k], "numbers from 0 to 1");
        }
    }
    ScatteringAtmosphere air;
    const double beta = std::max(0.04608365822050 * turbidity - 0.04586025928522, 0.0);
    const glm::dvec3 extinction = beta / air.mie_height_km * glm::dvec3(1.6510, 2.1753, 2.9074); // 0.68, 0.55, 0.44 um
    air.mie_scattering_per_km = 0.9 * extinction;
    air.mie_absorption_per_km = 0.1 * extinction;
    air.ozone_per_km *= ozone_atm_cm / 0.30;
    air.ground_albedo = ground_albedo;
    // The sun's colour outside the air.
    air.sun_lux = xyz_to_rec709(spectrum_to_xyz(sun_spectrum()));
    return air;
}

AirSample sample_air(const ScatteringAtmosphere& air, double height_km) {
    const double h = std::max(height_km, 0.0);
    AirSample s;
    s.rayleigh = air.rayleigh_per_km * std::exp(-h / air.rayleigh_height_km);
    const double aerosol = std::exp(-h / air.mie_height_km);
    s.mie = air.mie_scattering_per_km * aerosol;
    s.extinction = s.rayleigh + s.mie + air.mie_absorption_per_km * aerosol +
                   air.ozone_per_km * std::max(1.0 - std::abs(h - 25.0) / 15.0, 0.0);
    return s;
}

RaySpan ray_span(const ScatteringAtmosphere& air, double height_km, double mu) {
    const double r = air.ground_radius_km + std::max(height_km, 0.0);
    const double top = air.ground_radius_km + air.top_km;
    const double across = r * r * (1.0 - mu * mu); // closest approach, squared
    RaySpan span;
    const double to_top = top * top - across;
    if (to_top <= 0.0 || (r > top && mu > 0.0)) {
        return span;
    }
    span.begin_km = r > top ? -r * mu - std::sqrt(to_top) : 0.0;
    const double to_ground = air.ground_radius_km * air.ground_radius_km - across;
    if (mu < 0.0 && to_ground >= 0.0) {
        span.end_km = std::max(-r * mu - std::sqrt(to_ground), span.begin_km);
        span.ground = true;
    } else {
        span.end_km = std::max(-r * mu + std::sqrt(to_top), span.begin_km);
    }
    return span;
}

glm::dvec3 optical_depth(const ScatteringAtmosphere& air, double height_km, double mu, double begin_km, double end_km,
                         int steps) {
    const double r = air.ground_radius_km + height_km;
    // Intervals shrink towards the lowest point of the path, where the air is densest.
    const double lowest = std::clamp(-r * mu, begin_km, end_km);
    glm::dvec3 sum(0.0);
    for (const double side : {begin_km, end_km}) {
        const double length = side - lowest;
        if (length == 0.0) {
            continue;
        }
        for (int i = 0; i < steps; ++i) {
            for (std::size_t k = 0; k < 4; ++k) {
                const double t = (i + gauss_x[k]) / steps;
                sum += sample_air(air, height_at(air, height_km, mu, lowest + length * t * t)).extinction *
                       (gauss_w[k] * 2.0 * t * std::abs(length) / steps);
            }
        }
    }
    return sum;
}

glm::dvec3 sun_transmittance(const ScatteringAtmosphere& air, double height_km, double mu_s, int steps) {
    // The horizon's dip: the disc sets behind the Earth's limb.
    const double r = air.ground_radius_km + std::max(height_km, 0.0);
    const double dip = std::acos(std::min(air.ground_radius_km / r, 1.0));
    const double altitude = std::asin(std::clamp(mu_s, -1.0, 1.0));
    const double visible = visible_disc_fraction(altitude + dip, air.sun_angular_radius_rad);
    if (visible <= 0.0) {
        return glm::dvec3(0.0);
    }
    // Of the visible part: never through the ground.
    const double mu = std::max(mu_s, std::sin(-dip) + 1e-9);
    const RaySpan span = ray_span(air, height_km, mu);
    const double end =
        span.ground
            ? -r * mu + std::sqrt(std::max((air.ground_radius_km + air.top_km) * (air.ground_radius_km + air.top_km) -
                                               r * r * (1.0 - mu * mu),
                                           0.0))
            : span.end_km;
    return visible * glm::exp(-optical_depth(air, height_km, mu, span.begin_km, end, steps));
}

glm::dvec3 single_scattering(const ScatteringAtmosphere& air, double height_km, double mu, double mu_s, double nu,
                             int steps) {
    const RaySpan span = ray_span(air, height_km, mu);
    const double r = air.ground_radius_km + height_km;
    const double rayleigh_phase = phase_rayleigh(nu);
    const double mie_phase = phase_cornette_shanks(nu, air.mie_g);
    const double length = span.end_km - span.begin_km;
    glm::dvec3 transmittance(1.0);
    glm::dvec3 sum(0.0);
    for (int i = 0; i < steps; ++i) {
        const double t0 = static_cast<double>(i) / steps;
        const double t1 = static_cast<double>(i + 1) / steps;
        const double s0 = span.begin_km + length * t0 * t0;
        const double step = span.begin_km + length * t1 * t1 - s0;
        const double s = s0 + 0.5 * step;
        const double h = height_at(air, height_km, mu, s);
        const AirSample sample = sample_air(air, h);
        const glm::dvec3 depth = sample.extinction * step;
        const glm::dvec3 weight = transmittance *
                                  -glm::dvec3(std::expm1(-depth.x), std::expm1(-depth.y), std::expm1(-depth.z)) /
                                  glm::max(sample.extinction, glm::dvec3(1e-300));
        const double local = std::clamp((r * mu_s + s * nu) / (air.ground_radius_km + h), -1.0, 1.0);
        sum +=
            weight * (sample.rayleigh * rayleigh_phase + sample.mie * mie_phase) * sun_transmittance(air, h, local, 16);
        transmittance *= glm::exp(-depth);
    }
    if (span.ground) {
        const double local = std::clamp((r * mu_s + span.end_km * nu) / air.ground_radius_km, -1.0, 1.0);
        sum += transmittance * air.ground_albedo / pi * std::max(local, 0.0) * sun_transmittance(air, 0.0, local, 16);
    }
    return sum * air.sun_lux;
}

MonteCarlo trace_radiance(const ScatteringAtmosphere& air, double height_km, double mu, double mu_s, double azimuth_rad,
                          int paths, std::uint64_t seed, int least_order) {
    const SunTable sun_light(air);
    const glm::dvec3 sun(std::sqrt(std::max(1.0 - mu_s * mu_s, 0.0)), 0.0, mu_s);
    const double s = std::sqrt(std::max(1.0 - mu * mu, 0.0));
    const glm::dvec3 first(s * std::cos(azimuth_rad), s * std::sin(azimuth_rad), mu);
    MonteCarlo result;
    for (int channel = 0; channel < 3; ++channel) {
        Random random(seed * 3 + static_cast<std::uint64_t>(channel));
        double sum = 0.0;
        double squares = 0.0;
        for (int path = 0; path < paths; ++path) {
            glm::dvec3 position(0.0, 0.0, air.ground_radius_km + height_km);
            glm::dvec3 direction = first;
            double weight = 1.0;
            double light = 0.0;
            for (int order = 1; order <= 64 && weight > 1e-6; ++order) {
                const double r = glm::length(position);
                const double cosine = glm::dot(position, direction) / r;
                const RaySpan span = ray_span(air, r - air.ground_radius_km, cosine);
                if (span.end_km <= span.begin_km) {
                    break;
                }
                // Delta tracking; the densest air of the path bounds the rate piece by piece.
                double at = span.begin_km;
                bool scattered = false;
                double h = 0.0;
                while (at < span.end_km) {
                    const double h0 = height_at(air, r - air.ground_radius_km, cosine, at);
                    const double piece = std::min(at + 2.0 + 0.5 * h0 + 0.05 * (at - span.begin_km), span.end_km);
                    const double low = std::clamp(-r * cosine, at, piece);
                    const double h_low = std::max(height_at(air, r - air.ground_radius_km, cosine, low), 0.0);
                    const double most = sample_air(air, h_low).rayleigh[channel] +
                                        sample_air(air, h_low).mie[channel] / air.mie_scattering_per_km[channel] *
                                            (air.mie_scattering_per_km[channel] + air.mie_absorption_per_km[channel]) +
                                        air.ozone_per_km[channel];
                    const double next = at - std::log1p(-random()) / most;
                    if (next >= piece) {
                        at = piece;
                        continue;
                    }
                    at = next;
                    h = height_at(air, r - air.ground_radius_km, cosine, at);
                    if (random() * most < sample_air(air, h).extinction[channel]) {
                        scattered = true;
                        break;
                    }
                }
                position += direction * at;
                if (!scattered) {
                    if (!span.ground) {
                        break;
                    }
                    const glm::dvec3 up = glm::normalize(position);
                    position = up * air.ground_radius_km;
                    weight *= air.ground_albedo[channel];
                    const double facing = glm::dot(up, sun);
                    if (order >= least_order && facing > 0.0) {
                        light += weight / pi * facing * sun_light(0.0, facing)[channel];
                    }
                    direction = around(up, std::sqrt(random()), two_pi * random());
                    continue;
                }
                const AirSample sample = sample_air(air, h);
                const double scattering = sample.rayleigh[channel] + sample.mie[channel];
                weight *= scattering / sample.extinction[channel];
                const glm::dvec3 up = glm::normalize(position);
                const double nu = glm::dot(direction, sun);
                if (order >= least_order) {
                    const double phase = (sample.rayleigh[channel] * phase_rayleigh(nu) +
                                          sample.mie[channel] * phase_cornette_shanks(nu, air.mie_g)) /
                                         scattering;
                    light += weight * phase * sun_light(h, glm::dot(up, sun))[channel];
                }
                // Next direction: sampled from Rayleigh or Henyey-Greenstein, the latter weighted to Cornette-Shanks.
                if (random() * scattering < sample.rayleigh[channel]) {
                    direction = around(direction, rayleigh_cosine(random()), two_pi * random());
                } else {
                    const double c = henyey_greenstein_cosine(random(), air.mie_g);
                    weight *= phase_cornette_shanks(c, air.mie_g) / phase_henyey_greenstein(c, air.mie_g);
                    direction = around(direction, c, two_pi * random());
                }
            }
            sum += light;
            squares += light * light;
        }
        const double mean = sum / paths;
        result.mean[channel] = mean * air.sun_lux[channel];
        result.standard_error[channel] =
            std::sqrt(std::max(squares / paths - mean * mean, 0.0) / paths) * air.sun_lux[channel];
    }
    return result;
}

} // namespace alpenglow::sky
