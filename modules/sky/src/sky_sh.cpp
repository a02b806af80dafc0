#include <alpenglow/sky/sky_sh.hpp>

#include "unit_quadrature.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

template <class Real>
void rotate_symmetric(const glm::vec<3, Real>& to_sun, int bands, std::span<glm::vec<3, Real>> c) {
    const Real length = std::hypot(to_sun.x, to_sun.y);
    if (!(length > Real(0))) {
        return;
    }
    const Real c1 = to_sun.x / length;
    const Real s1 = to_sun.y / length;
    Real cos_m = 1;
    Real sin_m = 0;
    for (int m = 1; m < bands; ++m) {
        const Real next = cos_m * c1 - sin_m * s1;
        sin_m = sin_m * c1 + cos_m * s1;
        cos_m = next;
        for (int l = m; l < bands; ++l) {
            const auto centre = static_cast<std::size_t>(l * (l + 1));
            const auto order = static_cast<std::size_t>(m);
            const glm::vec<3, Real> value = c[centre + order];
            c[centre - order] = value * sin_m;
            c[centre + order] = value * cos_m;
        }
    }
}

} // namespace

void project_symmetric_sky(const std::function<glm::dvec3(const glm::dvec3&)>& radiance, double sun_zenith_angle_rad,
                           int bands, const SkyQuadrature& quadrature, std::span<glm::dvec3> out) {
    assert(bands >= 1 && bands <= max_sky_bands && out.size() >= static_cast<std::size_t>(bands * bands));
    assert(quadrature.elevations >= 1 && quadrature.azimuths >= 1);
    std::fill_n(out.begin(), bands * bands, glm::dvec3(0.0));
    const UnitNodes nodes = unit_quadrature(quadrature.elevations);
    const UnitNodes azimuths = unit_quadrature(quadrature.azimuths);
    std::array<double, sh::max_coefficients> basis{};
    // Split at the sun's elevation, where the radiance has a kink; quadratic spacing towards the split and the horizon,
    // where e^(B / cos theta) turns sharply.
    const double sun_elevation = std::clamp(0.5 * pi - sun_zenith_angle_rad, 0.0, 0.5 * pi);
    const std::array<std::array<double, 2>, 2> parts{{{0.0, sun_elevation}, {sun_elevation, 0.5 * pi}}};
    for (const auto& [low, high] : parts) {
        if (high - low < 1e-12) {
            continue;
        }
        for (std::size_t n = 0; n < nodes.x.size(); ++n) {
            // smoothstep clusters the nodes at both ends: elevation = low + (high - low) t^2 (3 - 2 t)
            const double t = nodes.x[n];
            const double elevation = low + (high - low) * t * t * (3.0 - 2.0 * t);
            const double z = std::sin(elevation);
            const double r = std::cos(elevation);
            const double ring = nodes.w[n] * 6.0 * t * (1.0 - t) * (high - low) * r;
            for (std::size_t k = 0; k < azimuths.x.size(); ++k) {
                // Cubic clustering towards the sun's meridian.
                const double s = azimuths.x[k];
                const double azimuth = pi * s * s * s;
                const double weight = 2.0 * ring * pi * 3.0 * s * s * azimuths.w[k];
                const glm::dvec3 direction(r * std::cos(azimuth), r * std::sin(azimuth), z);
                const glm::dvec3 value = weight * radiance(direction);
                sh::evaluate_basis(bands, direction, basis);
                for (int l = 0; l < bands; ++l) {
                    for (int m = 0; m <= l; ++m) {
                        const auto i = static_cast<std::size_t>(l * (l + 1) + m);
                        out[i] += basis[i] * value;
                    }
                }
            }
        }
    }
}

void project_preetham(double sun_zenith_angle_rad, double turbidity, int bands, const SkyQuadrature& quadrature,
                      std::span<glm::dvec3> out) {
    const double theta = std::clamp(sun_zenith_angle_rad, 0.0, 0.5 * pi);
    const PreethamSky<double> sky =
        make_preetham(glm::dvec3(std::sin(theta), 0.0, std::max(std::cos(theta), 0.0)), turbidity);
    project_symmetric_sky([&](const glm::dvec3& direction) { return sky::radiance(sky, direction); }, theta, bands,
                          quadrature, out);
}

void rotate_symmetric_sky(const glm::dvec3& to_sun, int bands, std::span<glm::dvec3> coefficients) {
    rotate_symmetric(to_sun, bands, coefficients);
}
void rotate_symmetric_sky(const glm::vec3& to_sun, int bands, std::span<glm::vec3> coefficients) {
    rotate_symmetric(to_sun, bands, coefficients);
}

} // namespace alpenglow::sky
