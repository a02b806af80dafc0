// The clear night sky with its gradients: moonlight scattered in the air after Krisciunas and Schaefer 1991, "A model
// of the brightness of moonlight", and airglow and starlight that brighten towards the horizon.
#pragma once

#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// One moon and one air. Make it with make_night_sky.
struct NightSky {
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    float extinction = 0.4F; // of the vertical column, V: 0.4 ln(10) times the astronomer's k
    // What the two parts of the scattering function (eq. 21 of the paper) are multiplied with in eq. 15, for molecules
    // and aerosol, cd/m^2: the moon's light through its own path and its colour are in it. 0: no moon.
    glm::vec3 molecules{0.0F};
    glm::vec3 aerosol{0.0F};
    glm::vec3 floor_cd_m2{0.0F}; // airglow and starlight at the zenith
};

// phase_angle_rad: 0 full, pi new. Turbidity is held to 1 .. 20. A moon below the horizon fades as the sun's twilight
// does (twilight.hpp) and is gone 18 degrees below.
[[nodiscard]] NightSky make_night_sky(const glm::vec3& to_moon, float moon_distance_m, float phase_angle_rad,
                                      float turbidity);

// Radiance towards a unit vector, linear Rec.709 in cd/m^2; below the horizon the horizon's. Finite, never negative.
[[nodiscard]] glm::vec3 night_radiance(const NightSky& sky, const glm::vec3& direction);

// On spherical harmonics, bands 1 .. 7, in the local frame; nothing comes from below the horizon. Within 1.1 % of the
// vector's norm.
void project_night_sky(const NightSky& sky, int bands, std::span<glm::vec3> out);

} // namespace alpenglow::sky
