// The clear sky as components: from celestial bodies and atmosphere to SkyState, and radiance from it.
#pragma once

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/result.hpp>
#include <alpenglow/sky/preetham.hpp>

#include <span>

namespace alpenglow::sky {

// Names the field that is out of range, if one is.
[[nodiscard]] Status check(const Atmosphere& atmosphere);

// Preetham's sky, faded in twilight, the night's floor with the moonlit air on it, and the light of sun and moon at the
// ground. `atmosphere` has passed check(). Revisions are the caller's to set.
[[nodiscard]] SkyState make_sky_state(const CelestialState& celestial, const Atmosphere& atmosphere);

// The model that a state describes.
[[nodiscard]] PreethamSky<float> preetham_of(const SkyState& state);

// Sky radiance towards a unit vector, linear Rec.709 in cd/m^2, without the discs of sun and moon. Below the horizon:
// the radiance of the horizon above.
[[nodiscard]] glm::vec3 sky_radiance(const SkyState& state, const PreethamSky<float>& model,
                                     const glm::vec3& direction);

// The sky of a state, night floor included, on spherical harmonics: cd/m^2, bands * bands coefficients in the local
// frame (bands 1 .. 7). Nothing comes from below the horizon.
void project_sky_state(const SkyState& state, int bands, std::span<glm::vec3> out);

// A bound on the relative error of `state` if it were kept for bodies that stand as in `celestial`:
//  sky      |c' - c| / |c|, c the vector of the sky's SH coefficients at 7 bands, all channels;
//  sun      |E' - E| / (|E| + |sky's horizontal illuminance|), moon the same at night.
// Infinite where the state was never made or another atmosphere is asked for.
[[nodiscard]] double drift_bound(const SkyState& state, const CelestialState& celestial, const Atmosphere& atmosphere);

} // namespace alpenglow::sky
