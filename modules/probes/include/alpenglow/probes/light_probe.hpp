// Probes that stand alone, and the light that all probes take.
#pragma once

#include <alpenglow/components/environment_map.hpp>
#include <alpenglow/components/light_probe.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/result.hpp>
#include <alpenglow/probes/capture.hpp>
#include <alpenglow/probes/update.hpp>

#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

// Sun and moon from the sky's state, and the sky's radiance as far as it was projected. `light` may be null.
void take_sky(const SkyState& state, const SkyLightSh* light, ProbeSources& sources);
// An environment in place of the sky. Its sun is in the image: a sun from take_sky() is taken out.
void take_environment(const EnvironmentMapSh& light, ProbeSources& sources);

// Projects a map that is `used` again where its revision, order, scale or azimuth has changed. A map that check()
// refuses keeps the light it had; an item in all cases.
UpdateCounts update_environment(const EnvironmentMap& map, EnvironmentMapSh& light, bool used);
// False where the map would have to be projected and check() refuses it.
[[nodiscard]] bool usable(const EnvironmentMap& map, const EnvironmentMapSh& light);

// Names the field that is out of range, if one is.
[[nodiscard]] Status check(const LightProbe& probe);

// Whether any of the positions is within the probe's radius.
[[nodiscard]] bool reaches_any(const LightProbe& probe, std::span<const glm::vec3> positions_m);

// Makes the light of a probe that has passed check(), if somebody needs it, and it or the sources have changed by more
// than max_error: |change| / (|S| + |D_sun| + |D_moon|), found by making the light and comparing, except where nothing
// at all has changed. A captured probe is rendered when the assembled light of its place would have changed as much.
UpdateCounts update_light_probe(const LightProbe& probe, LightProbeSh& light, const ProbeSources& sources, bool needed,
                                const Capture& capture = {});

} // namespace alpenglow::probes
