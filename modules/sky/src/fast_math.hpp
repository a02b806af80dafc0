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

// 2^x for x <= 126, held to x >= -126; relative error 4e-7.
inline float fast_exp2(float x) {
    const float held = x > -126.0F ? x : -126.0F;
    const float shifted = held + 12582912.0F;
    const float r = held - (shifted - 12582912.0F);
    float p = 0.00133813025F;
    p = p * r + 0.00966636852F;
    p = p * r + 0.0555038101F;
    p = p * r + 0.24022349F;
    p = p * r + 0.693147181F;
    p = p * r + 1.0F;
    return std::bit_cast<float>((std::bit_cast<std::int32_t>(shifted) << 23) + std::bit_cast<std::int32_t>(p));
}

// The angle between unit vectors of cosine `cosine`.
inline double fast_angle(const glm::dvec3& a, const glm::dvec3& b, double cosine) {
    return std::atan2(glm::length(glm::cross(a, b)), cosine);
}
// 2 asin(chord / 2), to b or to its opposite: exact at both; error 3e-7.
inline float fast_angle(const glm::vec3& a, const glm::vec3& b, float cosine) {
    const float sign = std::copysign(1.0F, cosine);
    const glm::vec3 d = a - sign * b;
    const float q = std::min(0.25F * (d.x * d.x + d.y * d.y + d.z * d.z), 0.75F);
    const float q2 = q * q;
    // asin(s) / s in q = s^2, even and odd powers apart so that neither waits for the other.
    const float even = 1.0F + q2 * (0.074868471F + q2 * (0.0158279045F - q2 * 0.0940462759F));
    const float odd = 0.166669932F + q2 * (0.0466362156F + q2 * (0.078228919F + q2 * 0.111960899F));
    const float angle = 2.0F * std::sqrt(q) * (even + q * odd);
    return (1.57079633F - sign * 1.57079633F) + sign * angle;
}

} // namespace alpenglow::sky
