// How far two pictures of one frame are apart.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace alpenglow::sandbox {

struct PictureDifference {
    double psnr_db = 0.0;             // over all pixels and RGB; 99 for equal pictures
    std::vector<std::byte> amplified; // RGBA: 16 times the absolute difference
};

// RGBA, 8 bits, of one size.
[[nodiscard]] PictureDifference picture_difference(std::span<const std::byte> a, std::span<const std::byte> b);

} // namespace alpenglow::sandbox
