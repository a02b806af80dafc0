// Bounds in 16 bits: half the memory, and never below the value they bound.
#pragma once

#include <bit>
#include <cstdint>

namespace alpenglow::sandbox {

// The upper half of a float32, positive values rounded up (by less than 1/128); monotone. Negative values mark.
class UpperBound {
public:
    UpperBound() = default;
    explicit UpperBound(float value) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        upper_ = static_cast<std::uint16_t>((value > 0.0F ? bits + 0xFFFFU : bits) >> 16U);
    }
    [[nodiscard]] float value() const { return std::bit_cast<float>(static_cast<std::uint32_t>(upper_) << 16U); }
    bool operator==(const UpperBound&) const = default;

private:
    std::uint16_t upper_ = 0;
};

} // namespace alpenglow::sandbox
