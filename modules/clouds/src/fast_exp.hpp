// exp for negative arguments that compilers can vectorise: no tables, no branches.
#pragma once

#include <bit>
#include <cstdint>

namespace alpenglow::clouds {

// exp(x) for x <= 0; relative error <= 3e-7; 0 below about -87.
inline float exp_negative(float x) {
    const float y = (x < -87.0F ? -87.0F : x) * 1.44269504F;
    const auto whole = static_cast<std::int32_t>(y - 0.5F); // truncation of a negative number: rounds to nearest
    const float f = (y - static_cast<float>(whole)) * 0.693147181F; // |f| <= 0.35
    float p = 1.0F / 5040.0F;
    p = p * f + 1.0F / 720.0F;
    p = p * f + 1.0F / 120.0F;
    p = p * f + 1.0F / 24.0F;
    p = p * f + 1.0F / 6.0F;
    p = p * f + 0.5F;
    p = p * f + 1.0F;
    p = p * f + 1.0F;
    const float scale = std::bit_cast<float>((whole + 127) << 23);
    return x < -87.0F ? 0.0F : p * scale;
}

} // namespace alpenglow::clouds
