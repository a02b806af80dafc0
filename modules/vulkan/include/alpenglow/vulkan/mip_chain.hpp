// Mip levels by averaging over areas, on the CPU: the same on every device, and without the bias that rounding level
// after level brings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <vulkan/vulkan.h>

namespace alpenglow::vulkan {

// How many levels there are down to 1x1.
[[nodiscard]] std::uint32_t mip_level_count(VkExtent2D extent);

// Extent of a level: halved and rounded down, at least 1.
[[nodiscard]] VkExtent2D mip_extent(VkExtent2D extent, std::uint32_t level);

// All levels of an image of four 8-bit channels, level 0 (`texels`, row by row) first, tightly packed. A texel of a
// level is the mean of the area that it covers in the level before, kept in float until it is stored: off the exact
// mean of level 0 by at most half a step.
[[nodiscard]] std::vector<std::byte> make_mip_chain(std::span<const std::byte> texels, VkExtent2D extent);

} // namespace alpenglow::vulkan
