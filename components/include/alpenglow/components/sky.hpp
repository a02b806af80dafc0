// The clear sky: what a designer sets, and what update_sky and update_sky_light write.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

namespace alpenglow {

// Input. Air over the observer.
struct Atmosphere {
    float turbidity = 2.5F;                 // Linke-type turbidity of Preetham's model, 1.7 .. 10
    float ozone_atm_cm = 0.35F;             // column of ozone, 0 .. 2
    glm::vec3 ground_albedo{0.2F};          // linear Rec.709, 0 .. 1, for the light that the ground sends back up
    float max_error = 0.005F;               // relative error of sky and sunlight that may go unnoticed, >= 0
};

// Output of update_sky: the state of the sky model and the lights behind the air. Light is photometric linear Rec.709
// (see docs/architecture.md).
struct SkyState {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};
    float turbidity = 2.5F;
    // Perez coefficients A..E of Preetham's model for Y, x, y, and its zenith values.
    std::array<float, 5> perez_Y{}, perez_x{}, perez_y{};
    glm::vec3 zenith_Yxy{0.0F, 1.0F / 3.0F, 1.0F / 3.0F}; // Y in cd/m^2 (before `fade`), chromaticity x, y
    glm::vec3 horizon_normalisation{1.0F}; // F(0, theta_sun) for Y, x, y
    float fade = 1.0F;                     // factor on the dome: 1 with the sun over 10 degrees, 0 from -18 down
    glm::vec3 night_radiance_cd_m2{0.0F};  // a dim, uniform floor: starlight and moonlit air
    glm::vec3 sun_illuminance_lux{0.0F};   // on a surface facing the sun, at the ground, through the air
    glm::vec3 moon_illuminance_lux{0.0F};  // likewise for the moon at its phase
    // The inputs that this was made from, beside to_sun and turbidity.
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    float moon_phase_angle_rad = 0.0F;
    float ozone_atm_cm = 0.35F;
    std::uint32_t celestial_revision = 0;
    std::uint32_t revision = 0; // counts recomputations; 0: never made
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
