// Small clouds that several tests share.
#pragma once

#include <cmath>
#include <cstdint>

#include <alpenglow/clouds/modelling.hpp>

namespace alpenglow::test {

// A box of constant density 1 with `n` voxels a side.
inline clouds::SparseGrid box_cloud(const glm::ivec3& n, float density = 1.0F,
                                    const clouds::GridTransform& transform = {}) {
    clouds::SparseGrid grid({0, 0, 0}, n, transform);
    for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x) {
                grid.brick(x >> 3, y >> 3, z >> 3)[((z & 7) * 8 + (y & 7)) * 8 + (x & 7)] = density;
            }
        }
    }
    return grid;
}

inline glm::vec3 unit(const glm::vec3& v) {
    return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

// Uniform numbers in [0, 1) from a counter.
inline float random_at(std::uint32_t i) {
    i ^= i >> 16;
    i *= 0x7feb352dU;
    i ^= i >> 15;
    i *= 0x846ca68bU;
    i ^= i >> 16;
    return static_cast<float>(i >> 8) * 0x1p-24F;
}

} // namespace alpenglow::test
