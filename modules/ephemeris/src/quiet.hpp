// Range checks that raise no floating-point flag on NaN. Compilers fold isnan(x) or isgreaterequal(x, low) into an
// ordinary comparison, which raises `invalid`; a test of the bits stays apart.
#pragma once

#include <bit>
#include <cstdint>

namespace alpenglow::ephemeris {

inline bool is_number(double x) {
    return (std::bit_cast<std::uint64_t>(x) & 0x7fffffffffffffffU) <= 0x7ff0000000000000U;
}

inline bool within(double x, double low, double high) {
    return is_number(x) && x >= low && x <= high;
}

} // namespace alpenglow::ephemeris
