// Aerial perspective in closed form: how far things fade and how much light the air in between adds.
// Preetham and Hoffman, SIGGRAPH course 2003, "Aerial Perspective Model": L_s = f L_0 + L_in with
// L_in = E beta(angle) / beta (1 - e^(-beta s)), extended to molecules and aerosols and to densities that fall with
// height: the aerosol's share of the scattering is a parabola of the optical depth (docs/sky.md).
// shaders/alpenglow/aerial_perspective.glsl is the same code: this module compiles it.
#pragma once

#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Scattering at sea level for the R, G and B channels.
struct Air {
    glm::vec3 rayleigh_per_m{5.8e-6F, 13.5e-6F, 33.1e-6F}; // molecules, at 680, 550 and 440 nm
    glm::vec3 mie_per_m{2.0e-5F};                          // aerosol
    float rayleigh_height_m = 8000.0F;                     // scale heights of the densities
    float mie_height_m = 1250.0F;
    float mie_g = 0.76F; // mean cosine, Henyey-Greenstein
};

struct AerialPerspective {
    glm::vec3 transmittance; // f, 0 .. 1
    glm::vec3 in_scatter;    // L_in, cd/m^2
};

// The air of a turbidity (clamped to 1 .. 20): aerosol depth by Angstrom's formula with Preetham's beta, over a scale
// height of 1.25 km.
[[nodiscard]] Air make_air(float turbidity);

// Mean of exp(-height / scale) along a path, times its length, in metres: the optical length for one kind of particle.
// The path starts at height_m and climbs `rise` metres a metre (-1 .. 1), over a flat Earth.
[[nodiscard]] float optical_length_m(float height_m, float rise, float distance_m, float scale_m);

// For a viewer at height_m above sea level looking along the unit `direction` over distance_m >= 0. `sun_lux` is the
// light's illuminance at the viewer on a surface facing it; `ambient_cd_m2` the mean radiance from all around.
// Error against a 4000-step march of the same air: stated in docs/sky.md. Light along the path is taken as at the
// viewer.
[[nodiscard]] AerialPerspective aerial_perspective(const Air& air, float height_m, const glm::vec3& direction,
                                                   float distance_m, const glm::vec3& to_sun, const glm::vec3& sun_lux,
                                                   const glm::vec3& ambient_cd_m2);

// Many paths from one place at once, structure of arrays, with the widest SIMD at hand: an image's pixels. All spans
// have the same length. Within 1e-4 of the scalar function (relative; absolute for the transmittance).
struct AerialPaths {
    std::span<const float> x, y, z; // unit directions
    std::span<const float> distance_m;
};
struct AerialPerspectives {
    std::span<float> transmittance_r, transmittance_g, transmittance_b;
    std::span<float> in_scatter_r, in_scatter_g, in_scatter_b;
};
void aerial_perspective(const Air& air, float height_m, const glm::vec3& to_sun, const glm::vec3& sun_lux,
                        const glm::vec3& ambient_cd_m2, const AerialPaths& paths, const AerialPerspectives& out);

// The same by marching `steps` equal steps in double precision: the reference.
[[nodiscard]] AerialPerspective march_aerial_perspective(const Air& air, float height_m, const glm::vec3& direction,
                                                         float distance_m, const glm::vec3& to_sun,
                                                         const glm::vec3& sun_lux, const glm::vec3& ambient_cd_m2,
                                                         int steps);

} // namespace alpenglow::sky
