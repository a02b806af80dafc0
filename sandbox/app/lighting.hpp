// From what the systems wrote to what a frame is lit by.
#pragma once

#include <array>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>

namespace alpenglow::sandbox {

struct SceneLight {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};       // apparent, lifted by refraction
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    std::array<glm::mat4, 3> irradiance_matrix{}; // R, G, B: sky and ground bounce, lux
    glm::vec3 horizon_radiance_cd_m2{0.0F};   // mean radiance of the sky just above the horizon: what distant air saturates to
    float average_luminance_cd_m2 = 0.0F;     // of a view that is half sky, half lit ground
};

// `light` has at least 3 bands.
[[nodiscard]] SceneLight scene_light(const CelestialState& celestial, const SkyState& sky, const SkyLightSh& light,
                                     const Atmosphere& atmosphere);

} // namespace alpenglow::sandbox
