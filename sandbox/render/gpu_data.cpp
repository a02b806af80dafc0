#include "sandbox/render/gpu_data.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "sandbox/render/passes.hpp"
#include "sandbox/render/sky_dome.hpp"
#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// The two horizon azimuths around a light, as word and shift in Vertex::horizon.
glm::uvec4 sector(float at) {
    const auto first = static_cast<std::uint32_t>(at) % 16U;
    const std::uint32_t second = (first + 1U) % 16U;
    return {first / 4U, first % 4U * 8U, second / 4U, second % 4U * 8U};
}

// Azimuth of a light in steps of 22.5 degrees from north through east, 0 .. 16.
float azimuth_steps(glm::vec3 towards) {
    const float azimuth = std::atan2(towards.x, towards.y);
    const float steps = azimuth / (2.0F * kPi) * 16.0F;
    return steps < 0.0F ? steps + 16.0F : steps;
}

// As light.glsl's functions of these names.
float disc_over_horizon(float height, float radius) {
    const float x = std::clamp(height / radius, -1.0F, 1.0F);
    return 0.5F + (x * std::sqrt(std::max(1.0F - x * x, 0.0F)) + std::asin(x)) / kPi;
}

float horizon_elevation(const std::array<std::uint32_t, 4>& horizon, glm::uvec4 at, float weight) {
    const auto decode = [&horizon](std::uint32_t word, std::uint32_t shift) {
        const float root = static_cast<float>(horizon[word] >> shift & 0xFFU) / 255.0F;
        return 0.5F * kPi * root * root;
    };
    return (1.0F - weight) * decode(at.x, at.y) + weight * decode(at.z, at.w);
}

float elevation(glm::vec3 towards) {
    return std::atan2(towards.z, std::hypot(towards.x, towards.y));
}

glm::vec4 with(glm::vec3 xyz, float w) {
    return {xyz.x, xyz.y, xyz.z, w};
}

} // namespace

SkyExtract extract_sky(const FrameData& frame) {
    SkyExtract extract;
    if (frame.sky_vertices.empty()) {
        extract.horizon.fill(frame.air_radiance_cd_m2);
        return extract;
    }
    std::uint32_t i = 0;
    for (std::size_t entry = 0; entry < extract.horizon.size(); ++entry) {
        const float wanted = 2.0F * std::asin(static_cast<float>(entry) / 16.0F - 1.0F);
        while (i + 1 < SkyDome::azimuths && sky_azimuth_from_light(i + 1) < wanted) {
            ++i;
        }
        const float from = sky_azimuth_from_light(i);
        const float part = std::clamp((wanted - from) / (sky_azimuth_from_light(i + 1) - from), 0.0F, 1.0F);
        extract.horizon[entry] = (1.0F - part) * frame.sky_vertices[i].radiance_cd_m2 +
                                 part * frame.sky_vertices[(i + 1) % SkyDome::azimuths].radiance_cd_m2;
    }
    const auto nearer = [&](const SkyVertex& a, const SkyVertex& b) {
        return glm::dot(a.direction, frame.to_moon) < glm::dot(b.direction, frame.to_moon);
    };
    extract.at_moon = std::max_element(frame.sky_vertices.begin(), frame.sky_vertices.end(), nearer)->radiance_cd_m2;
    return extract;
}

glm::mat4 reversed_depth(const glm::mat4& projection) {
    glm::mat4 reversed = projection;
    for (glm::length_t column = 0; column < 4; ++column) {
        reversed[column][2] = static_cast<float>(double{projection[column][3]} - double{projection[column][2]});
    }
    return reversed;
}

glm::mat4 clip_from_relative(const FrameData& frame) {
    return reversed_depth(frame.projection) * glm::mat4(glm::mat3(frame.view));
}

float pixels_per_radian(const FrameData& frame, std::uint32_t height_px) {
    return 0.5F * static_cast<float>(height_px) * std::abs(frame.projection[1][1]);
}

float moon_disc_mean_cosine(float cos_phase) {
    const float phase = std::acos(std::clamp(cos_phase, -1.0F, 1.0F));
    return 2.0F * (std::sin(phase) + (kPi - phase) * std::cos(phase)) / (3.0F * kPi);
}

bool moon_is_key(const FrameData& frame) {
    const glm::vec3 weights(0.2126F, 0.7152F, 0.0722F);
    return glm::dot(weights, frame.moon_illuminance_lux) > glm::dot(weights, frame.sun_illuminance_lux);
}

glm::mat4 shadow_from_relative(const FrameData& frame, std::uint32_t size_px) {
    constexpr float kHalfWidth = 160.0F; // metres around the middle
    constexpr float kHalfDepth = 1000.0F;
    constexpr float kAhead = 100.0F;
    const glm::vec3 key = moon_is_key(frame) ? frame.to_moon : frame.to_sun;
    const glm::vec3 aside = std::abs(key.z) < 0.999F ? glm::vec3(0.0F, 0.0F, 1.0F) : glm::vec3(0.0F, 1.0F, 0.0F);
    const glm::vec3 right = glm::normalize(glm::cross(aside, key));
    const glm::vec3 up = glm::cross(key, right);
    const glm::vec3 forward = -glm::vec3(frame.view[0][2], frame.view[1][2], frame.view[2][2]);
    const glm::vec3 middle = frame.camera_m + kAhead * glm::vec3(forward.x, forward.y, 0.0F);
    const float texel = 2.0F * kHalfWidth / static_cast<float>(size_px);
    const auto snapped = [texel](float at) { return std::round(at / texel) * texel; };
    // The map's middle relative to the camera, along the light's axes.
    const float x = snapped(glm::dot(right, middle)) - glm::dot(right, frame.camera_m);
    const float y = snapped(glm::dot(up, middle)) - glm::dot(up, frame.camera_m);
    const float z = glm::dot(key, middle - frame.camera_m);
    const glm::vec3 across = right / kHalfWidth;
    const glm::vec3 upwards = up / kHalfWidth;
    const glm::vec3 along = key / (2.0F * kHalfDepth); // 1 nearest to the light, 0 farthest
    return {glm::vec4(across.x, upwards.x, along.x, 0.0F), glm::vec4(across.y, upwards.y, along.y, 0.0F),
            glm::vec4(across.z, upwards.z, along.z, 0.0F),
            glm::vec4(-x / kHalfWidth, -y / kHalfWidth, 0.5F - z / (2.0F * kHalfDepth), 1.0F)};
}

namespace {

// Light scattered once, level, at the azimuth of a horizon entry: the sun's (or moon's) by molecules (Rayleigh) and
// aerosol (Henyey-Greenstein, g = 0.76), and the sky's own from all around; scaled to the luminance of the horizon
// there.
glm::vec3 near_light(const FrameData& frame, const SkyExtract& sky, std::size_t entry) {
    const auto luminance = [](const glm::vec3& rgb) { return glm::dot(rgb, {0.2126F, 0.7152F, 0.0722F}); };
    const glm::vec3 to_light = frame.moon_makes_sky ? frame.to_moon : frame.to_sun;
    const float half = static_cast<float>(entry) / 16.0F - 1.0F;
    const float cosine = (1.0F - 2.0F * half * half) * std::sqrt(std::max(0.0F, 1.0F - to_light.z * to_light.z));
    constexpr float g = 0.76F;
    const float rayleigh_phase = 3.0F / (16.0F * kPi) * (1.0F + cosine * cosine);
    const float spread = (1.0F - g) * (1.0F - g) + 2.0F * g * (1.0F - cosine);
    const float mie_phase = (1.0F - g * g) / (4.0F * kPi * spread * std::sqrt(spread));
    const glm::vec3 rayleigh = frame.rayleigh_per_m * std::exp(-frame.camera_m.z / frame.rayleigh_height_m);
    const glm::vec3 mie = frame.mie_per_m * std::exp(-frame.camera_m.z / frame.mie_height_m);
    const glm::vec3 phase = (rayleigh * rayleigh_phase + mie * mie_phase) / (rayleigh + mie);
    const glm::vec3 light = (frame.moon_makes_sky ? frame.moon_illuminance_lux : frame.sun_illuminance_lux) * phase +
                            frame.air_radiance_cd_m2;
    const float level = luminance(light);
    return level > 0.0F ? light * (luminance(sky.horizon[entry]) / level) : sky.horizon[entry];
}

} // namespace

gpu::FrameBlock make_frame_block(const FrameData& frame, const SkyExtract& sky, std::uint32_t height_px) {
    gpu::FrameBlock block{};
    const float exposure = frame.exposure;
    block.clip_from_relative = clip_from_relative(frame);
    for (std::size_t channel = 0; channel < 3; ++channel) {
        block.irradiance[channel] = frame.irradiance_matrix[channel] * (exposure / kPi);
    }
    block.camera_m = with(frame.camera_m, pixels_per_radian(frame, height_px));
    block.to_sun = with(frame.to_sun, frame.sun_angular_radius_rad);
    block.to_moon = with(frame.to_moon, frame.moon_angular_radius_rad);
    block.sun = with(frame.sun_illuminance_lux * (exposure / kPi), exposure);
    block.moon = with(frame.moon_illuminance_lux * (exposure / kPi), 0.0F);
    block.key = moon_is_key(frame) ? with(frame.to_moon, 1.0F) : with(frame.to_sun, 0.0F);
    block.shadow_from_relative = shadow_from_relative(frame, kShadowMapSize);
    const auto solid_angle = [](float radius, float flattening) {
        return kPi * std::sin(radius) * std::sin(radius) * flattening;
    };
    block.sun_disc = with(frame.sun_seen_lux.value_or(frame.sun_illuminance_lux) *
                              (exposure / solid_angle(frame.sun_angular_radius_rad, frame.sun_flattening)),
                          0.0F);
    const float lit = moon_disc_mean_cosine(-glm::dot(frame.to_moon, frame.to_sun));
    if (lit > 1e-4F) { // thinner than any crescent that can be seen
        block.moon_disc =
            with(frame.moon_seen_lux.value_or(frame.moon_illuminance_lux) *
                     (exposure / (solid_angle(frame.moon_angular_radius_rad, frame.moon_flattening) * lit)),
                 0.0F);
    }
    block.discs = {frame.sun_flattening, frame.moon_flattening, frame.horizon_rad, 0.0F};
    block.moon_sky = with(sky.at_moon * exposure, 0.0F);
    block.rayleigh = with(frame.rayleigh_per_m, 1.0F / frame.rayleigh_height_m);
    block.mie = with(frame.mie_per_m, 1.0F / frame.mie_height_m);
    const float sun_steps = azimuth_steps(frame.to_sun);
    const float moon_steps = azimuth_steps(frame.to_moon);
    block.sector = {sun_steps - std::floor(sun_steps), moon_steps - std::floor(moon_steps), elevation(frame.to_sun),
                    elevation(frame.to_moon)};
    block.sun_sector = sector(sun_steps);
    block.moon_sector = sector(moon_steps);
    const bool moonlit = frame.moon_makes_sky;
    const glm::vec3 to_light = moonlit ? frame.to_moon : frame.to_sun;
    const float level = std::hypot(to_light.x, to_light.y);
    const glm::vec2 azimuth = level > 0.0F ? glm::vec2(to_light) / level : glm::vec2(0.0F, 1.0F);
    const float visible =
        moonlit ? disc_over_horizon(block.sector.w -
                                        horizon_elevation(frame.camera_horizon, block.moon_sector, block.sector.y),
                                    frame.moon_angular_radius_rad)
                : disc_over_horizon(block.sector.z -
                                        horizon_elevation(frame.camera_horizon, block.sun_sector, block.sector.x),
                                    frame.sun_angular_radius_rad);
    block.haze = {visible, azimuth.x, azimuth.y, moonlit ? 1.0F : 0.0F};
    block.cloud_map = glm::vec4(-1e30F);
    if (frame.clouds != nullptr && frame.clouds->shadow.size == cloud_shadow_size) {
        const CloudShadowMap& map = frame.clouds->shadow;
        block.cloud_map = {1.0F / map.extent_m, map.plane_m, map.base_m, map.top_m};
        // A light at the horizon would shear the map without end.
        const glm::vec2 shear = glm::vec2(map.to_light) / std::max(map.to_light.z, 0.03F);
        const glm::vec2 corner = map.offset_m / map.extent_m;
        block.cloud_key = {shear.x, shear.y, corner.x - std::floor(corner.x), corner.y - std::floor(corner.y)};
        static_assert(sizeof block.cloud_shadow == std::size_t(cloud_shadow_size) * cloud_shadow_size);
        static_assert(sizeof block <= 16384); // what every device takes
        std::memcpy(block.cloud_shadow, map.texels.data(), sizeof block.cloud_shadow);
    }
    for (std::size_t i = 0; i < sky.horizon.size(); ++i) {
        block.horizon_light[i] = with(sky.horizon[i] * frame.air_light * exposure, 0.0F);
        block.near_light[i] = with(near_light(frame, sky, i) * frame.air_light * exposure, 0.0F);
    }
    return block;
}

gpu::Instance make_instance(const ObjectInstance& object) {
    const glm::mat4& m = object.world_from_object;
    return {{m[0][0], m[1][0], m[2][0], m[3][0]},
            {m[0][1], m[1][1], m[2][1], m[3][1]},
            {m[0][2], m[1][2], m[2][2], m[3][2]},
            object.horizon};
}

} // namespace alpenglow::sandbox
