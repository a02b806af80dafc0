// The mesh of the sky: rings of vertices from the horizon to the zenith, closer together near the horizon and around
// the sun, where the sky changes fastest. The topology is fixed, the directions follow the sun.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

struct SkyDome {
    static constexpr std::uint32_t azimuths = 96;                 // vertices of a ring
    static constexpr std::uint32_t rings = 33;                    // the first at the horizon, the last at the zenith
    static constexpr std::uint32_t vertices = azimuths * rings;   // ring by ring from the horizon up
    static constexpr std::uint32_t skirt_vertices = 2 * azimuths; // what a renderer adds below the horizon
};

// Writes unit directions into SkyDome::vertices vertices; all have z >= 0. Radiance is the caller's to fill.
void place_sky_vertices(glm::vec3 to_sun, std::span<SkyVertex> vertices);

// Azimuth of a ring's vertex `i` from the sun's, -pi .. pi, as place_sky_vertices() has it.
[[nodiscard]] float sky_azimuth_from_sun(std::uint32_t i);

// Triangles over the dome's vertices followed by the skirt's: a ring a little below the horizon, and the nadir. They
// come patch by patch.
[[nodiscard]] std::vector<std::uint32_t> sky_dome_indices();

// A piece of the dome: a run of triangles, and the directions of their corners.
struct SkyPatch {
    std::uint32_t first_index = 0;
    std::uint32_t index_count = 0;
    std::vector<std::uint32_t> corners; // vertices
};
[[nodiscard]] std::vector<SkyPatch> sky_dome_patches();

// Direction of a vertex of dome or skirt; `vertices` are the dome's.
[[nodiscard]] glm::vec3 sky_direction(std::span<const SkyVertex> vertices, std::uint32_t vertex);

// The runs of triangles, as (first index, count), that a view can see any of.
struct IndexRun {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};
[[nodiscard]] std::vector<IndexRun> visible_sky(std::span<const SkyPatch> patches, std::span<const SkyVertex> vertices,
                                                std::span<const glm::vec3, 4> side_planes);

} // namespace alpenglow::sandbox
