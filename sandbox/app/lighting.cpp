#include "sandbox/app/lighting.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <alpenglow/ephemeris/refraction.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sky/sky_state.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;

float luminance(const glm::vec3& rgb) { return 0.2126F * rgb.r + 0.7152F * rgb.g + 0.0722F * rgb.b; }

// Lifts a direction by the refraction of its altitude. At the zenith there is none.
glm::vec3 refracted(const glm::vec3& direction) {
    const float level = std::hypot(direction.x, direction.y);
    if (level < 1e-6F) {
        return direction;
    }
    const double altitude = std::atan2(direction.z, level);
    const double apparent = altitude + ephemeris::refraction_from_true_rad(altitude);
    const auto scale = static_cast<float>(std::cos(apparent)) / level;
    return {direction.x * scale, direction.y * scale, static_cast<float>(std::sin(apparent))};
}

// Adds what level ground of one radiance sends up from the lower hemisphere: its projection on the first three bands is
// 2 pi K_0 on Y_0^0, -pi K_1 on Y_1^0 and nothing on band 2.
void add_ground(const glm::vec3& radiance, std::array<glm::vec3, 9>& coefficients) {
    coefficients[0] += radiance * (2.0F * pi_f * 0.28209479F);
    coefficients[2] -= radiance * (pi_f * 0.48860251F);
}

} // namespace

SceneLight scene_light(const CelestialState& celestial, const SkyState& sky, const SkyLightSh& light,
                       const Atmosphere& atmosphere) {
    SceneLight result;
    result.to_sun = refracted(celestial.to_sun);
    result.to_moon = refracted(celestial.to_moon);

    std::array<glm::vec3, 9> coefficients{};
    std::copy_n(light.coefficients.begin(), 9, coefficients.begin());
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    std::array<glm::vec3, 9> irradiance{};
    sh::irradiance(3, std::span<const glm::vec3>(coefficients), std::span<glm::vec3>(irradiance));
    const glm::vec3 from_sky = glm::max(sh::evaluate(3, std::span<const glm::vec3>(irradiance), up), glm::vec3(0.0F));
    const glm::vec3 ground_lux = from_sky + sky.sun_illuminance_lux * std::max(0.0F, result.to_sun.z) +
                                 sky.moon_illuminance_lux * std::max(0.0F, result.to_moon.z);
    const glm::vec3 ground_radiance = atmosphere.ground_albedo * ground_lux / pi_f;
    add_ground(ground_radiance, coefficients);
    for (int channel = 0; channel < 3; ++channel) {
        std::array<float, 9> one{};
        for (std::size_t i = 0; i < one.size(); ++i) {
            one[i] = coefficients[i][channel];
        }
        result.irradiance_matrix[static_cast<std::size_t>(channel)] = sh::irradiance_matrix(std::span<const float>(one));
    }

    const sky::PreethamSky<float> model = sky::preetham_of(sky);
    constexpr int azimuths = 16;
    for (int i = 0; i < azimuths; ++i) {
        const float azimuth = 2.0F * pi_f * (static_cast<float>(i) + 0.5F) / azimuths;
        const float elevation = 0.03F;
        result.horizon_radiance_cd_m2 +=
            sky::sky_radiance(sky, model,
                              {std::cos(elevation) * std::sin(azimuth), std::cos(elevation) * std::cos(azimuth),
                               std::sin(elevation)}) /
            static_cast<float>(azimuths);
    }
    // Mean radiance of the upper hemisphere: from Y_0^0 of a sky that has nothing below.
    const float sky_mean = luminance(light.coefficients[0]) / (2.0F * pi_f * 0.28209479F);
    result.average_luminance_cd_m2 = 0.5F * (sky_mean + luminance(ground_radiance));
    return result;
}

} // namespace alpenglow::sandbox
