// A two-dimensional image with its memory and one view of the whole of it.
#pragma once

#include <cstdint>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/handle.hpp>

namespace alpenglow::vulkan {

struct ImageOptions {
    VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
    VkExtent2D extent{};
    VkImageUsageFlags usage = 0;
    std::uint32_t mip_levels = 1;
};

class Image {
public:
    // Fails for an extent of zero or past the device's limit, naming both.
    static Result<Image> create(const Device& device, const ImageOptions& options);

    [[nodiscard]] VkImage get() const { return image_.get(); }
    [[nodiscard]] VkImageView view() const { return view_.get(); }
    [[nodiscard]] VkFormat format() const { return options_.format; }
    [[nodiscard]] VkExtent2D extent() const { return options_.extent; }
    [[nodiscard]] std::uint32_t mip_levels() const { return options_.mip_levels; }
    // Depth for depth formats, colour for all others.
    [[nodiscard]] VkImageAspectFlags aspect() const;

private:
    DeviceMemory memory_; // outlives the image bound to it
    Handle<VkImage, vkDestroyImage> image_;
    ImageView view_;
    ImageOptions options_;
};

// True for depth formats; combined depth and stencil formats are not used here.
bool is_depth_format(VkFormat format);

// Bytes of one texel of the uncompressed formats that this project uses; 0 for others.
std::uint32_t texel_bytes(VkFormat format);

} // namespace alpenglow::vulkan
