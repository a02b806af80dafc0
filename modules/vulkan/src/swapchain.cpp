#include <alpenglow/vulkan/swapchain.hpp>

#include <algorithm>
#include <limits>

#include <alpenglow/vulkan/error.hpp>
#include <alpenglow/vulkan/transfer.hpp>

namespace alpenglow::vulkan {
namespace {

Result<VkSurfaceFormatKHR> choose_format(VkPhysicalDevice physical, VkSurfaceKHR surface) {
    std::uint32_t count = 0;
    if (const VkResult result = vkGetPhysicalDeviceSurfaceFormatsKHR(physical, surface, &count, nullptr);
        result != VK_SUCCESS) {
        return call_error("vkGetPhysicalDeviceSurfaceFormatsKHR", result);
    }
    std::vector<VkSurfaceFormatKHR> formats(count);
    if (const VkResult result = vkGetPhysicalDeviceSurfaceFormatsKHR(physical, surface, &count, formats.data());
        result != VK_SUCCESS) {
        return call_error("vkGetPhysicalDeviceSurfaceFormatsKHR", result);
    }
    for (const VkSurfaceFormatKHR& format : formats) {
        if ((format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM) &&
            format.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) {
            return format;
        }
    }
    return Error{"the window's surface has no eight-bit UNORM format", "vulkan swapchain",
                 "B8G8R8A8_UNORM or R8G8B8A8_UNORM"};
}

VkPresentModeKHR choose_mode(VkPhysicalDevice physical, VkSurfaceKHR surface, bool vsync) {
    if (vsync) {
        return VK_PRESENT_MODE_FIFO_KHR;
    }
    std::uint32_t count = 0;
    vkGetPhysicalDeviceSurfacePresentModesKHR(physical, surface, &count, nullptr);
    std::vector<VkPresentModeKHR> modes(count);
    vkGetPhysicalDeviceSurfacePresentModesKHR(physical, surface, &count, modes.data());
    for (const VkPresentModeKHR wanted : {VK_PRESENT_MODE_MAILBOX_KHR, VK_PRESENT_MODE_IMMEDIATE_KHR}) {
        if (std::find(modes.begin(), modes.end(), wanted) != modes.end()) {
            return wanted;
        }
    }
    return VK_PRESENT_MODE_FIFO_KHR;
}

} // namespace

Result<Swapchain> Swapchain::create(const Device& device, const SwapchainOptions& options) {
    Swapchain swapchain;
    swapchain.device_ = &device;
    swapchain.options_ = options;
    for (std::uint32_t i = 0; i < options.frames_in_flight; ++i) {
        Result<Semaphore> semaphore = create_semaphore(device);
        if (!semaphore) {
            return semaphore.error();
        }
        swapchain.available_.push_back(std::move(semaphore).value());
    }
    if (const Status created = swapchain.create_images(); !created) {
        return created.error();
    }
    return swapchain;
}

Status Swapchain::create_images() {
    const VkSurfaceKHR surface = options_.surface;
    VkSurfaceCapabilitiesKHR can{};
    if (const VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_->physical(), surface, &can);
        result != VK_SUCCESS) {
        return call_error("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", result);
    }
    const Result<VkSurfaceFormatKHR> format = choose_format(device_->physical(), surface);
    if (!format) {
        return format.error();
    }
    extent_ = can.currentExtent;
    if (extent_.width == std::numeric_limits<std::uint32_t>::max()) {
        extent_ = {std::clamp(options_.extent.width, can.minImageExtent.width, can.maxImageExtent.width),
                   std::clamp(options_.extent.height, can.minImageExtent.height, can.maxImageExtent.height)};
    }
    if (extent_.width == 0 || extent_.height == 0) {
        return Error{"the window has no area", "vulkan swapchain", "a window that is not minimised"};
    }

    VkSwapchainCreateInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR;
    info.surface = surface;
    info.minImageCount = can.minImageCount + 1;
    if (can.maxImageCount != 0) {
        info.minImageCount = std::min(info.minImageCount, can.maxImageCount);
    }
    info.imageFormat = format->format;
    info.imageColorSpace = format->colorSpace;
    info.imageExtent = extent_;
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.preTransform = can.currentTransform;
    info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    info.presentMode = choose_mode(device_->physical(), surface, options_.vsync);
    info.clipped = VK_TRUE;
    info.oldSwapchain = swapchain_.get();
    VkSwapchainKHR handle = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateSwapchainKHR(device_->get(), &info, nullptr, &handle); result != VK_SUCCESS) {
        return call_error("vkCreateSwapchainKHR", result);
    }
    swapchain_ = {device_->get(), handle};

    std::uint32_t count = 0;
    vkGetSwapchainImagesKHR(device_->get(), handle, &count, nullptr);
    images_.resize(count);
    if (const VkResult result = vkGetSwapchainImagesKHR(device_->get(), handle, &count, images_.data());
        result != VK_SUCCESS) {
        return call_error("vkGetSwapchainImagesKHR", result);
    }
    finished_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
        Result<Semaphore> semaphore = create_semaphore(*device_);
        if (!semaphore) {
            return semaphore.error();
        }
        finished_.push_back(std::move(semaphore).value());
    }
    return Ok{};
}

Result<std::optional<Swapchain::Acquired>> Swapchain::acquire(std::uint32_t slot) {
    std::uint32_t index = 0;
    const VkSemaphore available = available_[slot].get();
    const VkResult result = vkAcquireNextImageKHR(
        device_->get(), swapchain_.get(), std::numeric_limits<std::uint64_t>::max(), available, VK_NULL_HANDLE, &index);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        return std::optional<Acquired>{};
    }
    if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR) {
        return call_error("vkAcquireNextImageKHR", result);
    }
    return std::optional<Acquired>{Acquired{index, available, finished_[index].get()}};
}

void Swapchain::record_copy(VkCommandBuffer commands, const Image& image, const Acquired& acquired) const {
    const VkImage target = images_[acquired.index];
    // After TRANSFER, where the frame waits for the image to be available.
    record_barrier(commands, target, VK_IMAGE_ASPECT_COLOR_BIT,
                   {VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
                    VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT});
    const auto corner = [](VkExtent2D extent) {
        return VkOffset3D{static_cast<std::int32_t>(extent.width), static_cast<std::int32_t>(extent.height), 1};
    };
    VkImageBlit blit{};
    blit.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.srcOffsets[1] = corner(image.extent());
    blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.dstOffsets[1] = corner(extent_);
    const bool same_size = image.extent().width == extent_.width && image.extent().height == extent_.height;
    vkCmdBlitImage(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, same_size ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
    record_barrier(commands, target, VK_IMAGE_ASPECT_COLOR_BIT,
                   {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                    VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT,
                    0});
}

Result<bool> Swapchain::present(const Acquired& acquired) {
    VkPresentInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR;
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &acquired.finished;
    const VkSwapchainKHR swapchain = swapchain_.get();
    info.swapchainCount = 1;
    info.pSwapchains = &swapchain;
    info.pImageIndices = &acquired.index;
    const VkResult result = vkQueuePresentKHR(device_->queue(), &info);
    if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) {
        return false;
    }
    if (result != VK_SUCCESS) {
        return call_error("vkQueuePresentKHR", result);
    }
    return true;
}

Status Swapchain::recreate(VkExtent2D extent) {
    if (const Status idle = device_->wait_idle(); !idle) {
        return idle;
    }
    options_.extent = extent;
    return create_images();
}

} // namespace alpenglow::vulkan
