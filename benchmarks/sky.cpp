#include "bench.hpp"

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/preetham.hpp>
#include <alpenglow/sky/sky_sh.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/sky/sun_light.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

// Directions spread evenly over the upper hemisphere (Fibonacci).
std::vector<glm::vec3> hemisphere(std::size_t count) {
    std::vector<glm::vec3> out;
    for (std::size_t i = 0; i < count; ++i) {
        const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        const double a = 2.399963229728653 * static_cast<double>(i);
        const double r = std::sqrt(1.0 - z * z);
        out.emplace_back(glm::dvec3(r * std::cos(a), r * std::sin(a), z));
    }
    return out;
}

double relative(const glm::dvec3& got, const glm::dvec3& want) {
    return glm::length(got - want) / glm::length(want);
}

const Case radiance_case("sky/preetham radiance", [](const Context& context) {
    const std::vector<glm::vec3> directions = hemisphere(4096);
    const glm::vec3 to_sun = glm::normalize(glm::vec3(0.5F, 0.3F, 0.6F));
    const auto reference = sky::make_preetham(glm::dvec3(to_sun), 2.5);
    const auto model = sky::make_preetham(to_sun, 2.5F);
    Row row{.module = "sky",
            .name = "preetham radiance",
            .method = "double, the reference",
            .error_metric = "max relative RGB, 4096 directions",
            .reference = "double libm",
            .items = static_cast<double>(directions.size())};
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(sky::radiance(reference, glm::dvec3(v)));
        }
    });
    row.method = "float scalar";
    for (const glm::vec3& v : directions) {
        row.error =
            std::max(row.error, relative(glm::dvec3(sky::radiance(model, v)), sky::radiance(reference, glm::dvec3(v))));
    }
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(sky::radiance(model, v));
        }
    });
});

const Case quadrature_case("sky/preetham to SH by quadrature", [](const Context& context) {
    std::array<glm::dvec3, 49> exact{};
    std::array<glm::dvec3, 49> got{};
    const std::array<double, 4> thetas{0.05, 0.6, 1.2, 0.5 * pi};
    for (const auto& [elevations, azimuths] :
         {std::pair{4, 6}, {6, 8}, {8, 12}, {12, 16}, {16, 24}, {24, 32}, {40, 56}}) {
        Row row{.module = "sky",
                .name = "preetham to SH, 7 bands",
                .method = "quadrature 2 x " + std::to_string(elevations) + " x " + std::to_string(azimuths),
                .error_metric = "max |c' - c| / |c|, 4 sun heights, turbidity 2.5",
                .reference = "quadrature 2 x 128 x 160"};
        for (const double theta : thetas) {
            sky::project_preetham(theta, 2.5, 7, {128, 160}, exact);
            sky::project_preetham(theta, 2.5, 7, {elevations, azimuths}, got);
            double difference = 0.0;
            double norm = 0.0;
            for (std::size_t i = 0; i < exact.size(); ++i) {
                difference += glm::dot(got[i] - exact[i], got[i] - exact[i]);
                norm += glm::dot(exact[i], exact[i]);
            }
            row.error = std::max(row.error, std::sqrt(difference / norm));
        }
        context.run(row, [&, n = elevations, m = azimuths] {
            sky::project_preetham(0.6, 2.5, 7, {n, m}, got);
            keep(got);
        });
    }
});

const Case direct_case("sky/sun and state", [](const Context& context) {
    Row row{.module = "sky",
            .name = "direct light",
            .method = "sun, spectral",
            .error_metric = "is the reference",
            .reference = ""};
    context.run(row, [] { keep(sky::sun_illuminance_lux(0.5, 4.65e-3, 1.0, {})); });
    CelestialState celestial;
    celestial.to_sun = glm::normalize(glm::vec3(0.5F, 0.3F, 0.6F));
    const Atmosphere atmosphere;
    row.name = "sky state";
    row.method = "make_sky_state";
    context.run(row, [&] { keep(sky::make_sky_state(celestial, atmosphere)); });
    SkyState state = sky::make_sky_state(celestial, atmosphere);
    state.revision = 1;
    row.method = "drift_bound: the check that skips it";
    context.run(row, [&] { keep(sky::drift_bound(state, celestial, atmosphere)); });
});

const Case aerial_case("sky/aerial perspective", [](const Context& context) {
    const sky::Air air = sky::make_air(2.5F);
    const glm::vec3 sun = glm::normalize(glm::vec3(0.3F, 0.7F, 0.5F));
    const glm::vec3 lux(9e4F, 8.5e4F, 7.5e4F);
    const glm::vec3 ambient(3000.0F, 4000.0F, 6000.0F);
    std::vector<glm::vec4> paths; // direction, distance: from 1500 m height
    for (float rise : {-0.1F, -0.05F, 0.0F, 0.03F, 0.1F}) {
        for (float azimuth = 0.0F; azimuth < 6.2F; azimuth += 0.7F) {
            for (float distance : {200.0F, 1000.0F, 3000.0F, 10000.0F, 14000.0F}) {
                const float level = std::sqrt(1.0F - rise * rise);
                paths.emplace_back(level * std::cos(azimuth), level * std::sin(azimuth), rise, distance);
            }
        }
    }
    Row row{.module = "sky",
            .name = "aerial perspective",
            .method = "closed form, scalar",
            .error_metric = "max relative L_in, landscape paths to 14 km",
            .reference = "march of 4000 steps, double",
            .items = static_cast<double>(paths.size())};
    const auto error = [&](const auto& evaluate) {
        double worst = 0.0;
        for (const glm::vec4& p : paths) {
            const auto want = sky::march_aerial_perspective(air, 1500.0F, glm::vec3(p), p.w, sun, lux, ambient, 4000);
            worst = std::max(worst, relative(glm::dvec3(evaluate(p).in_scatter), glm::dvec3(want.in_scatter)));
        }
        return worst;
    };
    const auto closed = [&](const glm::vec4& p) {
        return sky::aerial_perspective(air, 1500.0F, glm::vec3(p), p.w, sun, lux, ambient);
    };
    row.error = error(closed);
    context.run(row, [&] {
        for (const glm::vec4& p : paths) {
            keep(closed(p));
        }
    });
    for (int steps : {4, 16, 64}) {
        const auto march = [&](const glm::vec4& p) {
            return sky::march_aerial_perspective(air, 1500.0F, glm::vec3(p), p.w, sun, lux, ambient, steps);
        };
        row.method = "march, " + std::to_string(steps) + " steps";
        row.error = error(march);
        context.run(row, [&] {
            for (const glm::vec4& p : paths) {
                keep(march(p));
            }
        });
    }
});

} // namespace
} // namespace alpenglow::bench
