// A scattering atmosphere: a spherical shell of molecules, aerosol and ozone over a reflecting ground. The
// double-precision oracle is here; the tables that run time reads are in scattering_tables.hpp.
//
// Single and multiple scattering as in the course (SIGGRAPH 2003, "Skylight Models": I^1, I^2, ...), in three channels
// with effective coefficients at 680, 550 and 440 nm (Bruneton and Neyret 2008); light is photometric linear Rec.709.
#pragma once

#include <alpenglow/core/result.hpp>

#include <cstdint>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Lengths in kilometres, coefficients per kilometre at sea level.
struct ScatteringAtmosphere {
    double ground_radius_km = 6360.0;
    double top_km = 100.0; // height of the shell
    glm::dvec3 rayleigh_per_km{5.802e-3, 13.558e-3, 33.1e-3};
    double rayleigh_height_km = 8.0;
    glm::dvec3 mie_scattering_per_km{3.996e-3};
    glm::dvec3 mie_absorption_per_km{0.444e-3};
    double mie_height_km = 1.2;
    double mie_g = 0.8; // Cornette-Shanks
    // At 25 km, falling linearly to 0 at 10 and 40 km. Mean of the spectral absorption (Preetham et al. 1999, table 2)
    // under the Rec. 709 channels and the sun's spectrum: through 30 times the column it changes by 3 %.
    glm::dvec3 ozone_per_km{2.42e-3, 1.61e-3, 0.0};
    glm::dvec3 ground_albedo{0.2};
    glm::dvec3 sun_lux{133334.0}; // outside the air
    double sun_angular_radius_rad = 4.6542e-3;
};

// The aerosol of a turbidity (1 .. 10): depth by Angstrom's formula with Preetham's beta, over 1.2 km,
// single-scattering albedo 0.9; ozone in proportion to its column. Errors name the parameter.
[[nodiscard]] Result<ScatteringAtmosphere> make_scattering_atmosphere(double turbidity, double ozone_atm_cm,
                                                                      const glm::dvec3& ground_albedo);

// Scattering and extinction at a height, per km.
struct AirSample {
    glm::dvec3 rayleigh, mie, extinction;
};
[[nodiscard]] AirSample sample_air(const ScatteringAtmosphere& air, double height_km);

// Where a ray from `height_km` with cosine `mu` to the zenith leaves: at the ground, or at the top of the shell. A
// viewer above the shell begins where the ray enters it; length 0 where it misses.
struct RaySpan {
    double begin_km = 0.0, end_km = 0.0;
    bool ground = false;
};
[[nodiscard]] RaySpan ray_span(const ScatteringAtmosphere& air, double height_km, double mu);

// Optical depth along a ray from begin to end (`steps` Gauss-Legendre intervals of 4 nodes).
[[nodiscard]] glm::dvec3 optical_depth(const ScatteringAtmosphere& air, double height_km, double mu, double begin_km,
                                       double end_km, int steps);

// Light of the sun at a height for a cosine mu_s of its zenith angle, relative to outside: transmittance times the
// visible part of the disc over the Earth's limb. The oracle's; steps as above.
[[nodiscard]] glm::dvec3 sun_transmittance(const ScatteringAtmosphere& air, double height_km, double mu_s,
                                           int steps = 64);

// Single scattering towards a viewer at height_km looking along mu (cosine to the zenith), nu = cosine to the sun, and
// the sunlit ground behind it: `steps` equal-depth midpoint steps. cd/m^2.
[[nodiscard]] glm::dvec3 single_scattering(const ScatteringAtmosphere& air, double height_km, double mu, double mu_s,
                                           double nu, int steps);

// All orders by tracing paths backwards, `paths` for each channel, seeded: unbiased, for the reference. Returns mean
// and standard error.
struct MonteCarlo {
    glm::dvec3 mean{0.0}, standard_error{0.0};
};
[[nodiscard]] MonteCarlo trace_radiance(const ScatteringAtmosphere& air, double height_km, double mu, double mu_s,
                                        double azimuth_rad, int paths, std::uint64_t seed, int least_order = 1);

} // namespace alpenglow::sky
