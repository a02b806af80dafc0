// Inner loops of the scattering tables. Lanes run over the sun's angle or over azimuth; everything that depends on
// height alone is the same for all lanes and comes in as plain numbers.
#pragma once

#include <cstddef>

namespace alpenglow::sky {

inline constexpr std::size_t march_lanes = 16; // lanes a call works on

// The shell as the kernels see it; coefficients per km.
struct ShellKernel {
    float radius_km, top_km, rayleigh_height_km, mie_height_km;
    float rayleigh[3], mie[3], ozone[3], mie_scattering[3]; // mie: extinction
    float forward;                                          // share of aerosol's scattering that goes straight on
    float inverse_disc;                                     // 1 / angular radius of the sun
};

// One step of a ray.
struct MarchStep {
    float distance_km;         // from the viewer
    float inverse_r;           // 1 / (radius at the step), per km
    float mu_horizon;          // of the step's height
    float inverse_sine;        // 1 / sine of the horizon's zenith angle
    float rayleigh[3], mie[3]; // light scattered by molecules and aerosol per unit of source: transmittance to the
                               // viewer times the step's scattering
};

// Columns of air towards the sun at a step's height: rows of `stride` angles for molecules, aerosol and ozone.
struct SunRow {
    const float* values;
    std::size_t stride;
    float scale; // index = w scale
    float last;  // largest index, a little under the last entry
};

// Light of the sun scattered once along a ray, without phase functions: [0] by molecules, [1] by aerosol, [2] its
// aureole by aerosol. r0_mu_s: viewer's radius times mu_s, and nu: cosine to the sun, for march_lanes suns.
void march_single(const ShellKernel& shell, const MarchStep* steps, std::size_t count, const SunRow* sun,
                  const float* r0_mu_s, const float* nu, float (*out)[3][march_lanes]);

// Light of the field scattered again along a ray. For each step `modes` x 3 rows of `stride` sun angles from `low_rad`
// on, already weighted by phase and scattering, for the cosines of multiples of the azimuth.
struct FieldRow {
    const float* values;
    std::size_t stride;
    float low_rad, scale, last;
};
void march_field(const MarchStep* steps, std::size_t count, const FieldRow* field, std::size_t modes, float r0,
                 float mu, const float* mu_s, const float* nu, float (*out)[march_lanes]);

// Columns of molecules, aerosol and ozone out of the shell, for march_lanes cosines from one height.
void shell_columns(const ShellKernel& shell, float height_km, const float* mu, float (*out)[march_lanes]);

// to[j] = sum_i sum_k w[i][k] x[i][k * stride + j]: `terms` rows of two heights.
void blend_rows(const float* low, const float* high, const float* low_weights, const float* high_weights,
                std::size_t stride, std::size_t terms, std::size_t count, float* to);

} // namespace alpenglow::sky
