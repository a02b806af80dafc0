// Gradient noise on an integer-hashed lattice (Perlin 2002, with a hash instead of the permutation table): the same
// bits on every machine with IEEE floats.
#pragma once

#include <cmath>
#include <cstdint>

namespace alpenglow::sandbox {

// A well-mixed hash of a lattice point.
[[nodiscard]] constexpr std::uint32_t hash_lattice(std::int32_t x, std::int32_t y, std::uint32_t seed) noexcept {
    std::uint32_t h = seed + static_cast<std::uint32_t>(x) * 0x9E3779B1U + static_cast<std::uint32_t>(y) * 0x85EBCA77U;
    h ^= h >> 15U;
    h *= 0x2C1B3C6DU;
    h ^= h >> 12U;
    h *= 0x297A2D39U;
    h ^= h >> 15U;
    return h;
}

// Uniform in [0, 1).
[[nodiscard]] constexpr float hash_unit(std::int32_t x, std::int32_t y, std::uint32_t seed) noexcept {
    return static_cast<float>(hash_lattice(x, y, seed) >> 8U) * (1.0F / 16777216.0F);
}

// Gradient noise, about -1 .. 1, mean 0, one feature per unit.
[[nodiscard]] float gradient_noise(float x, float y, std::uint32_t seed) noexcept;

// Sum of `octaves` of gradient noise, each half as large and twice as fine as the one before; about -1 .. 1.
[[nodiscard]] float fractal_noise(float x, float y, int octaves, std::uint32_t seed) noexcept;

// Ridged multifractal (Musgrave): sharp crests, each octave weighted by the one before; 0 .. about 1.
[[nodiscard]] float ridged_noise(float x, float y, int octaves, std::uint32_t seed) noexcept;

} // namespace alpenglow::sandbox
