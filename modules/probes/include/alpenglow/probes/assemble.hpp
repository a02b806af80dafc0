// A probe's light from the light of the scene.
//
// With O the part of the upper hemisphere that something stands before (1 blocked, 0 open) and H the lower hemisphere,
//   indirect = S - [S O] + G (H + O),  G = albedo / pi (E(S - [S O]) + v_sun E_sun sin a_sun + v_moon E_moon sin
//   a_moon) direct   = v_sun D_sun + v_moon D_moon
// where S is the sky's radiance, [S O] the projection of the product, E() the irradiance of the level ground (not below
// 0), a the altitude, v the visibility at the probe, also of the ground that it sees, and D a punctual light. What
// stands before the sky is taken to be as bright as the ground. Direct and indirect light are deringed apart (Sloan
// 2017, section 3): D once for all probes, since its factors do not depend on direction or strength, and the indirect
// light of each probe for itself. The sum of two lights that are nowhere negative is nowhere negative.
#pragma once

#include <alpenglow/components/probe_grid.hpp>

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

using ProbeCoefficients = std::array<glm::vec3, max_probe_coefficients>;

// Makes the light of the probes named (valid ones of a prepared grid), from light.target. Each is computed by itself: a
// probe with an occlusion, albedo or visibility that is not finite counts as made of nothing, is kept out of blending,
// and touches no other. `indirect`, if given, holds sky and bounce of each of them as captured, order*order
// coefficients a probe, in place of the sum above. Order 3, exact deringing: see docs/probes.md for what it costs.
void assemble(const ProbeGrid& grid, std::span<const std::uint32_t> probes, ProbeGridSh& light,
              std::span<const glm::vec3> indirect = {});

// What one probe is made of beside the sources.
struct ProbeInput {
    float sun_visibility = 1.0F;
    float moon_visibility = 1.0F;
    glm::vec3 albedo{0.2F};
    std::span<const float> occlusion{};    // order * order, or empty
    std::span<const glm::vec3> indirect{}; // as captured, order * order, or empty
};
// The light of one probe, in double: the reference of assemble(), and what LightProbes are made by.
[[nodiscard]] ProbeCoefficients assemble_reference(int order, Deringing deringing, const ProbeSources& sources,
                                                   const ProbeInput& input);

// The light of sun and moon where nothing stands before them: D_sun and D_moon.
struct DirectLight {
    ProbeCoefficients sun{}, moon{};
};
[[nodiscard]] DirectLight direct_light(int order, Deringing deringing, const ProbeSources& sources);

// Bounds on the distance between a probe's coefficients as made from one set of sources and as they would be made from
// another, over all channels, divided by |S| + |D_sun| + |D_moon| of the new sources. Valid for every probe of the
// grid. Visibilities may have changed too, by dv: add per_sun_visibility |dv_sun| + per_moon_visibility |dv_moon|.
// Infinite where there is nothing to compare with. docs/probes.md has the derivation. Captured probes: as long as the
// scene sends back no more than ground of the same albedo would.
struct DriftBound {
    double sources = 0.0;
    double per_sun_visibility = 0.0;
    double per_moon_visibility = 0.0;
};
[[nodiscard]] DriftBound drift_bound(const ProbeGrid& grid, const ProbeGridSh& light, const ProbeSources& now);

// Of the sources alone: coefficients that are not finite, directions that are not unit.
[[nodiscard]] bool usable(const ProbeSources& sources) noexcept;

} // namespace alpenglow::probes
