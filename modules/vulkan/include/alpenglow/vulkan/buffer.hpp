// A buffer with its memory.
#pragma once

#include <cstddef>
#include <span>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/handle.hpp>

namespace alpenglow::vulkan {

enum class Placement {
    device,   // fast for the GPU; filled through upload_buffer()
    upload,   // written by the CPU in place, coherent
    readback, // read by the CPU in place, coherent, cached where the device has such memory
};

class Buffer {
public:
    // A buffer of size_bytes > 0. Placement::device may also be a transfer destination, the others a transfer source or
    // destination, without asking for it in `usage`.
    static Result<Buffer> create(const Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage,
                                 Placement placement);

    [[nodiscard]] VkBuffer get() const { return buffer_.get(); }
    [[nodiscard]] VkDeviceSize size_bytes() const { return size_bytes_; }
    // The bytes as the CPU sees them; empty for Placement::device.
    [[nodiscard]] std::span<std::byte> mapped() const { return mapped_; }

private:
    DeviceMemory memory_; // outlives the buffer bound to it
    Handle<VkBuffer, vkDestroyBuffer> buffer_;
    VkDeviceSize size_bytes_ = 0;
    std::span<std::byte> mapped_;
};

} // namespace alpenglow::vulkan
