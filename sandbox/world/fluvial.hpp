// Mountains as uplift against rivers: the stream-power law dh/dt = U - K A^m S, solved implicitly along the drainage
// tree in O(n) (Braun and Willett 2013; used for terrain by Cordonnier et al. 2016), with slopes limited to a talus
// angle.
#pragma once

#include "grid.hpp"

#include <cstdint>
#include <vector>

namespace alpenglow::sandbox {

enum class Node : std::uint8_t {
    free,    // rises and is eroded
    base,    // fixed height, water leaves the model here
    through, // fixed height, water flows on
};

struct FluvialModel {
    std::vector<Node> node;             // one a sample
    std::vector<float> uplift_m;        // per step, of a free sample
    std::vector<float> talus;           // largest slope towards the receiver
    std::vector<float> inflow_m2;       // drainage area that enters from outside; empty for none
    std::vector<float> area_m2;         // out: drainage area of each sample
    std::vector<std::int32_t> receiver; // out: the sample that each one drains to, itself if none
    float erodibility = 0.0F;           // K dt / m^(2m-1), with m = 1/2: dimensionless
    std::uint32_t seed = 0;             // jitters flow directions, so that eight directions do not show
};

// Runs `steps` steps on `grid`. Flow directions are found in parallel; the result does not depend on the thread count.
void erode(HeightGrid& grid, FluvialModel& model, int steps);

} // namespace alpenglow::sandbox
