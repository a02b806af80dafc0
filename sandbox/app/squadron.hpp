// A field of clouds, and aircraft on closed paths through it: all of it from a few numbers, the same in every run.
#pragma once

#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "sandbox/world/probe_render_data.hpp"

namespace alpenglow::sandbox {

// Where the clouds of a field stand: `count` places over a square of side `field_m` about the landscape's middle, on a
// jittered grid, their bases within 120 m above `base_m`.
[[nodiscard]] std::vector<glm::dvec3> cloud_places(int count, double field_m, double base_m);

// A closed path (Catmull and Rom's spline) that leads through some clouds and past others.
class FlightPath {
public:
    FlightPath() = default;
    explicit FlightPath(const std::vector<glm::dvec3>& clouds, double field_m, double base_m);

    [[nodiscard]] glm::dvec3 at(double metres) const; // along the path, about; any number
    [[nodiscard]] double length_m() const { return length_m_; }

private:
    std::vector<glm::dvec3> points_;
    double length_m_ = 0.0;
};

struct Craft {
    glm::dvec3 position_m{0.0};
    glm::mat3 axes{1.0F}; // right, forward, up
    float radius_m = 16.0F;
};

// The squadron at a time: a wedge along the path, each banked into its turn.
[[nodiscard]] std::vector<Craft> squadron_at(const FlightPath& path, int count, double time_s);

// The light on the craft, for their meshes.
struct CraftLight {
    glm::vec3 to_light{0.0F, 0.0F, 1.0F};
    glm::vec3 direct{1.0F};  // irradiance over pi, as it arrives at this craft
    glm::vec3 ambient{0.3F}; // likewise, from all around
};
// Appends the craft's triangles with their radiance.
void append_craft(const Craft& craft, const CraftLight& light, std::vector<ColorVertex>& triangles);

} // namespace alpenglow::sandbox
