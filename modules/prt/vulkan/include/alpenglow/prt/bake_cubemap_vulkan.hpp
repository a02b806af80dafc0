// bake_cubemap.hpp on a Vulkan device: the same texels, drawn by its rasteriser, and so the same file.
#pragma once

#include <alpenglow/prt/bake_cubemap.hpp>
#include <alpenglow/vulkan/device.hpp>

namespace alpenglow::prt {

// As bake_part_cubemap and bake_cubemap. Up to 2^24 - 1 triangles. Device and CPU may disagree on texels whose middle
// lies on an edge. The device is waited for.
[[nodiscard]] Result<BakePart> bake_part_cubemap(const vulkan::Device& device, const Mesh& mesh,
                                                 const BakeSettings& settings, std::size_t resolution,
                                                 std::size_t first, std::size_t count);
[[nodiscard]] Result<Bake> bake_cubemap(const vulkan::Device& device, const Mesh& mesh, const BakeSettings& settings,
                                        std::size_t resolution = 32);

} // namespace alpenglow::prt
