#pragma once

#include <numbers>

namespace alpenglow {

inline constexpr double pi = std::numbers::pi;
inline constexpr double two_pi = 2.0 * std::numbers::pi;
inline constexpr double degree_rad = std::numbers::pi / 180.0;

} // namespace alpenglow
