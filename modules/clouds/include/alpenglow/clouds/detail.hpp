// Structure finer than a voxel, added while a ray marches: a solid texture (Perlin 1985; for clouds, Ebert 1997).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::clouds {

// Where the two copies of the texture that make drifting detail stand, in cells, 0 .. DetailTexture::size: all that a
// shader needs to draw the same.
struct DetailOffsets {
    glm::vec3 first{0.0F};
    glm::vec3 second{0.0F};
};

// A cube of noise that repeats: billows of two sizes, an eighth and a sixteenth of its side. 8 bits, about 128 in the
// mean.
class DetailTexture {
public:
    static constexpr int size = 64;         // cells a side
    static constexpr int stride = size + 1; // with an apron on the far sides

    explicit DetailTexture(std::uint32_t seed = 1);
    // Trilinear, -1 .. 1, in cells (>= 0).
    [[nodiscard]] float sample(const glm::vec3& cell) const;
    // Drifting: (sample(cell + first) + sample(cell.yzx + second)) / sqrt(2), of the same spread, within +-sqrt(2). The
    // copies pass through each other, so that billows swell and vanish instead of sliding along.
    [[nodiscard]] float sample(const glm::vec3& cell, const DetailOffsets& offsets) const;
    [[nodiscard]] const std::vector<std::uint8_t>& data() const { return data_; } // x fastest

private:
    std::vector<std::uint8_t> data_; // stride^3, and room for 4-byte reads
};

// The offsets at a time (any finite one, also negative): within lifetime_s > 0 each copy moves by one of its larger
// billows, the first mostly upwards. A function of time alone: no state, no light to bake, the same in every run.
[[nodiscard]] DetailOffsets detail_drift(double time_s, double lifetime_s);

// What detail makes of a density: a factor 1 + strength (1 - density / most) noise, not below 0. Nothing comes where
// nothing was, and the inside, where no one looks, stays.
[[nodiscard]] inline float detailed_density(float density, float inverse_most, float strength, float noise) {
    const float factor = 1.0F + strength * (1.0F - density * inverse_most) * noise;
    return density * (factor > 0.0F ? factor : 0.0F);
}

} // namespace alpenglow::clouds
