// Range checks that raise no floating-point flag on NaN. Compilers fold isnan(x), isfinite(x) or isgreaterequal(x, low)
// into an ordinary comparison, which raises `invalid`; a test of the bits stays apart.
#pragma once

#include <bit>
#include <cstdint>

namespace alpenglow {

inline bool is_number(double x) noexcept {
    return (std::bit_cast<std::uint64_t>(x) & 0x7fffffffffffffffU) <= 0x7ff0000000000000U;
}
inline bool is_number(float x) noexcept {
    return (std::bit_cast<std::uint32_t>(x) & 0x7fffffffU) <= 0x7f800000U;
}

// low <= x <= high; false for NaN.
inline bool within(double x, double low, double high) noexcept {
    return is_number(x) && x >= low && x <= high;
}
inline bool within(float x, float low, float high) noexcept {
    return is_number(x) && x >= low && x <= high;
}

} // namespace alpenglow
