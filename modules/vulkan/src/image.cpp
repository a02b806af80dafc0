#include <alpenglow/vulkan/image.hpp>

#include <string>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {

bool is_depth_format(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D16_UNORM;
}

std::uint32_t texel_bytes(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8_UNORM:
        return 1;
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_R8G8_UNORM:
        return 2;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_D32_SFLOAT:
        return 4;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
        return 8;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
        return 16;
    default:
        return 0;
    }
}

VkImageAspectFlags Image::aspect() const {
    return is_depth_format(options_.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

Result<Image> Image::create(const Device& device, const ImageOptions& options) {
    const std::uint32_t limit = device.info().limits.maxImageDimension2D;
    if (options.extent.width == 0 || options.extent.height == 0 || options.extent.width > limit ||
        options.extent.height > limit) {
        return Error{"the size is " + std::to_string(options.extent.width) + "x" +
                         std::to_string(options.extent.height),
                     "image", "from 1x1 to " + std::to_string(limit) + "x" + std::to_string(limit)};
    }
    Image image;
    image.options_ = options;

    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = options.format;
    info.extent = {options.extent.width, options.extent.height, 1};
    info.mipLevels = options.mip_levels;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = options.usage;
    VkImage handle = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateImage(device.get(), &info, nullptr, &handle); result != VK_SUCCESS) {
        return call_error("vkCreateImage", result);
    }
    image.image_ = {device.get(), handle};

    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(device.get(), handle, &needs);
    std::optional<std::uint32_t> type = device.memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (!type) {
        type = device.memory_type(needs.memoryTypeBits, 0);
    }
    if (!type) {
        return Error{"the device has no memory type for an image", "vulkan", ""};
    }
    VkMemoryAllocateInfo allocation{};
    allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = *type;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    if (const VkResult result = vkAllocateMemory(device.get(), &allocation, nullptr, &memory); result != VK_SUCCESS) {
        return call_error("vkAllocateMemory for an image", result);
    }
    image.memory_ = {device.get(), memory};
    if (const VkResult result = vkBindImageMemory(device.get(), handle, memory, 0); result != VK_SUCCESS) {
        return call_error("vkBindImageMemory", result);
    }

    VkImageViewCreateInfo view{};
    view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    view.image = handle;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = options.format;
    view.subresourceRange = {image.aspect(), 0, options.mip_levels, 0, 1};
    VkImageView view_handle = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateImageView(device.get(), &view, nullptr, &view_handle); result != VK_SUCCESS) {
        return call_error("vkCreateImageView", result);
    }
    image.view_ = {device.get(), view_handle};
    return image;
}

} // namespace alpenglow::vulkan
