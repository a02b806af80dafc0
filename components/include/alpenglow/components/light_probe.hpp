// Light at a point, on spherical harmonics: what lights dynamic objects.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include <glm/vec3.hpp>

namespace alpenglow {

inline constexpr int max_probe_order = 5;
inline constexpr int max_probe_coefficients = max_probe_order * max_probe_order;

// How negative lobes of irradiance are kept away (docs/probes.md, docs/sh.md).
enum class Deringing : std::uint8_t {
    none,  // the projection as it is: negative light behind strong sources
    paper, // Sloan 2017: punctual lights through 0.92, 0.73, then the conservative bound and the table of windows
    exact, // the least window under which the irradiance is nowhere negative
};

// Where a probe's light comes from, beside sun and moon, which are always added as punctual lights.
enum class ProbeSource : std::uint8_t {
    assembled, // sky, less what stands before it, and the light that the ground sends back
    captured,  // a cube map of the scene, rendered by the game (probes/capture.hpp)
};

// The light that all probes of a scene share. Photometric linear Rec.709 in the local frame (docs/architecture.md).
struct ProbeSources {
    std::array<glm::vec3, max_probe_coefficients> sky{}; // radiance on SH, cd/m^2
    int order = 0;                                       // valid bands of `sky`
    bool whole_sphere = false;           // `sky` holds the light from below the horizon too: no ground is added
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};  // unit
    glm::vec3 to_moon{0.0F, 0.0F, 1.0F}; // unit
    glm::vec3 sun_lux{0.0F};             // on a surface facing the sun
    glm::vec3 moon_lux{0.0F};
};

// Input: a probe of its own. It lights the receivers within its radius that no grid contains, the nearest probe first.
struct LightProbe {
    glm::vec3 position_m{0.0F};
    float radius_m = std::numeric_limits<float>::infinity();
    int order = 3; // 1 .. max_probe_order
    Deringing deringing = Deringing::exact;
    ProbeSource source = ProbeSource::assembled;
    float max_error = 0.01F;       // as ProbeGrid::max_error
    float sun_visibility = 1.0F;   // 0 .. 1
    float moon_visibility = 1.0F;  // 0 .. 1
    glm::vec3 ground_albedo{0.2F}; // linear Rec.709, 0 .. 1
};

// Output of update_probes: a LightProbe's radiance, cd/m^2, deringed.
struct LightProbeSh {
    std::array<glm::vec3, max_probe_coefficients> coefficients{};
    int order = 0; // 0: never made
    ProbeSources made_from;
    LightProbe made_as;
    std::uint32_t revision = 0; // counts recomputations
};

} // namespace alpenglow
