#include <alpenglow/sky/night_sky.hpp>

#include "unit_quadrature.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/sky_sh.hpp>
#include <alpenglow/sky/sun_light.hpp>
#include <alpenglow/sky/twilight.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

constexpr double nanolambert_cd_m2 = 1e-5 / pi;
constexpr float aerosol_fall_per_rad = 3.2982337F; // ln(10) / 40 degrees

// Relative optical length of the scattering night sky, eq. 3: 1 at the zenith, 5 at the horizon.
template <class Real>
Real air_mass(Real cosine) {
    return Real(1) / std::sqrt(Real(0.04) + Real(0.96) * cosine * cosine);
}

// A spectrum's colour at unit luminance.
glm::dvec3 unit_colour(const Spectrum& spectrum) {
    const glm::dvec3 rgb = into_gamut(xyz_to_rec709(spectrum_to_xyz(spectrum)));
    return rgb / luminance(rgb);
}

// Moonlight scattered once by particles that favour short waves by that power.
glm::dvec3 scattered_moonlight(double power) {
    Spectrum spectrum = moon_spectrum();
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        spectrum[i] *= std::pow((spectrum_first_nm + spectrum_step_nm * static_cast<double>(i)) / 550.0, power);
    }
    return unit_colour(spectrum);
}

// What the air along a direction scatters of what comes in, and the zenith's floor brightened by the longer path
// through the glowing layer and dimmed by the air before it (eq. 2).
template <class Real>
Real scattered_share(Real extinction, Real cosine) {
    return -std::expm1(-extinction * air_mass(cosine));
}
template <class Real>
Real floor_gain(Real extinction, Real cosine) {
    const Real x = air_mass(cosine);
    return x * std::exp(-extinction * (x - Real(1)));
}

constexpr int moon_bands = 8;

// Legendre series about the moon of e^(-c rho), rho the angle to it: coefficients of P_l.
std::array<double, moon_bands> aerosol_series() {
    std::array<double, moon_bands> series{};
    const UnitNodes nodes = unit_quadrature(64);
    for (std::size_t n = 0; n < nodes.x.size(); ++n) {
        const double rho = pi * nodes.x[n];
        const double z = std::cos(rho);
        const double w = nodes.w[n] * pi * std::sin(rho) * std::exp(-static_cast<double>(aerosol_fall_per_rad) * rho);
        double before = 0.0;
        double p = 1.0;
        for (int l = 0; l < moon_bands; ++l) {
            series[static_cast<std::size_t>(l)] += 0.5 * (2 * l + 1) * w * p;
            const double next = ((2 * l + 1) * z * p - l * before) / (l + 1);
            before = p;
            p = next;
        }
    }
    return series;
}

// Nodes over the upper hemisphere's cosines, denser towards the horizon, with the basis at azimuth 0.
struct Node {
    double z, weight;
    std::array<double, sh::max_coefficients> basis;
};
const std::array<Node, 16>& hemisphere_nodes() {
    static const std::array<Node, 16> nodes = [] {
        const UnitNodes unit = unit_quadrature(16);
        std::array<Node, 16> out{};
        for (std::size_t n = 0; n < out.size(); ++n) {
            const double t = unit.x[n];
            out[n].z = t * t;
            out[n].weight = unit.w[n] * 2.0 * t;
            sh::evaluate_basis(moon_bands, glm::dvec3(std::sqrt(1.0 - out[n].z * out[n].z), 0.0, out[n].z),
                               out[n].basis);
        }
        return out;
    }();
    return nodes;
}

} // namespace

NightSky make_night_sky(const glm::vec3& to_moon, float moon_distance_m, float phase_angle_rad, float turbidity) {
    NightSky sky;
    sky.to_moon = to_moon;
    const double t = turbidity >= 1.0F ? std::min(double(turbidity), 20.0) : 1.0;
    // Vertical depth at 550 nm: molecules, aerosol as for the sun's light, ozone.
    const double beta = std::max(0.04608365822050 * t - 0.04586025928522, 0.0);
    const double extinction = 0.1 + beta * std::pow(0.55, -1.3) + 0.03;
    sky.extinction = static_cast<float>(extinction);
    sky.floor_cd_m2 = glm::vec3(night_floor_cd_m2());
    const double altitude = std::atan2(double(to_moon.z), std::hypot(double(to_moon.x), double(to_moon.y)));
    const double set = altitude < 0.0 ? twilight_fade(altitude) / twilight_fade(0.0) : 1.0;
    if (!(set > 0.0)) {
        return sky;
    }
    const double distance = moon_distance_m >= 1e8F ? std::min(double(moon_distance_m), 1e9) / 3.844e8 : 1.0;
    // Eq. 20: 10^(-0.4 (3.84 + ...)), and the moon's own path through the air.
    const double moon = std::pow(10.0, -0.4 * 3.84) * moon_phase_factor(phase_angle_rad) / (distance * distance) * set *
                        std::exp(-extinction * air_mass(std::max(std::sin(altitude), 0.0))) * nanolambert_cd_m2;
    static const glm::dvec3 blue = scattered_moonlight(-4.08);
    static const glm::dvec3 pale = scattered_moonlight(-1.3);
    sky.molecules = glm::vec3(moon * std::pow(10.0, 5.36) * blue);
    sky.aerosol = glm::vec3(moon * std::pow(10.0, 6.15) * pale);
    return sky;
}

glm::vec3 night_radiance(const NightSky& sky, const glm::vec3& direction) {
    const float z = std::clamp(direction.z, 0.0F, 1.0F);
    const float cosine = std::clamp(glm::dot(direction, sky.to_moon), -1.0F, 1.0F);
    const float rho = std::atan2(glm::length(glm::cross(direction, sky.to_moon)), cosine);
    const float share = scattered_share(sky.extinction, z);
    return share * ((1.06F + cosine * cosine) * sky.molecules + std::exp(-aerosol_fall_per_rad * rho) * sky.aerosol) +
           floor_gain(sky.extinction, z) * sky.floor_cd_m2;
}

void project_night_sky(const NightSky& sky, int bands, std::span<glm::vec3> out) {
    assert(bands >= 1 && bands <= max_sky_bands && out.size() >= static_cast<std::size_t>(bands * bands));
    const auto count = static_cast<std::size_t>(bands * bands);
    std::fill_n(out.begin(), count, glm::vec3(0.0F));
    const bool moonlit = sky.molecules.y > 0.0F || sky.aerosol.y > 0.0F;
    static const std::array<double, moon_bands> haze = aerosol_series();
    // The moon in the +X meridian: f = sum over m of f_m(z) cos(m azimuth), by the addition theorem.
    std::array<double, sh::max_coefficients> at_moon{};
    if (moonlit) {
        const double z = std::clamp(double(sky.to_moon.z), -1.0, 1.0);
        sh::evaluate_basis(moon_bands, glm::dvec3(std::sqrt(1.0 - z * z), 0.0, z), at_moon);
    }
    const double extinction = sky.extinction;
    for (const Node& node : hemisphere_nodes()) {
        const double share = moonlit ? node.weight * scattered_share(extinction, node.z) : 0.0;
        const double floor = node.weight * floor_gain(extinction, node.z);
        for (int m = 0; m < bands; ++m) {
            glm::dvec3 value(0.0);
            if (moonlit) {
                double molecules = 0.0;
                double aerosol = 0.0;
                for (int l = m; l < moon_bands; ++l) {
                    const auto i = static_cast<std::size_t>(l * (l + 1) + m);
                    const double both = 4.0 * pi / (2 * l + 1) * at_moon[i] * node.basis[i];
                    // cos^2 = 1/3 + 2/3 P_2
                    molecules += (l == 0 ? 1.06 + 1.0 / 3.0 : l == 2 ? 2.0 / 3.0 : 0.0) * both;
                    aerosol += haze[static_cast<std::size_t>(l)] * both;
                }
                value = share * (molecules * glm::dvec3(sky.molecules) + aerosol * glm::dvec3(sky.aerosol));
            }
            if (m == 0) {
                value += floor * glm::dvec3(sky.floor_cd_m2);
            }
            value *= m == 0 ? two_pi : pi;
            for (int l = m; l < bands; ++l) {
                const auto i = static_cast<std::size_t>(l * (l + 1) + m);
                out[i] += glm::vec3(node.basis[i] * value);
            }
        }
    }
    rotate_symmetric_sky(sky.to_moon, bands, out);
}

} // namespace alpenglow::sky
