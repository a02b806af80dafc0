// Structure finer than a voxel, added while a ray marches: a solid texture (Perlin 1985; for clouds, Ebert 1997).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::clouds {

// A cube of noise that repeats: billows of two sizes, an eighth and a sixteenth of its side. 8 bits, about 128 in the
// mean.
class DetailTexture {
public:
    static constexpr int size = 64;         // cells a side
    static constexpr int stride = size + 1; // with an apron on the far sides

    explicit DetailTexture(std::uint32_t seed = 1);
    // Trilinear, -1 .. 1, in cells (>= 0).
    [[nodiscard]] float sample(const glm::vec3& cell) const;
    [[nodiscard]] const std::vector<std::uint8_t>& data() const { return data_; } // x fastest

private:
    std::vector<std::uint8_t> data_; // stride^3, and room for 4-byte reads
};

// What detail makes of a density: a factor 1 + strength (1 - density / most) noise, not below 0. Nothing comes where
// nothing was, and the inside, where no one looks, stays.
[[nodiscard]] inline float detailed_density(float density, float inverse_most, float strength, float noise) {
    const float factor = 1.0F + strength * (1.0F - density * inverse_most) * noise;
    return density * (factor > 0.0F ? factor : 0.0F);
}

} // namespace alpenglow::clouds
