// The images of a window. Frames are drawn off screen and copied to it, so that window and headless draw alike.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/frame_ring.hpp>
#include <alpenglow/vulkan/handle.hpp>
#include <alpenglow/vulkan/image.hpp>

namespace alpenglow::vulkan {

struct SwapchainOptions {
    VkSurfaceKHR surface = VK_NULL_HANDLE; // owned by the caller, outlives the swapchain
    VkExtent2D extent{}; // of the window's framebuffer, in pixels; used where the surface leaves it open
    std::uint32_t frames_in_flight = 2;
    bool vsync = true; // off: present at once where the surface can
};

// Eight-bit UNORM images that take bytes already encoded for the display.
class Swapchain {
public:
    static Result<Swapchain> create(const Device& device, const SwapchainOptions& options);

    struct Acquired {
        std::uint32_t index = 0;
        VkSemaphore available = VK_NULL_HANDLE; // wait for it before record_copy()'s commands, at TRANSFER
        VkSemaphore finished = VK_NULL_HANDLE;  // signal it with the frame; present() waits for it
    };
    // The next image, for the frame ring's `slot`. Nothing: the surface has changed, recreate() first.
    Result<std::optional<Acquired>> acquire(std::uint32_t slot);

    // Scales `image`, in TRANSFER_SRC_OPTIMAL, to the whole of the acquired image.
    void record_copy(VkCommandBuffer commands, const Image& image, const Acquired& acquired) const;

    // False: the surface has changed, recreate().
    Result<bool> present(const Acquired& acquired);

    // New images after a change of size. Waits for the device.
    Status recreate(VkExtent2D extent);

    [[nodiscard]] VkExtent2D extent() const { return extent_; }

private:
    Status create_images();

    const Device* device_ = nullptr;
    SwapchainOptions options_;
    VkExtent2D extent_{};
    Handle<VkSwapchainKHR, vkDestroySwapchainKHR> swapchain_;
    std::vector<VkImage> images_;
    std::vector<Semaphore> finished_;  // one for each image: it is free when that image comes back
    std::vector<Semaphore> available_; // one for each frame in flight
};

} // namespace alpenglow::vulkan
