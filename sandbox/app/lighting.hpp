// From what the systems wrote to what a frame is lit by.
#pragma once

#include <array>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>

namespace alpenglow::sandbox {

// A disc in the sky as the camera sees it.
struct SeenDisc {
    float angular_radius_rad = 4.65e-3F; // level
    float flattening = 1.0F;             // height over width
    glm::vec3 lux{0.0F};                 // its light at the camera, as it would be without the horizon
};

struct SceneLight {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F}; // apparent, lifted by refraction
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    SeenDisc sun, moon;
    glm::vec3 sun_lux{0.0F}, moon_lux{0.0F};      // on surfaces that face them
    float horizon_rad = 0.0F;                     // elevation at which the sky ends
    bool moon_makes_sky = false;                  // more of its light comes from the moon than from the sun
    std::array<glm::mat4, 3> irradiance_matrix{}; // R, G, B: sky and ground bounce, lux
    glm::vec3 horizon_radiance_cd_m2{
        0.0F}; // mean radiance of the sky just above the horizon: what distant air saturates to
    float average_luminance_cd_m2 = 0.0F; // of a view that is half sky, half lit ground
};

// From here up the ground's light begins to differ from the camera's.
inline constexpr float light_from_above_m = 500.0F;

// `light` has at least 3 bands. `over_ground_m`: how high the camera stands over the ground: from far above, surfaces
// are lit as at sea level, while `sky` and `light` are those at the camera.
[[nodiscard]] SceneLight scene_light(const CelestialState& celestial, const SkyState& sky, const SkyTables* tables,
                                     const SkyLightSh& light, float over_ground_m);

} // namespace alpenglow::sandbox
