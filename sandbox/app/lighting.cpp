#include "sandbox/app/lighting.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <glm/common.hpp>

#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/sky/sun_light.hpp>
#include <alpenglow/sky/twilight.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;

float luminance(const glm::vec3& rgb) {
    return 0.2126F * rgb.r + 0.7152F * rgb.g + 0.0722F * rgb.b;
}

float altitude_rad(const glm::vec3& direction) {
    return std::atan2(direction.z, std::hypot(direction.x, direction.y));
}

// The direction at another altitude, in the same azimuth. At the zenith there is nothing to turn.
glm::vec3 at_altitude(const glm::vec3& direction, double altitude) {
    const float level = std::hypot(direction.x, direction.y);
    if (level < 1e-6F) {
        return direction;
    }
    const auto scale = static_cast<float>(std::cos(altitude)) / level;
    return {direction.x * scale, direction.y * scale, static_cast<float>(std::sin(altitude))};
}

// The light of a disc of which the horizon leaves a fraction, as it would be whole.
glm::vec3 whole(const glm::vec3& lux, const glm::dvec3& visible) {
    return lux / glm::vec3(glm::max(visible, glm::dvec3(1e-3)));
}

// Adds what level ground of one radiance sends up from the lower hemisphere: its projection on the first three bands is
// 2 pi K_0 on Y_0^0, -pi K_1 on Y_1^0 and nothing on band 2.
void add_ground(const glm::vec3& radiance, std::array<glm::vec3, 9>& coefficients) {
    coefficients[0] += radiance * (2.0F * pi_f * 0.28209479F);
    coefficients[2] -= radiance * (pi_f * 0.48860251F);
}

} // namespace

SceneLight scene_light(const CelestialState& celestial, const SkyState& sky, const SkyTables* tables,
                       const SkyLightSh& light, float over_ground_m) {
    SceneLight result;
    const bool shell = sky.air.model == SkyModel::scattering;
    const double height_m = shell ? static_cast<double>(sky.height_m) : 0.0;
    const double horizon = shell ? sky::horizon_altitude_rad(height_m) : 0.0;
    result.horizon_rad = static_cast<float>(horizon);
    const double sun_altitude = static_cast<double>(altitude_rad(celestial.to_sun));
    const sky::ApparentDisc sun =
        sky::apparent_disc(sun_altitude, static_cast<double>(celestial.sun_angular_radius_rad), height_m);
    const sky::ApparentDisc moon = sky::apparent_disc(static_cast<double>(altitude_rad(celestial.to_moon)),
                                                      static_cast<double>(celestial.moon_angular_radius_rad), height_m);
    result.to_sun = at_altitude(celestial.to_sun, sun.altitude_rad);
    result.to_moon = at_altitude(celestial.to_moon, moon.altitude_rad);
    const auto seen = [](const sky::ApparentDisc& disc, const glm::vec3& lux) {
        return SeenDisc{static_cast<float>(disc.horizontal_radius_rad),
                        static_cast<float>(disc.vertical_radius_rad / disc.horizontal_radius_rad), lux};
    };
    result.sun = seen(sun, whole(sky.sun_illuminance_lux,
                                 sky::visible_sun_fraction(sun.altitude_rad - horizon, sun.vertical_radius_rad)));
    result.moon = seen(
        moon, whole(sky.moon_illuminance_lux,
                    glm::dvec3(sky::visible_disc_fraction(moon.altitude_rad - horizon, moon.vertical_radius_rad))));
    result.sun_lux = sky.sun_illuminance_lux;
    result.moon_lux = sky.moon_illuminance_lux;
    result.moon_makes_sky = static_cast<double>(sky.moon_fade) > sky::twilight_fade(sun_altitude);

    std::array<glm::vec3, 9> coefficients{};
    std::copy_n(light.coefficients.begin(), 9, coefficients.begin());
    constexpr float end_m = 4000.0F;
    const float up_there = glm::smoothstep(light_from_above_m, end_m, over_ground_m);
    if (shell && up_there > 0.0F) {
        // At sea level, within the domain of the sky's fit, where no table is needed.
        Atmosphere air = sky.air;
        air.turbidity = std::clamp(air.turbidity, 2.0F, 8.0F);
        air.ozone_atm_cm = 0.35F;
        air.ground_albedo = glm::min(air.ground_albedo, glm::vec3(0.8F));
        const SkyState below = sky::make_sky_state(celestial, air);
        std::array<glm::vec3, 9> there{};
        sky::project_sky_state(below, nullptr, 3, there);
        for (std::size_t i = 0; i < there.size(); ++i) {
            coefficients[i] = glm::mix(coefficients[i], there[i], up_there);
        }
        result.sun_lux = glm::mix(result.sun_lux, below.sun_illuminance_lux, up_there);
        result.moon_lux = glm::mix(result.moon_lux, below.moon_illuminance_lux, up_there);
    }
    // Mean radiance of the upper hemisphere: from Y_0^0 of a sky that has nothing below.
    const float sky_mean = luminance(coefficients[0]) / (2.0F * pi_f * 0.28209479F);
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    std::array<glm::vec3, 9> irradiance{};
    sh::irradiance(3, std::span<const glm::vec3>(coefficients), std::span<glm::vec3>(irradiance));
    const glm::vec3 from_sky = glm::max(sh::evaluate(3, std::span<const glm::vec3>(irradiance), up), glm::vec3(0.0F));
    const glm::vec3 ground_lux = from_sky + result.sun_lux * std::max(0.0F, result.to_sun.z) +
                                 result.moon_lux * std::max(0.0F, result.to_moon.z);
    const glm::vec3 ground_radiance = sky.air.ground_albedo * ground_lux / pi_f;
    add_ground(ground_radiance, coefficients);
    for (int channel = 0; channel < 3; ++channel) {
        std::array<float, 9> one{};
        for (std::size_t i = 0; i < one.size(); ++i) {
            one[i] = coefficients[i][channel];
        }
        result.irradiance_matrix[static_cast<std::size_t>(channel)] =
            sh::irradiance_matrix(std::span<const float>(one));
    }

    constexpr std::size_t azimuths = 16;
    std::array<glm::vec3, azimuths> directions{};
    std::array<glm::vec3, azimuths> radiance{};
    const float elevation = result.horizon_rad + 0.03F;
    for (std::size_t i = 0; i < azimuths; ++i) {
        const float azimuth = 2.0F * pi_f * (static_cast<float>(i) + 0.5F) / azimuths;
        directions[i] = {std::cos(elevation) * std::sin(azimuth), std::cos(elevation) * std::cos(azimuth),
                         std::sin(elevation)};
    }
    sky::sky_radiance(sky, tables, directions, radiance);
    for (const glm::vec3& one : radiance) {
        result.horizon_radiance_cd_m2 += one / static_cast<float>(azimuths);
    }
    result.average_luminance_cd_m2 = 0.5F * (sky_mean + luminance(ground_radiance));
    return result;
}

} // namespace alpenglow::sandbox
