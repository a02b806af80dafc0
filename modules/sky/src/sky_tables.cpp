// Tables of the scattering sky: each is built when somebody reads it, and again when its own inputs have moved past its
// error.
#include "sky_model.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/aerial_table.hpp>
#include <alpenglow/sky/scattering_tables.hpp>
#include <alpenglow/sky/sky_state.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace alpenglow::sky {
namespace {

// The relative change of radiance with turbidity and ozone (per atm cm), at most; sky_model_test sweeps them.
constexpr double turbidity_rate = 2.0;
constexpr double ozone_rate = 6.0;

double air_bound(const Atmosphere& made, const Atmosphere& now) {
    double bound = turbidity_rate * std::abs(double(made.turbidity) - double(now.turbidity)) +
                   ozone_rate * std::abs(double(made.ozone_atm_cm) - double(now.ozone_atm_cm));
    double albedo = 0.0; // the ground itself is as bright as its albedo
    for (int c = 0; c < 3; ++c) {
        const double a = double(made.ground_albedo[c]);
        const double b = double(now.ground_albedo[c]);
        albedo = std::max(albedo, std::abs(a - b) / std::max(std::min(a, b), 1e-3));
    }
    return bound + albedo;
}

// The relative change of the brightness of a direction with the light's altitude, per radian.
struct Rate {
    double from_deg, per_rad;
};
constexpr std::array<Rate, 8> rates{
    {{-90, 0.01}, {-21, 150}, {-17, 110}, {-3, 120}, {1, 60}, {5, 25}, {12, 10}, {25, 4}}};

double altitude_bound(double made, double now) {
    if (!(made >= -2.0)) { // NaN: never made
        return std::numeric_limits<double>::infinity();
    }
    const double low = std::min(made, now) / degree_rad;
    const double high = std::max(made, now) / degree_rad;
    double worst = 0.0;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        const double to_deg = i + 1 < rates.size() ? rates[i + 1].from_deg : 90.0;
        if (high >= rates[i].from_deg && low <= to_deg) {
            worst = std::max(worst, rates[i].per_rad);
        }
    }
    const double x = worst * (high - low) * degree_rad;
    return x > 1.0 ? std::numeric_limits<double>::infinity() : std::expm1(x);
}

} // namespace

SkyTableWork update_sky_tables(const SkyState& state, const CelestialState& celestial, const SkyTableNeeds& needs,
                               SkyTables& tables) {
    SkyTableWork work;
    const double limit = static_cast<double>(state.air.max_error);
    const bool any =
        state.air.model == SkyModel::scattering && (needs.sky_view || needs.aerial_perspective || needs.transmittance);
    if (!any) {
        tables = {};
        return work;
    }
    const auto keep = [&](double bound) {
        if (bound <= limit) {
            ++work.kept;
            work.error_bound = std::max(work.error_bound, bound);
            return true;
        }
        return false;
    };
    if (tables.atmosphere == nullptr || !keep(air_bound(tables.air, state.air))) {
        Result<ScatteringAtmosphere> air = make_scattering_atmosphere(state.air.turbidity, state.air.ozone_atm_cm,
                                                                      glm::dvec3(state.air.ground_albedo));
        tables.atmosphere = std::make_shared<const ScatteringTables>(*air);
        tables.air = state.air;
        ++tables.atmosphere_revision;
        ++work.rebuilt;
        tables.sun_view = tables.moon_view = nullptr;
        tables.sun_aerial = tables.moon_aerial = nullptr;
    }
    const double sun = altitude_rad(celestial.to_sun);
    const double moon = altitude_rad(celestial.to_moon);
    const bool sunlit = state.fade > 0.0F;
    const bool moonlit = state.moon_fade > 0.0F;
    // A view or an aerial table for one light.
    const auto update = [&]<class Table>(bool wanted, double altitude, double& made, std::uint32_t& revision,
                                         float made_height_m, std::shared_ptr<const Table>& to) {
        if (!wanted) {
            to = nullptr;
            return;
        }
        const double moved = height_rate_per_m * std::abs(double(state.height_m) - double(made_height_m));
        if (to != nullptr && keep(altitude_bound(made, altitude) + moved)) {
            return;
        }
        auto built = std::make_shared<Table>();
        built->build(*tables.atmosphere, 1e-3F * state.height_m, static_cast<float>(std::sin(altitude)));
        to = std::move(built);
        made = altitude;
        ++revision;
        ++work.rebuilt;
    };
    // Both lights' tables share a height: both go when it has changed.
    const auto height = [&](float& made_height_m, auto& of_sun, auto& of_moon) {
        if (height_rate_per_m * std::abs(double(state.height_m) - double(made_height_m)) > limit) {
            of_sun = nullptr;
            of_moon = nullptr;
        }
        if (of_sun == nullptr && of_moon == nullptr) {
            made_height_m = state.height_m;
        }
    };
    height(tables.view_height_m, tables.sun_view, tables.moon_view);
    update(needs.sky_view && sunlit, sun, tables.sun_altitude_rad, tables.view_revision, tables.view_height_m,
           tables.sun_view);
    update(needs.sky_view && moonlit, moon, tables.moon_altitude_rad, tables.view_revision, tables.view_height_m,
           tables.moon_view);
    height(tables.aerial_height_m, tables.sun_aerial, tables.moon_aerial);
    update(needs.aerial_perspective && sunlit, sun, tables.aerial_sun_altitude_rad, tables.aerial_revision,
           tables.aerial_height_m, tables.sun_aerial);
    update(needs.aerial_perspective && moonlit, moon, tables.aerial_moon_altitude_rad, tables.aerial_revision,
           tables.aerial_height_m, tables.moon_aerial);
    return work;
}

} // namespace alpenglow::sky
