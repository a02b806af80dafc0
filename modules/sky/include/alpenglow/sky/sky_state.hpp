// The sky as components: from celestial bodies and atmosphere to SkyState and SkyTables, and radiance from them, for
// every SkyModel.
#pragma once

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/result.hpp>
#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/preetham.hpp>

#include <cstdint>
#include <span>

namespace alpenglow::sky {

// Names the field that is out of range, if one is. `height_m` is the observer's, -500 .. 80 000 (below sea level counts
// as sea level).
[[nodiscard]] Status check(const Atmosphere& atmosphere, double height_m = 0.0);

// The sky of a model, and the light of sun and moon at the observer. Domes: faded in twilight; SkyModel::scattering has
// a twilight of its own, down to 18 degrees, and sunlight through the same air. The moon adds the sky that the sun
// would make in its place, scaled, while the sun is down. `atmosphere` has passed check(). Revisions are the caller's
// to set.
[[nodiscard]] SkyState make_sky_state(const CelestialState& celestial, const Atmosphere& atmosphere,
                                      double height_m = 0.0);

// Which tables somebody reads.
struct SkyTableNeeds {
    bool sky_view = false, aerial_perspective = false, transmittance = false;
};

// True if the SH of this state come from the sky view rather than from a fit (altitude, air out of the fit's domain).
[[nodiscard]] bool sh_needs_sky_view(const SkyState& state);

// Builds what is needed of a SkyModel::scattering, and only where the bodies (as in `celestial`), the height or the air
// have moved so far that a table's radiance could be off by more than air.max_error; see docs/sky.md. What is not
// needed is dropped.
struct SkyTableWork {
    std::uint32_t rebuilt = 0; // tables: the atmosphere, each view and each aerial table count one
    std::uint32_t kept = 0;
    double error_bound = 0.0; // of those kept
};
SkyTableWork update_sky_tables(const SkyState& state, const CelestialState& celestial, const SkyTableNeeds& needs,
                               SkyTables& tables);

// Sky radiance towards unit vectors, linear Rec.709 in cd/m^2, without the discs of sun and moon, for any model; out is
// as long as directions. Below the horizon: domes give the radiance of the horizon above, scattering the air and the
// ground. `tables` are read by SkyModel::scattering alone, and must hold a sky view then: without one it is black.
void sky_radiance(const SkyState& state, const SkyTables* tables, std::span<const glm::vec3> directions,
                  std::span<glm::vec3> out);

// What the air of SkyModel::scattering takes and adds over a distance towards a unit direction, from the aerial tables;
// no change where there are none. Domes: aerial_perspective.hpp has the closed form.
[[nodiscard]] AerialPerspective sky_aerial_perspective(const SkyState& state, const SkyTables* tables,
                                                       const glm::vec3& direction, float distance_km);

// The sky of a state, night floor included, on spherical harmonics: cd/m^2, bands * bands coefficients in the local
// frame (bands 1 .. 7). Nothing comes from below the horizon. `tables` as above, where sh_needs_sky_view().
void project_sky_state(const SkyState& state, const SkyTables* tables, int bands, std::span<glm::vec3> out);

// A bound on the relative error of `state` if it were kept for bodies that stand as in `celestial`:
//  sky      |c' - c| / |c|, c the vector of the sky's SH coefficients at 7 bands, all channels;
//  sun      |E' - E| / (|E| + |sky's horizontal illuminance|), moon the same at night.
// Infinite where the state was never made or another atmosphere is asked for.
[[nodiscard]] double drift_bound(const SkyState& state, const CelestialState& celestial, const Atmosphere& atmosphere,
                                 double height_m = 0.0);

// Illuminance of level ground by sun, moon and sky, in lux: for a plot of the day.
struct DayLight {
    glm::vec3 sun_lux{0.0F}, moon_lux{0.0F}, sky_lux{0.0F};
};
[[nodiscard]] DayLight level_illuminance(const SkyState& state, const SkyTables* tables);

// Preetham's sky for a state of that model.
[[nodiscard]] PreethamSky<float> preetham_of(const SkyState& state);
[[nodiscard]] glm::vec3 sky_radiance(const SkyState& state, const PreethamSky<float>& model,
                                     const glm::vec3& direction);

} // namespace alpenglow::sky
