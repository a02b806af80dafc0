#include "sandbox/app/transfer_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <glm/common.hpp>

#include <alpenglow/sh/dering.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/zonal.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr double pi_d = std::numbers::pi;
constexpr std::size_t count = std::size_t{transfer_bands} * transfer_bands;
using Coefficients = std::array<glm::dvec3, count>;

// Part of a disc above the terrain's horizon in its azimuth.
double above_horizon(const HorizonBytes& horizon, const glm::vec3& to_light, float radius_rad) {
    float steps = std::atan2(to_light.x, to_light.y) *
                  (static_cast<float>(horizon_azimuths) / (2.0F * std::numbers::pi_v<float>));
    steps = steps < 0.0F ? steps + static_cast<float>(horizon_azimuths) : steps;
    const auto k = static_cast<std::size_t>(steps);
    const double elevation = static_cast<double>(glm::mix(
        decode_horizon_rad(horizon[k % 16]), decode_horizon_rad(horizon[(k + 1) % 16]), steps - static_cast<float>(k)));
    const double altitude = std::asin(std::clamp(static_cast<double>(to_light.z), -1.0, 1.0));
    const double x = std::clamp((altitude - elevation) / static_cast<double>(radius_rad), -1.0, 1.0);
    return 0.5 + (x * std::sqrt(1.0 - x * x) + std::asin(x)) / pi_d;
}

void add_disc(const glm::vec3& to_light, double radius_rad, const glm::dvec3& lux, Coefficients& out) {
    std::array<double, transfer_bands> zonal{};
    sh::zonal_disc(transfer_bands, radius_rad, zonal);
    sh::add_zonal(transfer_bands, zonal, glm::dvec3(to_light), lux / sh::disc_solid_angle(radius_rad), out);
}

} // namespace

TransferLight transfer_light(const SceneLight& light, const CelestialState& celestial, const SkyState& sky,
                             const SkyLightSh& sky_light, const Atmosphere& atmosphere, const HorizonBytes& horizon,
                             TransferWindow window) {
    Coefficients sum{};
    for (std::size_t i = 0; i < count; ++i) {
        sum[i] = glm::dvec3(sky_light.coefficients[i]);
    }
    const glm::dvec3 sun = glm::dvec3(sky.sun_illuminance_lux) *
                           above_horizon(horizon, light.to_sun, static_cast<float>(celestial.sun_angular_radius_rad));
    const glm::dvec3 moon =
        glm::dvec3(sky.moon_illuminance_lux) *
        above_horizon(horizon, light.to_moon, static_cast<float>(celestial.moon_angular_radius_rad));
    std::array<glm::vec3, 9> lux{};
    sh::irradiance(3, std::span(sky_light.coefficients).first<9>(), std::span<glm::vec3>(lux));
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    const glm::dvec3 level =
        glm::dvec3(glm::max(sh::evaluate(3, std::span<const glm::vec3>(lux), up), glm::vec3(0.0F))) +
        sun * std::max(0.0, static_cast<double>(light.to_sun.z)) +
        moon * std::max(0.0, static_cast<double>(light.to_moon.z));
    std::array<double, transfer_bands> ground{};
    sh::zonal_hemisphere(transfer_bands, 0.0, 1.0, ground);
    sh::add_zonal(transfer_bands, ground, glm::dvec3(up), glm::dvec3(atmosphere.ground_albedo) * level / pi_d, sum);
    add_disc(light.to_sun, celestial.sun_angular_radius_rad, sun, sum);
    add_disc(light.to_moon, celestial.moon_angular_radius_rad, moon, sum);

    std::array<double, 3 * count> channels{};
    for (std::size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) {
            channels[static_cast<std::size_t>(c) * count + i] = sum[i][c];
        }
    }
    const auto least_window = [&](sh::Signal signal) {
        const sh::Dering dering =
            sh::find_window(transfer_bands, channels,
                            {.signal = signal, .method = sh::DeringMethod::exact, .family = sh::WindowFamily::gauss});
        std::array<double, transfer_bands> factors{};
        for (std::size_t l = 0; l < factors.size(); ++l) {
            factors[l] = dering.outcome == sh::DeringOutcome::unchanged ? 1.0 : dering.factors[l];
        }
        return factors;
    };
    const std::array<double, transfer_bands> sure = least_window(sh::Signal::radiance);
    std::array<double, transfer_bands> wanted = sure;
    if (window == TransferWindow::none) {
        wanted.fill(1.0);
    } else if (window != TransferWindow::radiance) {
        wanted = least_window(sh::Signal::irradiance);
    }
    for (std::size_t l = 0; l < wanted.size() && window == TransferWindow::halfway; ++l) {
        wanted[l] = std::sqrt(wanted[l] * sure[l]); // of the family, too: its factors are powers
    }
    TransferLight result;
    result.window = static_cast<float>(wanted[1]);
    for (std::size_t l = 0; l < transfer_bands; ++l) {
        for (std::size_t i = l * l; i < (l + 1) * (l + 1); ++i) {
            result.coefficients.emplace_back(sum[i] * wanted[l]);
            result.sure.emplace_back(sum[i] * sure[l]);
        }
    }
    return result;
}

} // namespace alpenglow::sandbox
