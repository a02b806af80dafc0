// Lattice noise from integer hashes: no tables, no state.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace alpenglow::clouds {

inline std::uint32_t hash(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352dU;
    x ^= x >> 15;
    x *= 0x846ca68bU;
    x ^= x >> 16;
    return x;
}

inline std::uint32_t hash(int x, int y, int z, std::uint32_t seed) {
    return hash(static_cast<std::uint32_t>(x) * 0x9e3779b1U ^
                hash(static_cast<std::uint32_t>(y) * 0x85ebca77U ^
                     hash(static_cast<std::uint32_t>(z) * 0xc2b2ae3dU ^ hash(seed))));
}

inline float unit_float(std::uint32_t h) {
    return static_cast<float>(h >> 8) * 0x1p-24F;
} // [0, 1)

// Gradient noise, about -1 .. 1.
inline float perlin(float x, float y, float z, std::uint32_t seed) {
    const float fx = std::floor(x);
    const float fy = std::floor(y);
    const float fz = std::floor(z);
    const int ix = static_cast<int>(fx);
    const int iy = static_cast<int>(fy);
    const int iz = static_cast<int>(fz);
    const float tx = x - fx;
    const float ty = y - fy;
    const float tz = z - fz;
    const auto fade = [](float t) { return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F); };
    const auto corner = [&](int dx, int dy, int dz) {
        const std::uint32_t h = hash(ix + dx, iy + dy, iz + dz, seed);
        const float gx = static_cast<float>(h & 1023U) * (1.0F / 511.5F) - 1.0F;
        const float gy = static_cast<float>((h >> 10) & 1023U) * (1.0F / 511.5F) - 1.0F;
        const float gz = static_cast<float>((h >> 20) & 1023U) * (1.0F / 511.5F) - 1.0F;
        return gx * (tx - static_cast<float>(dx)) + gy * (ty - static_cast<float>(dy)) +
               gz * (tz - static_cast<float>(dz));
    };
    const auto lerp = [](float a, float b, float t) { return a + t * (b - a); };
    const float u = fade(tx);
    const float v = fade(ty);
    const float w = fade(tz);
    const auto row = [&](int dy, int dz) { return lerp(corner(0, dy, dz), corner(1, dy, dz), u); };
    return lerp(lerp(row(0, 0), row(1, 0), v), lerp(row(0, 1), row(1, 1), v), w);
}

// Distance to the nearest of one feature point a cell: 0 .. about 1.2. Cauliflower bulges come from 1 - worley.
inline float worley(float x, float y, float z, std::uint32_t seed) {
    const float fx = std::floor(x);
    const float fy = std::floor(y);
    const float fz = std::floor(z);
    float nearest = 9.0F;
    for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const std::uint32_t h =
                    hash(static_cast<int>(fx) + dx, static_cast<int>(fy) + dy, static_cast<int>(fz) + dz, seed);
                const float px = fx + static_cast<float>(dx) + static_cast<float>(h & 1023U) * (1.0F / 1024.0F) - x;
                const float py =
                    fy + static_cast<float>(dy) + static_cast<float>((h >> 10) & 1023U) * (1.0F / 1024.0F) - y;
                const float pz =
                    fz + static_cast<float>(dz) + static_cast<float>((h >> 20) & 1023U) * (1.0F / 1024.0F) - z;
                nearest = std::min(nearest, px * px + py * py + pz * pz);
            }
        }
    }
    return std::sqrt(nearest);
}

inline float smoothstep(float a, float b, float x) {
    const float t = std::clamp((x - a) / (b - a), 0.0F, 1.0F);
    return t * t * (3.0F - 2.0F * t);
}

} // namespace alpenglow::clouds
