#include "sandbox/render/detail_image.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace alpenglow::sandbox {
namespace {

constexpr std::uint32_t n = kDetailSize;

float lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    std::uint32_t h = seed + x * 0x9E3779B1U + y * 0x85EBCA77U;
    h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
    h = (h ^ (h >> 12U)) * 0x297A2D39U;
    return static_cast<float>((h ^ (h >> 15U)) >> 8U) / 8388608.0F - 1.0F;
}

// Adds an octave of value noise with `cells` cells a side, interpolated by a quintic, whose second derivative is
// continuous: slopes show no lattice.
void add_octave(std::vector<float>& noise, std::uint32_t cells, float amplitude) {
    const std::uint32_t step = n / cells;
    const auto fade = [](float t) { return t * t * t * (t * (6.0F * t - 15.0F) + 10.0F); };
    for (std::uint32_t y = 0; y < n; ++y) {
        const std::uint32_t j = y / step;
        const float v = fade(static_cast<float>(y % step) / static_cast<float>(step));
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t i = x / step;
            const float u = fade(static_cast<float>(x % step) / static_cast<float>(step));
            const auto corner = [&](std::uint32_t dx, std::uint32_t dy) {
                return lattice((i + dx) % cells, (j + dy) % cells, cells);
            };
            const float low = (1.0F - u) * corner(0, 0) + u * corner(1, 0);
            const float high = (1.0F - u) * corner(0, 1) + u * corner(1, 1);
            noise[y * n + x] += amplitude * ((1.0F - v) * low + v * high);
        }
    }
}

std::byte unorm(float value) {
    return static_cast<std::byte>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F)));
}

} // namespace

std::vector<std::byte> detail_texels() {
    std::vector<float> noise(std::size_t{n} * n, 0.0F);
    float amplitude = 0.45F;
    for (std::uint32_t cells = 8; cells <= n / 2; cells *= 2) {
        add_octave(noise, cells, amplitude);
        amplitude *= 0.7F;
    }
    // A lattice of few cells does not average out by itself.
    const float mean = std::accumulate(noise.begin(), noise.end(), 0.0F) / static_cast<float>(noise.size());
    std::vector<std::byte> texels;
    texels.reserve(4 * noise.size());
    for (std::uint32_t y = 0; y < n; ++y) {
        for (std::uint32_t x = 0; x < n; ++x) {
            const auto at = [&](std::uint32_t i, std::uint32_t j) { return noise[j % n * n + i % n]; };
            // Central differences, scaled so that three quarters of the range are used.
            texels.push_back(unorm(0.5F + 0.6F * (at(x + 1, y) - at(x + n - 1, y))));
            texels.push_back(unorm(0.5F + 0.6F * (at(x, y + 1) - at(x, y + n - 1))));
            texels.push_back(unorm(0.5F + 0.4F * (at(x, y) - mean)));
            texels.push_back(std::byte{255});
        }
    }
    return texels;
}

} // namespace alpenglow::sandbox
