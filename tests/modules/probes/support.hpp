// Skies, grids and walls for the tests of light probes.
#pragma once

#include <alpenglow/core/constants.hpp>
#include <alpenglow/probes/assemble.hpp>
#include <alpenglow/probes/grid.hpp>
#include <alpenglow/probes/update.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>
#include <alpenglow/sh/zonal.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::probes::test {

inline glm::vec3 towards(double altitude_deg, double azimuth_deg = 30.0) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return glm::vec3(glm::dvec3(std::sin(z) * std::cos(a), std::cos(z) * std::cos(a), std::sin(a)));
}

// A dome that is brighter about the sun.
inline ProbeSources clear_sky(int order, double sun_altitude_deg = 35.0) {
    ProbeSources sources;
    sources.order = order;
    sources.to_sun = towards(sun_altitude_deg);
    sources.to_moon = towards(20.0, 200.0);
    sources.sun_lux = {90000.0F, 80000.0F, 66000.0F};
    sources.moon_lux = {2.0F, 2.0F, 1.8F};
    std::array<double, max_probe_order> dome{};
    sh::zonal_hemisphere(order, 1.0, 0.0, dome);
    sh::add_zonal(order, dome, glm::vec3(0.0F, 0.0F, 1.0F), glm::vec3(2500.0F, 3600.0F, 6000.0F), sources.sky);
    std::array<double, max_probe_order> glow{};
    sh::zonal_cone(order, 0.7, glow);
    sh::add_zonal(order, glow, sources.to_sun, glm::vec3(9000.0F, 9500.0F, 10000.0F), sources.sky);
    return sources;
}

// A wall: the sky blocked within an angle of a direction, and nothing below the horizon.
inline std::vector<float> wall(int order, const glm::vec3& direction, double angle_rad, double opacity = 1.0) {
    static const sh::SphereQuadrature quadrature = sh::sphere_quadrature(62);
    const double rim = std::cos(angle_rad);
    std::vector<double> c(static_cast<std::size_t>(sh::coefficient_count(order)));
    sh::project_function(order, quadrature, std::function<double(const glm::dvec3&)>([&](const glm::dvec3& d) {
                             return d.z > 0.0 && glm::dot(d, glm::dvec3(direction)) > rim ? opacity : 0.0;
                         }),
                         c);
    return std::vector<float>(c.begin(), c.end());
}

inline void set_occlusion(ProbeGrid& grid, std::size_t probe, const std::vector<float>& occlusion) {
    const std::size_t count = probe_count(grid);
    const auto n = static_cast<std::size_t>(grid.order * grid.order);
    grid.occlusion.resize(n * count, 0.0F);
    for (std::size_t i = 0; i < n; ++i) {
        grid.occlusion[i * count + probe] = occlusion[i];
    }
}

inline ProbeGrid small_grid(int order = 3) {
    ProbeGrid grid;
    grid.min_m = {-10.0F, 0.0F, 5.0F};
    grid.max_m = {20.0F, 8.0F, 9.0F};
    grid.count = {7, 5, 3};
    grid.order = order;
    return grid;
}

// Shadows, walls and grounds of all kinds, by a seed.
inline void furnish(ProbeGrid& grid, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    const std::size_t count = probe_count(grid);
    grid.sun_visibility.clear();
    grid.moon_visibility.clear();
    grid.albedo.clear();
    for (std::size_t p = 0; p < count; ++p) {
        grid.sun_visibility.push_back(std::clamp(2.0F * uniform(engine) - 0.5F, 0.0F, 1.0F));
        grid.moon_visibility.push_back(uniform(engine));
        grid.albedo.push_back({0.8F * uniform(engine), 0.8F * uniform(engine), 0.8F * uniform(engine)});
        const glm::vec3 direction =
            glm::normalize(glm::vec3(uniform(engine) - 0.5F, uniform(engine) - 0.5F, 0.2F + 0.5F * uniform(engine)));
        set_occlusion(grid, p, wall(grid.order, direction, 1.2 * static_cast<double>(uniform(engine))));
    }
}

inline ProbeInput input_of(const ProbeGrid& grid, std::size_t p, std::vector<float>& occlusion) {
    const std::size_t count = probe_count(grid);
    ProbeInput input;
    input.albedo = grid.albedo.empty() ? grid.ground_albedo : grid.albedo[p];
    input.sun_visibility = grid.sun_visibility.empty() ? 1.0F : grid.sun_visibility[p];
    input.moon_visibility = grid.moon_visibility.empty() ? 1.0F : grid.moon_visibility[p];
    occlusion.clear();
    for (std::size_t i = 0; !grid.occlusion.empty() && i < static_cast<std::size_t>(grid.order * grid.order); ++i) {
        occlusion.push_back(grid.occlusion[i * count + p]);
    }
    input.occlusion = occlusion;
    return input;
}

// All probes needed, and as many frames as it takes.
inline void make_all(const ProbeGrid& grid, ProbeGridSh& light, const ProbeSources& sources) {
    for (bool working = true; working;) {
        ASSERT_TRUE(begin_frame(grid, light));
        std::fill(light.needed.begin(), light.needed.end(), std::uint8_t{1});
        working = update_grid(grid, light, sources).updated > 0;
    }
}

inline ProbeCoefficients probe_light(const ProbeGridSh& light, std::size_t p) {
    ProbeCoefficients c{};
    for (int i = 0; i < light.order * light.order; ++i) {
        c[static_cast<std::size_t>(i)] = coefficient(light, p, i);
    }
    return c;
}

inline double norm(const ProbeCoefficients& c) {
    double sum = 0.0;
    for (const glm::vec3& v : c) {
        sum += glm::dot(glm::dvec3(v), glm::dvec3(v));
    }
    return std::sqrt(sum);
}
inline double distance(const ProbeCoefficients& a, const ProbeCoefficients& b) {
    ProbeCoefficients d{};
    for (std::size_t i = 0; i < d.size(); ++i) {
        d[i] = a[i] - b[i];
    }
    return norm(d);
}

// The least irradiance of any channel over a dense set of normals, relative to that channel's mean (0 for a dark one).
inline double least_irradiance(int order, const ProbeCoefficients& c) {
    const auto n = static_cast<std::size_t>(order * order);
    double least = 0.0;
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<double> radiance(n);
        for (std::size_t i = 0; i < n; ++i) {
            radiance[i] = static_cast<double>(c[i][channel]);
        }
        std::vector<double> e(n);
        sh::irradiance(order, radiance, e);
        const double mean = e[0] / std::sqrt(4.0 * pi);
        for (int k = 0; k < 4000; ++k) {
            const double z = 1.0 - (k + 0.5) / 2000.0;
            const double phi = 2.399963229728653 * k;
            const double r = std::sqrt(1.0 - z * z);
            const double v = sh::evaluate(order, e, glm::dvec3(r * std::cos(phi), r * std::sin(phi), z));
            if (mean > 0.0) {
                least = std::min(least, v / mean);
            } else {
                least = std::min(least, v);
            }
        }
    }
    return least;
}

} // namespace alpenglow::probes::test
