// Output of update_ephemeris: where sun, moon and the fixed stars stand over the observer's horizon.
#pragma once

#include <cstdint>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow {

// Directions are unit vectors in the local east-north-up frame, from the observer (topocentric), without refraction.
struct CelestialState {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    double sun_distance_m = 1.495978707e11;
    double moon_distance_m = 3.844e8;
    float sun_angular_radius_rad = 4.6542e-3F;
    float moon_angular_radius_rad = 4.52e-3F;
    float moon_phase_angle_rad = 0.0F;      // sun-moon-observer: 0 full, pi new
    float moon_illuminated_fraction = 1.0F; // (1 + cos(phase angle)) / 2
    glm::dmat3 local_from_equatorial{1.0};  // mean equator of J2000 -> local east-north-up: for the stars
    glm::dmat3 local_from_moon{1.0};        // the moon's body axes -> local east-north-up
    // The inputs that this was made from; NaN until the first update.
    double made_from_utc_j2000_s = __builtin_nan("");
    double made_from_latitude_rad = 0.0;
    double made_from_longitude_rad = 0.0;
    double made_from_height_m = 0.0;
    double made_from_delta_t_s = 0.0;
    std::uint32_t revision = 0; // counts recomputations
};

} // namespace alpenglow
