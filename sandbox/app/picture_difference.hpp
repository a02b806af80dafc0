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

// How much more a run changes from one frame to the next than another of the same frames does: the root of the mean
// square, over pixels and RGB, of (now - before) - (reference now - reference before), in steps of 8 bits. Errors that
// stay where they are do not count, those that come at once do.
[[nodiscard]] double temporal_difference(std::span<const std::byte> before, std::span<const std::byte> now,
                                         std::span<const std::byte> reference_before,
                                         std::span<const std::byte> reference_now);

} // namespace alpenglow::sandbox
