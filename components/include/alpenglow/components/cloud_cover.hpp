// What clouds leave of the light of sky, sun and moon at a place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow {

// Input: a place below or among clouds. On the entity of a ProbeGrid or LightProbe, update_probes takes the light that
// clouds leave in place of the clear sky's.
struct CloudCover {
    glm::vec3 position_m{0.0F};
};

// Output, of whoever knows the clouds.
struct CloudCoverLight {
    std::array<glm::vec3, 16>
        sky{}; // radiance of the sky behind the clouds and of the clouds: SH up to band 3, SkyLightSh's
               // unit and order, below a clear sky whose first coefficient is `clear`
    glm::vec3 clear{1.0F};
    float open = 1.0F;          // transmittance of the sky, its mean over the upper hemisphere, 0 .. 1
    float sun = 1.0F;           // transmittance towards the sun, 0 .. 1
    float moon = 1.0F;          // and the moon
    std::uint32_t revision = 0; // counts changes; 0: never made, the light is the clear sky's
};

// Puts the light below the clouds in the place of the clear sky's, of which `sky` has any number of bands. What has
// changed of the clear sky's brightness and colour since the cover was made changes the light below likewise. Bands
// beyond the third keep the share of the sky that is open.
inline void put_below_clouds(const CloudCoverLight& cover, std::span<glm::vec3> sky) {
    if (cover.revision == 0 || sky.empty()) {
        return;
    }
    glm::vec3 scale(1.0F);
    for (int c = 0; c < 3; ++c) {
        scale[c] = sky[0][c] / std::max(cover.clear[c], 1e-12F);
    }
    for (std::size_t k = 0; k < sky.size(); ++k) {
        sky[k] = k < cover.sky.size() ? cover.sky[k] * scale : sky[k] * cover.open;
    }
}

} // namespace alpenglow
