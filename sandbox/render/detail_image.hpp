// A tile of fractal noise that gives the ground its grain where the terrain's grid is too coarse to have any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace alpenglow::sandbox {

inline constexpr std::uint32_t kDetailSize = 512;

// kDetailSize^2 texels, RGBA8, without seams when repeated: rg: slope of the noise, (s + 1) / 2; b: the noise, mean
// 1/2; a: 1.
[[nodiscard]] std::vector<std::byte> detail_texels();

} // namespace alpenglow::sandbox
