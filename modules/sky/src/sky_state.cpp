#include <alpenglow/sky/sky_state.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/sky_fit.hpp>
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

double altitude_rad(const glm::vec3& direction) {
    return std::atan2(double(direction.z), std::hypot(double(direction.x), double(direction.y)));
}

std::array<float, 5> packed(const PerezCoefficients<float>& p) {
    return {p.a, p.b, p.c, p.d, p.e};
}
PerezCoefficients<float> unpacked(const std::array<float, 5>& p) {
    return {p[0], p[1], p[2], p[3], p[4]};
}

// Mean radiance of the air lit by a body outside of it: Preetham's sky for that body as the sun, scaled.
glm::dvec3 mean_scattered_radiance(double altitude, double turbidity, double illuminance_outside_lux) {
    constexpr double y00 = 0.28209479177387814;
    std::array<glm::dvec3, 1> zonal{};
    project_preetham(0.5 * pi - altitude, turbidity, 1, {6, 6}, zonal);
    return zonal[0] *
           (twilight_fade(altitude) / (y00 * two_pi) * illuminance_outside_lux / solar_illuminance_constant_lux);
}

} // namespace

Status check(const Atmosphere& a) {
    const auto wrong = [](const char* field, double value, const char* expected) {
        return Error{std::string(field) + " is " + std::to_string(value), "atmosphere", expected};
    };
    if (!(a.turbidity >= 1.7F && a.turbidity <= 10.0F)) {
        return wrong("turbidity", a.turbidity, "a number from 1.7 to 10");
    }
    if (!(a.ozone_atm_cm >= 0.0F && a.ozone_atm_cm <= 2.0F)) {
        return wrong("ozone_atm_cm", a.ozone_atm_cm, "a number from 0 to 2");
    }
    for (int k = 0; k < 3; ++k) {
        if (!(a.ground_albedo[k] >= 0.0F && a.ground_albedo[k] <= 1.0F)) {
            return wrong("ground_albedo", a.ground_albedo[k], "numbers from 0 to 1");
        }
    }
    if (!(a.max_error >= 0.0F && a.max_error <= 1.0F)) {
        return wrong("max_error", a.max_error, "a number from 0 to 1");
    }
    return Ok{};
}

SkyState make_sky_state(const CelestialState& celestial, const Atmosphere& atmosphere) {
    SkyState state;
    state.to_sun = celestial.to_sun;
    state.turbidity = atmosphere.turbidity;
    state.to_moon = celestial.to_moon;
    state.moon_phase_angle_rad = celestial.moon_phase_angle_rad;
    state.ozone_atm_cm = atmosphere.ozone_atm_cm;

    const PreethamSky<float> model = make_preetham(celestial.to_sun, atmosphere.turbidity);
    state.perez_Y = packed(model.perez[0]);
    state.perez_x = packed(model.perez[1]);
    state.perez_y = packed(model.perez[2]);
    state.zenith_Yxy = model.zenith_Yxy;
    state.horizon_normalisation = model.normalisation;

    const double sun_altitude = altitude_rad(celestial.to_sun);
    const double moon_altitude = altitude_rad(celestial.to_moon);
    state.fade = static_cast<float>(twilight_fade(sun_altitude));
    const AirColumn air{atmosphere.turbidity, atmosphere.ozone_atm_cm, 2.0};
    state.sun_illuminance_lux = glm::vec3(sun_illuminance_lux(sun_altitude, celestial.sun_angular_radius_rad,
                                                              celestial.sun_distance_m / astronomical_unit_m, air));
    state.moon_illuminance_lux =
        glm::vec3(moon_illuminance_lux(moon_altitude, celestial.moon_angular_radius_rad, celestial.moon_distance_m,
                                       celestial.moon_phase_angle_rad, air));
    glm::dvec3 night = night_floor_cd_m2();
    // By day moonlit air is a millionth of the sky.
    if (sun_altitude < 0.0 && moon_altitude > -18.0 * degree_rad) {
        night += mean_scattered_radiance(moon_altitude, atmosphere.turbidity,
                                         full_moon_illuminance_lux * moon_phase_factor(celestial.moon_phase_angle_rad));
    }
    state.night_radiance_cd_m2 = glm::vec3(night);
    return state;
}

PreethamSky<float> preetham_of(const SkyState& state) {
    PreethamSky<float> model{};
    // The direction as the model holds it: never below the horizon.
    model.to_sun = state.to_sun;
    if (model.to_sun.z < 0.0F) {
        const float length = std::hypot(model.to_sun.x, model.to_sun.y);
        model.to_sun =
            length > 0.0F ? glm::vec3(model.to_sun.x / length, model.to_sun.y / length, 0.0F) : glm::vec3(0, 1, 0);
    }
    model.turbidity = state.turbidity;
    model.perez = {unpacked(state.perez_Y), unpacked(state.perez_x), unpacked(state.perez_y)};
    model.zenith_Yxy = state.zenith_Yxy;
    model.normalisation = state.horizon_normalisation;
    return model;
}

glm::vec3 sky_radiance(const SkyState& state, const PreethamSky<float>& model, const glm::vec3& direction) {
    return state.fade * radiance(model, direction) + state.night_radiance_cd_m2;
}

void project_sky_state(const SkyState& state, int bands, std::span<glm::vec3> out) {
    assert(bands >= 1 && bands <= max_sky_bands && out.size() >= static_cast<std::size_t>(bands * bands));
    const auto count = static_cast<std::size_t>(bands * bands);
    if (!(state.fade > 0.0F)) {
        std::fill_n(out.begin(), count, glm::vec3(0.0F));
    } else if (state.turbidity >= 2.0F) {
        static const SkyFitEvaluator fit(preetham_fit());
        fit.evaluate_uncached(state.to_sun, std::span(&state.turbidity, 1), bands, out);
    } else {
        // Below turbidity 2 the model is at its end and the fit has none.
        std::array<glm::dvec3, max_sky_bands * max_sky_bands> c{};
        project_preetham(0.5 * pi - altitude_rad(state.to_sun), state.turbidity, bands, {12, 16},
                         std::span(c).first(count));
        rotate_symmetric_sky(glm::dvec3(state.to_sun), bands, std::span(c).first(count));
        std::copy_n(c.begin(), count, out.begin());
    }
    for (std::size_t i = 0; i < count; ++i) {
        out[i] *= state.fade;
    }
    // The night: a uniform upper hemisphere, 2 pi sqrt((2l+1) / 4 pi) times the integral of P_l over 0 .. 1.
    constexpr std::array<float, max_sky_bands> uniform{1.7724539F, 1.5349901F,  0.0F, -0.58618401F,
                                                       0.0F,       0.36741027F, 0.0F};
    for (int l = 0; l < bands; ++l) {
        out[static_cast<std::size_t>(l * (l + 1))] += state.night_radiance_cd_m2 * uniform[static_cast<std::size_t>(l)];
    }
}

namespace {

// How fast the error grows with the angle moved, per radian, from a sun's altitude up to the next one's: the largest
// over turbidities 1.7 to 10, with a margin. sky_state_test sweeps the sun and fails where a true error exceeds the
// bound.
struct Rate {
    double from_deg, per_rad;
};
constexpr std::array<Rate, 11> rates{
    {{-90, 0.01}, {-19, 160}, {-16, 80}, {-1, 180}, {1, 80}, {2, 50}, {4, 30}, {6, 22}, {9, 12}, {11, 8}, {20, 3}}};

double rate(double low_deg, double high_deg) {
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

double drift(const glm::vec3& from, const glm::vec3& to) {
    const double angle = moved(from, to);
    const double a = altitude_rad(from) / degree_rad;
    const double b = altitude_rad(to) / degree_rad;
    const double worst = rate(std::min(a, b), std::max(a, b));
    return worst * angle > 1.0 ? std::numeric_limits<double>::infinity() : std::expm1(worst * angle);
}

} // namespace

double drift_bound(const SkyState& state, const CelestialState& celestial, const Atmosphere& atmosphere) {
    if (state.revision == 0 || state.turbidity != atmosphere.turbidity ||
        state.ozone_atm_cm != atmosphere.ozone_atm_cm) {
        return std::numeric_limits<double>::infinity();
    }
    double bound = drift(state.to_sun, celestial.to_sun);
    const bool night = std::min(state.to_sun.z, celestial.to_sun.z) < 0.0F;
    if (night) {
        // The moon is a second light; its brightness goes with its phase, at most 6.3 e-folds a radian.
        bound += drift(state.to_moon, celestial.to_moon) +
                 7.0 * std::abs(double(state.moon_phase_angle_rad) - celestial.moon_phase_angle_rad);
    }
    return bound;
}

} // namespace alpenglow::sky
