// The section `flight` of a scene: a path that the camera follows.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

class Reader;

struct FlightKey {
    double time_s = 0.0;
    glm::vec3 position_m{0.0F}; // east, north of the landscape's middle; above sea level
    float yaw_deg = 0.0F;       // turns between keys go the shorter way
    float pitch_deg = 0.0F;
};

struct FlightSettings {
    std::vector<FlightKey> keys; // two or more, times ascending
    bool loop = true;            // from the last key back to the first at once
};

[[nodiscard]] FlightSettings read_flight_settings(Reader& section);

} // namespace alpenglow::sandbox
