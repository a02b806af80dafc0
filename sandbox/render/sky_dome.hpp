// The mesh of the sky: rings of vertices from the horizon to the zenith, closer together near the horizon and around
// the light that makes the sky, where it changes fastest, and some from the horizon down to the nadir, for what no
// ground hides. The topology is fixed, the directions follow the light.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

struct SkyDome {
    static constexpr std::uint32_t azimuths = 96;   // vertices of a ring
    static constexpr std::uint32_t rings = 33;      // the first at the horizon, the last at the zenith
    static constexpr std::uint32_t rings_below = 6; // under the horizon, the last at the nadir
    // Ring by ring from the horizon up, then from the horizon down.
    static constexpr std::uint32_t vertices_above = azimuths * rings;
    static constexpr std::uint32_t vertices = vertices_above + azimuths * rings_below;
};

// Writes unit directions into SkyDome::vertices vertices around a light. `horizon_rad`: elevation of the horizon, -0.5
// .. 0. Radiance is the caller's to fill.
void place_sky_vertices(glm::vec3 to_light, float horizon_rad, std::span<SkyVertex> vertices);

// Azimuth of a ring's vertex `i` from the light's, -pi .. pi, as place_sky_vertices() has it.
[[nodiscard]] float sky_azimuth_from_light(std::uint32_t i);

// Triangles over the dome's vertices, patch by patch.
[[nodiscard]] std::vector<std::uint32_t> sky_dome_indices();

// A piece of the dome: a run of triangles, and the directions of their corners.
struct SkyPatch {
    std::uint32_t first_index = 0;
    std::uint32_t index_count = 0;
    std::vector<std::uint32_t> corners; // vertices
};
[[nodiscard]] std::vector<SkyPatch> sky_dome_patches();

// The runs of triangles, as (first index, count), that a view can see any of.
struct IndexRun {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};
[[nodiscard]] std::vector<IndexRun> visible_sky(std::span<const SkyPatch> patches, std::span<const SkyVertex> vertices,
                                                std::span<const glm::vec3, 4> side_planes);

} // namespace alpenglow::sandbox
