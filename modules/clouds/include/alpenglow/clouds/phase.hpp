// Phase functions of droplets and the medium they make up.
#pragma once

#include <span>

namespace alpenglow::clouds {

enum class PhaseKind {
    henyey_greenstein,        // Henyey & Greenstein 1941; course notes, cloud rendering, eq. 4
    double_henyey_greenstein, // weight * HG(g) + (1 - weight) * HG(g2)
    cornette_shanks,          // Cornette & Shanks 1992
    rayleigh                  // 3/4 (1 + cos^2): what Harris's pictures use (eq. 3)
};

// A phase function of the angle between the directions of travel before and after scattering. It integrates to 1 over
// the sphere (Harris's p integrates to 4 pi).
struct Phase {
    PhaseKind kind = PhaseKind::henyey_greenstein;
    float g = 0.85F;      // -1 < g < 1, forward positive; values nearer to +-1 than 1e-6 are taken as +-(1 - 1e-6)
    float g2 = -0.3F;     // the second lobe
    float weight = 0.85F; // of the first lobe
};

// Value in 1/sr. Takes 1 - cos(angle), which float can hold near the forward peak (0 .. 2).
[[nodiscard]] float phase_value(const Phase& phase, float one_minus_cos);

// A cosine with density 2 pi phase(cos) for u in [0, 1).
[[nodiscard]] float sample_phase_cos(const Phase& phase, float u);

// Legendre moments chi_l = 2 pi integral of p(mu) P_l(mu) for l = 0 .. moments.size() - 1; chi_0 = 1.
void phase_moments(const Phase& phase, std::span<double> moments);

// Extinction and scattering of the cloud's matter.
struct Medium {
    float extinction_per_m = 0.05F; // at density 1
    float albedo = 0.999F;          // single-scattering albedo, 0 .. 1
    Phase phase;
};

} // namespace alpenglow::clouds
