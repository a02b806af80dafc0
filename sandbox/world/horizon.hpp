// Horizon mapping (Max 1988): for each sample of a height field and each of 16 azimuths, the elevation of the terrain's
// horizon, so that sun and moon are known to be hidden without casting a ray.
#pragma once

#include "grid.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

namespace alpenglow::sandbox {

inline constexpr int horizon_azimuths = 16;

// Elevations of the horizon in 8 bits, one an azimuth; azimuth k is nominally 22.5 k degrees from north through east.
using HorizonBytes = std::array<std::uint8_t, horizon_azimuths>;

// 0 .. pi/2 in 8 bits: elevation = pi/2 (v / 255)^2, finest near the horizon (where dawn and dusk need it: 0.35 degrees
// at 10 degrees, half of that rounded). Monotone, so that comparing bytes compares angles. Negative elevations give 0.
[[nodiscard]] std::uint8_t encode_horizon(float tangent) noexcept;
[[nodiscard]] float decode_horizon_rad(std::uint8_t v) noexcept;

// Four azimuths a word, azimuth 0 in the lowest byte of the first word.
[[nodiscard]] std::array<std::uint32_t, 4> pack_horizon(const HorizonBytes& bytes) noexcept;

// The grid direction that stands for azimuth k: a step of (2, 5) stands for 21.80 instead of 22.5 degrees, so that
// lines meet samples again soon.
[[nodiscard]] glm::ivec2 horizon_direction(int azimuth) noexcept;

// Tangents of the horizon's elevation for every sample of `grid` and one azimuth, 0 where nothing rises above it, in
// O(1) amortised a sample: each line of the grid along the azimuth is swept from its far end, keeping the upper convex
// hull of what lies beyond (a point under the hull is never again the highest seen from farther away). Between samples
// the profile is linear across the line of grid it crosses. The Earth's curvature is left out: it lowers a crest 20 km
// away by 31 m, 0.09 degrees.
//
// `beyond`, if given, is a larger field with the same centre: what lies outside `grid` counts too, on lines as far
// apart as its spacing.
[[nodiscard]] std::vector<float> sweep_horizon(const HeightGrid& grid, int azimuth, const HeightGrid* beyond = nullptr);

// All azimuths, encoded.
[[nodiscard]] std::vector<HorizonBytes> compute_horizons(const HeightGrid& grid, const HeightGrid* beyond = nullptr);

// The slow reference: walks the line from sample (i, j) and takes the largest tangent.
[[nodiscard]] float walk_horizon(const HeightGrid& grid, int i, int j, int azimuth);

// Fraction of the sky's light on level ground that the horizon leaves: the mean of cos^2 over azimuths.
[[nodiscard]] float sky_visibility(const HorizonBytes& bytes) noexcept;

} // namespace alpenglow::sandbox
