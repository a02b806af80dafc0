// Light from an image of the surroundings.
#pragma once

#include <alpenglow/components/light_probe.hpp>

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow {

// Input: an equirectangular image; probes::load_environment reads one from an .hdr file. It takes the place of the sky
// for all probes of the scene. Row 0 is at the zenith; the middle column looks north (+Y), and columns to its right
// towards the east (+X), as in a photograph.
struct EnvironmentMap {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> radiance; // cd/m^2 once multiplied by `scale`, row by row
    float scale = 1.0F;
    float azimuth_rad = 0.0F;   // turns the image about the zenith, from north towards east
    int order = 3;              // 1 .. max_probe_order
    std::uint32_t revision = 1; // to be raised after a change
};

// Output of update_probes.
struct EnvironmentMapSh {
    std::array<glm::vec3, max_probe_coefficients> coefficients{}; // radiance, cd/m^2, as projected
    std::array<glm::vec3, max_probe_coefficients> deringed{}; // exact deringing, for receivers that no probe reaches
    int order = 0;
    std::uint32_t map_revision = 0;
    std::uint32_t revision = 0;
};

} // namespace alpenglow
