// What is lit by probes.
#pragma once

#include <alpenglow/components/light_probe.hpp>

#include <array>
#include <cstdint>
#include <limits>

#include <glm/vec3.hpp>

namespace alpenglow {

// Input: a point that wants light, usually an object's centre. Probes that light no visible receiver are not updated.
struct ProbeReceiver {
    glm::vec3 position_m{0.0F}; // local frame
    bool visible = true;
};

// Output of update_probe_receivers: the light at the receiver. Radiance, cd/m^2; irradiance is nowhere negative.
struct ReceiverSh {
    enum class Source : std::uint8_t { none, grid, probe, environment };

    std::array<glm::vec3, max_probe_coefficients> coefficients{};
    int order = 0; // valid bands
    Source source = Source::none;
    glm::vec3 made_from_position_m{std::numeric_limits<float>::quiet_NaN()};
    std::uint32_t source_revision = 0;
    std::uint32_t source_id = 0; // which of the scene's sources of that kind
    std::uint32_t revision = 0;  // counts recomputations
};

} // namespace alpenglow
