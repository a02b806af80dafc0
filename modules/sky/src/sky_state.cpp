#include <alpenglow/sky/sky_state.hpp>

#include "sky_model.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/quiet.hpp>
#include <alpenglow/sky/scattering.hpp>
#include <alpenglow/sky/sky_sh.hpp>
#include <alpenglow/sky/sun_light.hpp>
#include <alpenglow/sky/twilight.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

constexpr double astronomical_unit_m = 1.495978707e11;

bool is_dome(SkyModel model) {
    return model != SkyModel::scattering;
}

// Twilight of the dome models. Preetham's is too bright from 10 degrees down; the others are right to the horizon.
double dome_fade(SkyModel model, double altitude) {
    if (model == SkyModel::preetham) {
        return twilight_fade(altitude);
    }
    return altitude >= 0.0 ? 1.0 : twilight_fade(altitude) / twilight_fade(0.0);
}

// The scattering sky has its own twilight down to where its tables end; over two degrees it goes out.
double scattering_fade(double altitude) {
    const double t = std::clamp((altitude / degree_rad + 20.0) / 2.0, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Of the direct light in clear air, what the model's clouds let through.
double direct_share(const Atmosphere& a, double altitude, double clear_lux) {
    switch (a.model) {
    case SkyModel::cie_overcast:
        return 0.0;
    case SkyModel::asrc_cie:
        return std::clamp((static_cast<double>(a.clearness) - 1.0) / 5.0, 0.0, 1.0);
    case SkyModel::cie_general:
        return std::clamp((a.cie_type - 5) / 7.0, 0.0, 1.0);
    case SkyModel::perez: {
        // Perez et al. 1990, eq. 1 and 2: epsilon gives direct over diffuse, Delta the diffuse irradiance; 105 lm/W.
        const double theta = 0.5 * pi - std::max(altitude, 0.0);
        const double mass = relative_optical_length(std::max(altitude, 0.0));
        const double direct_w = static_cast<double>(a.brightness) * 1367.0 / mass *
                                (static_cast<double>(a.clearness) - 1.0) * (1.0 + 1.041 * theta * theta * theta);
        return clear_lux > 0.0 ? std::clamp(105.0 * direct_w / clear_lux, 0.0, 1.0) : 0.0;
    }
    default:
        return 1.0;
    }
}

// Through the air of SkyModel::scattering, where refraction lifts the body; it weakens with the air.
glm::dvec3 scattering_transmittance(const ScatteringAtmosphere& air, double altitude, double height_km,
                                    double angular_radius) {
    ScatteringAtmosphere with_disc = air;
    with_disc.sun_angular_radius_rad = angular_radius;
    const double apparent = altitude + refraction_rad(altitude) * std::exp(-height_km / air.rayleigh_height_km);
    return sun_transmittance(with_disc, height_km, std::sin(apparent), 16);
}

} // namespace

DomeParameters dome_parameters(const Atmosphere& a, const glm::vec3& to_light) {
    DomeParameters p;
    p.model = static_cast<DomeModel>(a.model);
    p.to_sun = to_light;
    p.turbidity = a.turbidity;
    p.clearness = a.clearness;
    p.brightness = a.brightness;
    p.cie_type = a.cie_type;
    p.zenith_cd_m2 = a.model == SkyModel::preetham ? 0.0F : a.zenith_cd_m2;
    return p;
}

double altitude_rad(const glm::vec3& direction) {
    return std::atan2(double(direction.z), std::hypot(double(direction.x), double(direction.y)));
}

Status check(const Atmosphere& a, double height_m) {
    const auto wrong = [](const char* field, double value, const char* expected) {
        return Error{std::string(field) + " is " + std::to_string(value), "atmosphere", expected};
    };
    if (!within(a.turbidity, 1.7F, 10.0F)) {
        return wrong("turbidity", a.turbidity, "a number from 1.7 to 10");
    }
    if (!within(a.ozone_atm_cm, 0.0F, 2.0F)) {
        return wrong("ozone_atm_cm", a.ozone_atm_cm, "a number from 0 to 2");
    }
    for (int k = 0; k < 3; ++k) {
        if (!within(a.ground_albedo[k], 0.0F, 1.0F)) {
            return wrong("ground_albedo", a.ground_albedo[k], "numbers from 0 to 1");
        }
    }
    if (!within(a.max_error, 0.0F, 1.0F)) {
        return wrong("max_error", a.max_error, "a number from 0 to 1");
    }
    if (a.model > SkyModel::scattering) {
        return wrong("model", static_cast<double>(a.model), "one of SkyModel");
    }
    if (!within(height_m, -500.0, 80e3)) {
        return wrong("the observer's height_m", height_m, "a number from -500 to 80000");
    }
    if (is_dome(a.model)) {
        return check(dome_parameters(a, {0.0F, 0.0F, 1.0F}));
    }
    return Ok{};
}

SkyState make_sky_state(const CelestialState& celestial, const Atmosphere& atmosphere, double height_m) {
    SkyState state;
    state.to_sun = celestial.to_sun;
    state.air = atmosphere;
    state.height_m = static_cast<float>(std::max(height_m, 0.0));
    state.turbidity = atmosphere.turbidity;
    state.to_moon = celestial.to_moon;
    state.moon_phase_angle_rad = celestial.moon_phase_angle_rad;

    const double sun_altitude = altitude_rad(celestial.to_sun);
    const double moon_altitude = altitude_rad(celestial.to_moon);
    const bool dome = is_dome(atmosphere.model);
    const double sun_distance = celestial.sun_distance_m / astronomical_unit_m;
    const auto fade = [&](double altitude) {
        return dome ? dome_fade(atmosphere.model, altitude) : scattering_fade(altitude);
    };
    state.fade = static_cast<float>(fade(sun_altitude));
    if (dome) {
        const AirColumn air{atmosphere.turbidity, atmosphere.ozone_atm_cm, 2.0};
        const glm::dvec3 sun = sun_illuminance_lux(sun_altitude, celestial.sun_angular_radius_rad, sun_distance, air);
        const glm::dvec3 moon = moon_illuminance_lux(moon_altitude, celestial.moon_angular_radius_rad,
                                                     celestial.moon_distance_m, celestial.moon_phase_angle_rad, air);
        const double clear_lux = luminance(sun);
        state.sun_illuminance_lux = glm::vec3(sun * direct_share(atmosphere, sun_altitude, clear_lux));
        // The clouds that the sun would meet there.
        AirColumn same = air;
        const double at_moon =
            luminance(sun_illuminance_lux(moon_altitude, celestial.sun_angular_radius_rad, 1.0, same));
        state.moon_illuminance_lux = glm::vec3(moon * direct_share(atmosphere, moon_altitude, at_moon));
    } else {
        const Result<ScatteringAtmosphere> air = make_scattering_atmosphere(
            atmosphere.turbidity, atmosphere.ozone_atm_cm, glm::dvec3(atmosphere.ground_albedo));
        assert(air.has_value());
        const double height_km = 1e-3 * static_cast<double>(state.height_m);
        state.sun_illuminance_lux =
            glm::vec3(air->sun_lux / (sun_distance * sun_distance) *
                      scattering_transmittance(*air, sun_altitude, height_km, celestial.sun_angular_radius_rad));
        const double mean_distance_m = 3.844e8;
        const double distance = celestial.moon_distance_m / mean_distance_m;
        state.moon_illuminance_lux =
            glm::vec3(xyz_to_rec709(spectrum_to_xyz(moon_spectrum())) *
                      (moon_phase_factor(celestial.moon_phase_angle_rad) / (distance * distance)) *
                      scattering_transmittance(*air, moon_altitude, height_km, celestial.moon_angular_radius_rad));
        state.fade /= static_cast<float>(sun_distance * sun_distance);
    }
    state.night_radiance_cd_m2 = glm::vec3(night_floor_cd_m2());
    // By day moonlit air is a millionth of the sky.
    if (sun_altitude < 0.0) {
        state.moon_fade =
            static_cast<float>(fade(moon_altitude) * full_moon_illuminance_lux *
                               moon_phase_factor(celestial.moon_phase_angle_rad) / solar_illuminance_constant_lux);
    }
    return state;
}

PreethamSky<float> preetham_of(const SkyState& state) {
    return make_preetham(state.to_sun, state.turbidity);
}

glm::vec3 sky_radiance(const SkyState& state, const PreethamSky<float>& model, const glm::vec3& direction) {
    return state.fade * radiance(model, direction) + state.night_radiance_cd_m2;
}

namespace {

// How fast the error grows with the angle moved, per radian, from a sun's altitude up to the next one's: the largest
// over the models' parameters, with a margin. sky_state_test sweeps the sun and fails where a true error exceeds the
// bound.
struct Rate {
    double from_deg, per_rad;
};
constexpr std::array<Rate, 11> dome_rates{
    {{-90, 0.01}, {-19, 160}, {-16, 80}, {-1, 180}, {1, 80}, {2, 50}, {4, 30}, {6, 22}, {9, 12}, {11, 8}, {20, 3}}};
constexpr std::array<Rate, 11> other_dome_rates{
    {{-90, 0.01}, {-19, 160}, {-16, 80}, {-1, 180}, {1, 80}, {2, 50}, {4, 30}, {6, 22}, {9, 12}, {11, 8}, {20, 6}}};
constexpr std::array<Rate, 9> scattering_rates{
    {{-90, 0.01}, {-21, 400}, {-17, 150}, {-3, 250}, {1, 80}, {3, 40}, {6, 22}, {11, 12}, {20, 5}}};

double rate(std::span<const Rate> rates, double low_deg, double high_deg) {
    double worst = 0.0;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        const double to_deg = i + 1 < rates.size() ? rates[i + 1].from_deg : 90.0;
        if (high_deg >= rates[i].from_deg && low_deg <= to_deg) {
            worst = std::max(worst, rates[i].per_rad);
        }
    }
    return worst;
}

double moved(const glm::vec3& from, const glm::vec3& to) {
    const glm::dvec3 a(from);
    const glm::dvec3 b(to);
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

double drift(std::span<const Rate> rates, const glm::vec3& from, const glm::vec3& to) {
    const double angle = moved(from, to);
    const double a = altitude_rad(from) / degree_rad;
    const double b = altitude_rad(to) / degree_rad;
    const double worst = rate(rates, std::min(a, b), std::max(a, b));
    return worst * angle > 1.0 ? std::numeric_limits<double>::infinity() : std::expm1(worst * angle);
}

} // namespace

bool same_air(const Atmosphere& a, const Atmosphere& b) {
    const bool dome_fields = a.clearness == b.clearness && a.brightness == b.brightness && a.cie_type == b.cie_type &&
                             a.zenith_cd_m2 == b.zenith_cd_m2;
    const bool scattering_fields = a.ground_albedo == b.ground_albedo;
    return a.model == b.model && a.turbidity == b.turbidity && a.ozone_atm_cm == b.ozone_atm_cm &&
           (is_dome(a.model) ? dome_fields || a.model == SkyModel::preetham : scattering_fields);
}

double drift_bound(const SkyState& state, const CelestialState& celestial, const Atmosphere& atmosphere,
                   double height_m) {
    if (state.revision == 0 || !same_air(state.air, atmosphere)) {
        return std::numeric_limits<double>::infinity();
    }
    const std::span<const Rate> rates = atmosphere.model == SkyModel::preetham ? std::span<const Rate>(dome_rates)
                                        : is_dome(atmosphere.model)            ? std::span<const Rate>(other_dome_rates)
                                                                               : scattering_rates;
    double bound = drift(rates, state.to_sun, celestial.to_sun);
    const bool night = std::min(state.to_sun.z, celestial.to_sun.z) < 0.0F;
    if (night) {
        // The moon is a second light; its brightness goes with its phase, at most 6.3 e-folds a radian.
        bound += drift(rates, state.to_moon, celestial.to_moon) +
                 7.0 * std::abs(double(state.moon_phase_angle_rad) - celestial.moon_phase_angle_rad);
    }
    if (!is_dome(atmosphere.model)) {
        bound += height_rate_per_m * std::abs(std::max(height_m, 0.0) - static_cast<double>(state.height_m));
    }
    return bound;
}

} // namespace alpenglow::sky
