// The light that meets the things of the scene `transfer`: sky, sun, moon and ground on spherical harmonics.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>

#include "sandbox/app/lighting.hpp"
#include "sandbox/world/horizon.hpp"

namespace alpenglow::sandbox {

inline constexpr int transfer_bands = 5;

struct TransferLight {
    std::vector<glm::vec3> coefficients; // radiance, cd/m^2, transfer_bands^2, the scene's frame
    float window = 1.0F;                 // what deringing leaves of band 1
};

// Sky, the discs of sun and moon as far as the terrain's horizon leaves them, and the ground's light from below;
// windowed together, with the least window of the Gauss family that keeps the radiance from going negative: what stands
// behind a thing would else be lit less than not at all. `sky_light` has at least transfer_bands.
[[nodiscard]] TransferLight transfer_light(const SceneLight& light, const CelestialState& celestial,
                                           const SkyState& sky, const SkyLightSh& sky_light,
                                           const Atmosphere& atmosphere, const HorizonBytes& horizon);

} // namespace alpenglow::sandbox
