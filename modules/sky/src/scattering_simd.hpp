// Inner loops of the scattering tables. Lanes run over the sun's angle or over azimuth; everything that depends on
// height alone is the same for all lanes and comes in as plain numbers.
#pragma once

#include <cstddef>
#include <cstdint>

namespace alpenglow::sky {

// One step of a ray.
struct MarchStep {
    float distance_km;         // from the viewer
    float inverse_r;           // 1 / (radius at the step), per km
    float mu_horizon;          // of the step's height
    float rayleigh[3], mie[3]; // light scattered by molecules and aerosol per unit of source: transmittance to the
                               // viewer times the step's scattering
};

// A table row for one height: channel by angle.
struct AngleRow {
    const float* values;
    std::size_t stride; // between channels
    float low, scale;   // index = (w - low) scale
    float last;         // largest index, a little under the last entry
};

inline constexpr std::size_t march_lanes = 16; // lanes a call works on

// Light of the sun scattered once along a ray, without phase functions: by molecules, by aerosol and, with kinds = 3,
// the two aureoles by aerosol. r0_mu_s: viewer's radius times mu_s, and nu: cosine to the sun, for march_lanes suns.
// sun: rows for each step. out[1 + kinds][channel].
void march_single(const MarchStep* steps, std::size_t count, const AngleRow* sun, std::size_t kinds,
                  const float* r0_mu_s, const float* nu, float (*out)[3][march_lanes]);

// Light of the field scattered again along a ray. field: for each step functions x channels rows (stride between them),
// already weighted by phase and scattering. mu: the ray's cosine to the zenith at the viewer.
void march_field(const MarchStep* steps, std::size_t count, const AngleRow* field, std::size_t functions, float r0,
                 float mu, const float* mu_s, const float* nu, float (*out)[march_lanes]);

// Transmittance t to the top of the shell for march_lanes cosines from one height; t d, t (e^d - 1 - d) and t d^2 / 2
// for the aerosol's scattering depth d. out[12].
struct ShellKernel {
    float radius_km, top_km, rayleigh_height_km, mie_height_km;
    float rayleigh[3], mie[3], ozone[3], mie_scattering[3]; // mie: extinction
};
void shell_transmittance(const ShellKernel& shell, float height_km, const float* mu, float (*out)[march_lanes]);

} // namespace alpenglow::sky
