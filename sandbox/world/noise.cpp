#include "noise.hpp"

#include <algorithm>

namespace alpenglow::sandbox {
namespace {

float corner(std::int32_t ix, std::int32_t iy, float dx, float dy, std::uint32_t seed) noexcept {
    // 16 gradient directions of equal length.
    static constexpr float c[16] = {1.0F,  0.92388F,  0.70711F,  0.38268F,  0.0F, -0.38268F, -0.70711F, -0.92388F,
                                    -1.0F, -0.92388F, -0.70711F, -0.38268F, 0.0F, 0.38268F,  0.70711F,  0.92388F};
    const std::uint32_t g = hash_lattice(ix, iy, seed) >> 28U;
    return c[g] * dx + c[(g + 12U) & 15U] * dy;
}

} // namespace

float gradient_noise(float x, float y, std::uint32_t seed) noexcept {
    const float fx = std::floor(x);
    const float fy = std::floor(y);
    const auto ix = static_cast<std::int32_t>(fx);
    const auto iy = static_cast<std::int32_t>(fy);
    const float dx = x - fx;
    const float dy = y - fy;
    const float ux = dx * dx * dx * (dx * (dx * 6.0F - 15.0F) + 10.0F);
    const float uy = dy * dy * dy * (dy * (dy * 6.0F - 15.0F) + 10.0F);
    const float a = corner(ix, iy, dx, dy, seed);
    const float b = corner(ix + 1, iy, dx - 1.0F, dy, seed);
    const float c = corner(ix, iy + 1, dx, dy - 1.0F, seed);
    const float d = corner(ix + 1, iy + 1, dx - 1.0F, dy - 1.0F, seed);
    const float low = a + ux * (b - a);
    const float high = c + ux * (d - c);
    return 1.4F * (low + uy * (high - low));
}

float fractal_noise(float x, float y, int octaves, std::uint32_t seed) noexcept {
    float sum = 0.0F;
    float amplitude = 0.5F;
    for (int i = 0; i < octaves; ++i) {
        sum += amplitude * gradient_noise(x, y, seed + static_cast<std::uint32_t>(i) * 101U);
        // A turn between octaves hides the lattice.
        const float turned = 1.6F * x - 1.2F * y + 7.3F;
        y = 1.2F * x + 1.6F * y - 3.1F;
        x = turned;
        amplitude *= 0.5F;
    }
    return sum;
}

float ridged_noise(float x, float y, int octaves, std::uint32_t seed) noexcept {
    float sum = 0.0F;
    float amplitude = 0.5F;
    float weight = 1.0F;
    for (int i = 0; i < octaves; ++i) {
        float crest = 1.0F - std::abs(gradient_noise(x, y, seed + static_cast<std::uint32_t>(i) * 101U));
        crest *= crest * weight;
        sum += amplitude * crest;
        weight = std::clamp(2.0F * crest, 0.0F, 1.0F);
        const float turned = 1.6F * x - 1.2F * y + 7.3F;
        y = 1.2F * x + 1.6F * y - 3.1F;
        x = turned;
        amplitude *= 0.5F;
    }
    return sum;
}

} // namespace alpenglow::sandbox
