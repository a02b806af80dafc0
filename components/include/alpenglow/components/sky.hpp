// The clear sky: what a designer sets, and what update_sky and update_sky_light write.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

namespace alpenglow {

// Input. Air over the observer.
struct Atmosphere {
    float turbidity = 2.5F;                 // Linke-type turbidity of Preetham's model, 1.7 .. 10
    float ozone_atm_cm = 0.35F;             // column of ozone
    glm::vec3 ground_albedo{0.2F};          // linear Rec.709, for the light that the ground sends back up
    float max_error = 0.005F;               // relative error of sky and sunlight that may go unnoticed
};

// Output of update_sky: the state of the sky model and the lights behind the air. Light is photometric linear Rec.709
// (see docs/architecture.md).
struct SkyState {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};
    float turbidity = 2.5F;
    // Perez coefficients A..E of Preetham's model for Y, x, y, and its zenith values (kcd/m^2 is not used: cd/m^2).
    std::array<float, 5> perez_Y{}, perez_x{}, perez_y{};
    glm::vec3 zenith_Yxy{0.0F, 1.0F / 3.0F, 1.0F / 3.0F};
    glm::vec3 horizon_normalisation{1.0F}; // F(0, theta_sun) for Y, x, y
    float fade = 1.0F;                     // of the sky below the horizon, 1 with the sun up, towards 0 at night
    glm::vec3 night_radiance_cd_m2{0.0F};  // a dim, uniform floor: starlight and moonlit air
    glm::vec3 sun_illuminance_lux{0.0F};   // on a surface facing the sun, at the ground, through the air
    glm::vec3 moon_illuminance_lux{0.0F};  // likewise for the moon at its phase
    std::uint32_t celestial_revision = 0;
    std::uint32_t revision = 0;
};

// Input, on every entity lit by the sky's SH: how many bands it reads. No such entity (or none visible), no sky SH.
struct SkyLightReceiver {
    int bands = 3;        // 1 .. 7
    bool visible = true;
};

// Output of update_sky_light: sky radiance projected on SH, cd/m^2, in the local frame (zonal axis = zenith).
struct SkyLightSh {
    static constexpr int max_bands = 7;
    std::array<glm::vec3, 49> coefficients{};
    int bands = 0;                        // valid bands; 0 until somebody asks
    glm::vec3 made_from_to_sun{0.0F};
    std::uint32_t sky_revision = 0;
    std::uint32_t revision = 0;
};

} // namespace alpenglow
