// Exponential and angle for the scalar float paths: the polynomials of dome_batch.cpp, without its lanes.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sky {

// e^x, held to x in -87 .. 88; relative error 2e-7. Double falls back on the library.
inline double fast_exp(double x) {
    return std::exp(x);
}
inline float fast_exp(float x) {
    const float held = std::max(std::min(x, 88.0F), -87.0F);
    const float shifted = held * 1.44269504F + 12582912.0F; // rounds to a whole number in the low bits
    const float n = shifted - 12582912.0F;
    const float r = (held - n * 0.693359375F) + n * 2.12194440e-4F;
    float p = 1.9875691500e-4F;
    p = p * r + 1.3981999507e-3F;
    p = p * r + 8.3334519073e-3F;
    p = p * r + 4.1665795894e-2F;
    p = p * r + 1.6666665459e-1F;
    p = p * r + 5.0000001201e-1F;
    p = p * r * r + (r + 1.0F);
    const std::int32_t exponent = std::bit_cast<std::int32_t>(shifted) - 0x4b400000 + 127;
    return p * std::bit_cast<float>(exponent << 23);
}

// The angle between unit vectors of cosine `cosine`.
inline double fast_angle(const glm::dvec3& a, const glm::dvec3& b, double cosine) {
    return std::atan2(glm::length(glm::cross(a, b)), cosine);
}
// 2 asin(chord / 2), to b or to its opposite: exact at both; error 3e-7.
inline float fast_angle(const glm::vec3& a, const glm::vec3& b, float cosine) {
    const glm::vec3 d = cosine < 0.0F ? a + b : a - b;
    const float q = std::min(0.25F * (d.x * d.x + d.y * d.y + d.z * d.z), 0.75F);
    float p = 0.111960899F;
    p = p * q - 0.0940462759F;
    p = p * q + 0.078228919F;
    p = p * q + 0.0158279045F;
    p = p * q + 0.0466362156F;
    p = p * q + 0.074868471F;
    p = p * q + 0.166669932F;
    p = p * q + 1.0F;
    const float angle = 2.0F * std::sqrt(q) * p;
    return cosine < 0.0F ? 3.14159265F - angle : angle;
}

} // namespace alpenglow::sky
