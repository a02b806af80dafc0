// The light that meets the things of the scene `transfer`: sky, sun, moon and ground on spherical harmonics.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/sky.hpp>

#include "sandbox/app/lighting.hpp"
#include "sandbox/scene/transfer_settings.hpp"
#include "sandbox/world/horizon.hpp"

namespace alpenglow::sandbox {

inline constexpr int transfer_bands = 5;

// Radiance, cd/m^2, transfer_bands^2 coefficients, the scene's frame.
struct TransferLight {
    std::vector<glm::vec3> coefficients; // through the window that was asked for
    std::vector<glm::vec3> sure;         // nowhere negative
    float window = 1.0F;                 // what deringing leaves of band 1 in `coefficients`
};

// Sky, the discs of sun and moon as far as the terrain's horizon leaves them, and the ground's light from below,
// windowed together by the Gauss family. `sky_light` has at least transfer_bands.
[[nodiscard]] TransferLight transfer_light(const SceneLight& light, const CelestialState& celestial,
                                           const SkyState& sky, const SkyLightSh& sky_light,
                                           const Atmosphere& atmosphere, const HorizonBytes& horizon,
                                           TransferWindow window);

} // namespace alpenglow::sandbox
