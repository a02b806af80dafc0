// Radiance and SH of a SkyState, for every model.
#include "sky_model.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/aerial_table.hpp>
#include <alpenglow/sky/scattering_tables.hpp>
#include <alpenglow/sky/sky_fit.hpp>
#include <alpenglow/sky/sky_sh.hpp>
#include <alpenglow/sky/sky_state.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

// Adds scale times the dome of a light to out, in blocks.
void add_dome(const Atmosphere& air, const glm::vec3& to_light, float scale, std::span<const glm::vec3> directions,
              std::span<glm::vec3> out) {
    const SkyDome<float> dome = make_dome<float>(dome_parameters(air, to_light));
    constexpr std::size_t block = 128;
    std::array<std::array<float, block>, 6> soa;
    for (std::size_t at = 0; at < directions.size(); at += block) {
        const std::size_t n = std::min(block, directions.size() - at);
        for (std::size_t i = 0; i < n; ++i) {
            soa[0][i] = directions[at + i].x;
            soa[1][i] = directions[at + i].y;
            soa[2][i] = directions[at + i].z;
        }
        const auto part = [&](std::size_t k) { return std::span(soa[k]).first(n); };
        radiance(dome, {part(0), part(1), part(2)}, {part(3), part(4), part(5)});
        for (std::size_t i = 0; i < n; ++i) {
            out[at + i] += scale * glm::vec3(soa[3][i], soa[4][i], soa[5][i]);
        }
    }
}

void add_view(const SkyView* view, const glm::vec3& to_light, float scale, std::span<const glm::vec3> directions,
              std::span<glm::vec3> out) {
    if (view == nullptr) {
        return;
    }
    for (std::size_t i = 0; i < directions.size(); ++i) {
        out[i] += scale * view->radiance(directions[i], to_light);
    }
}

// The fit of the scattering sky has a grey albedo; channels do not know of each other.
void fit_scattering(const SkyState& state, const glm::vec3& to_light, int bands, std::span<glm::vec3> out) {
    static const SkyFitEvaluator fit(scattering_fit());
    const glm::vec3& albedo = state.air.ground_albedo;
    fit.evaluate_uncached(to_light, std::array{state.air.turbidity, albedo.x}, bands, out);
    std::array<glm::vec3, max_sky_bands * max_sky_bands> other{};
    for (int c = 1; c < 3; ++c) {
        if (albedo[c] != albedo.x) {
            fit.evaluate_uncached(to_light, std::array{state.air.turbidity, albedo[c]}, bands, other);
            for (std::size_t i = 0; i < static_cast<std::size_t>(bands * bands); ++i) {
                out[i][c] = other[i][c];
            }
        }
    }
}

void project_quadrature(const std::function<glm::dvec3(const glm::dvec3&)>& radiance, const glm::vec3& to_light,
                        const SkyQuadrature& nodes, int bands, std::span<glm::vec3> out) {
    std::array<glm::dvec3, max_sky_bands * max_sky_bands> c{};
    const auto count = static_cast<std::size_t>(bands * bands);
    project_symmetric_sky(radiance, 0.5 * pi - altitude_rad(to_light), bands, nodes, std::span(c).first(count));
    rotate_symmetric_sky(glm::dvec3(to_light), bands, std::span(c).first(count));
    std::copy_n(c.begin(), count, out.begin());
}

// The sky that a light as bright as the sun makes.
void project_light(const SkyState& state, const SkyView* view, const glm::vec3& to_light, int bands,
                   std::span<glm::vec3> out) {
    const double altitude = altitude_rad(to_light);
    const glm::dvec3 in_plane(std::cos(altitude), 0.0, std::sin(altitude));
    if (state.air.model == SkyModel::preetham && state.turbidity >= 2.0F) {
        static const SkyFitEvaluator fit(preetham_fit());
        fit.evaluate_uncached(to_light, std::span(&state.turbidity, 1), bands, out);
    } else if (state.air.model == SkyModel::preetham) {
        // Below turbidity 2 the model is at its end and the fit has none.
        std::array<glm::dvec3, max_sky_bands * max_sky_bands> c{};
        const auto count = static_cast<std::size_t>(bands * bands);
        project_preetham(0.5 * pi - altitude, state.turbidity, bands, {12, 16}, std::span(c).first(count));
        rotate_symmetric_sky(glm::dvec3(to_light), bands, std::span(c).first(count));
        std::copy_n(c.begin(), count, out.begin());
    } else if (state.air.model != SkyModel::scattering) {
        const SkyDome<double> dome = make_dome<double>(dome_parameters(state.air, glm::vec3(in_plane)));
        project_quadrature([&](const glm::dvec3& v) { return radiance(dome, v); }, to_light, {12, 16}, bands, out);
    } else if (!sh_needs_sky_view(state)) {
        fit_scattering(state, to_light, bands, out);
    } else if (view != nullptr) {
        const glm::vec3 sun(in_plane);
        project_quadrature([&](const glm::dvec3& v) { return glm::dvec3(view->radiance(glm::vec3(v), sun)); }, to_light,
                           {16, 20}, bands, out);
    } else {
        std::fill_n(out.begin(), static_cast<std::size_t>(bands * bands), glm::vec3(0.0F));
    }
}

} // namespace

void sky_radiance(const SkyState& state, const SkyTables* tables, std::span<const glm::vec3> directions,
                  std::span<glm::vec3> out) {
    assert(out.size() >= directions.size());
    std::fill_n(out.begin(), directions.size(), state.night_radiance_cd_m2);
    if (state.air.model != SkyModel::scattering) {
        if (state.fade > 0.0F) {
            add_dome(state.air, state.to_sun, state.fade, directions, out);
        }
        if (state.moon_fade > 0.0F) {
            add_dome(state.air, state.to_moon, state.moon_fade, directions, out);
        }
    } else if (tables != nullptr) {
        add_view(tables->sun_view.get(), state.to_sun, state.fade, directions, out);
        add_view(tables->moon_view.get(), state.to_moon, state.moon_fade, directions, out);
    }
}

AerialPerspective sky_aerial_perspective(const SkyState& state, const SkyTables* tables, const glm::vec3& direction,
                                         float distance_km) {
    AerialPerspective out{glm::vec3(1.0F), glm::vec3(0.0F)};
    const auto add = [&](const AerialTable* table, const glm::vec3& to_light, float scale) {
        if (table != nullptr) {
            const AerialPerspective one = table->evaluate(direction, distance_km, to_light);
            out.transmittance = one.transmittance;
            out.in_scatter += scale * one.in_scatter;
        }
    };
    if (tables != nullptr) {
        add(tables->sun_aerial.get(), state.to_sun, state.fade);
        add(tables->moon_aerial.get(), state.to_moon, state.moon_fade);
    }
    return out;
}

bool sh_needs_sky_view(const SkyState& state) {
    const Atmosphere& air = state.air;
    const float albedo = std::max({air.ground_albedo.x, air.ground_albedo.y, air.ground_albedo.z});
    return air.model == SkyModel::scattering &&
           (air.turbidity < 2.0F || air.turbidity > 8.0F || albedo > 0.8F || air.ozone_atm_cm != 0.35F ||
            1.5e-4 * static_cast<double>(state.height_m) > static_cast<double>(air.max_error));
}

void project_sky_state(const SkyState& state, const SkyTables* tables, int bands, std::span<glm::vec3> out) {
    assert(bands >= 1 && bands <= max_sky_bands && out.size() >= static_cast<std::size_t>(bands * bands));
    const auto count = static_cast<std::size_t>(bands * bands);
    std::fill_n(out.begin(), count, glm::vec3(0.0F));
    std::array<glm::vec3, max_sky_bands * max_sky_bands> one{};
    const auto add = [&](float scale, const glm::vec3& to_light, const SkyView* view) {
        if (scale > 0.0F) {
            project_light(state, view, to_light, bands, one);
            for (std::size_t i = 0; i < count; ++i) {
                out[i] += scale * one[i];
            }
        }
    };
    add(state.fade, state.to_sun, tables != nullptr ? tables->sun_view.get() : nullptr);
    add(state.moon_fade, state.to_moon, tables != nullptr ? tables->moon_view.get() : nullptr);
    // The night: a uniform upper hemisphere, 2 pi sqrt((2l+1) / 4 pi) times the integral of P_l over 0 .. 1.
    constexpr std::array<float, max_sky_bands> uniform{1.7724539F, 1.5349901F,  0.0F, -0.58618401F,
                                                       0.0F,       0.36741027F, 0.0F};
    for (int l = 0; l < bands; ++l) {
        out[static_cast<std::size_t>(l * (l + 1))] += state.night_radiance_cd_m2 * uniform[static_cast<std::size_t>(l)];
    }
}

DayLight level_illuminance(const SkyState& state, const SkyTables* tables) {
    DayLight light;
    light.sun_lux = state.sun_illuminance_lux * std::max(state.to_sun.z, 0.0F);
    light.moon_lux = state.moon_illuminance_lux * std::max(state.to_moon.z, 0.0F);
    std::array<glm::vec3, max_sky_bands * max_sky_bands> c{};
    project_sky_state(state, tables, max_sky_bands, c);
    // The clamped cosine's zonal bands (Ramamoorthi and Hanrahan 2001, eq. 8), times sqrt((2l+1) / 4 pi).
    constexpr std::array<float, 4> zonal{0.88622693F, 1.0233267F, 0.49541591F, -0.11078367F};
    light.sky_lux = glm::max(zonal[0] * c[0] + zonal[1] * c[2] + zonal[2] * c[6] + zonal[3] * c[20], glm::vec3(0.0F));
    return light;
}

} // namespace alpenglow::sky
