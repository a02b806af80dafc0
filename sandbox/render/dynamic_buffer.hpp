// A buffer whose content changes now and then while earlier frames are still being drawn.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include <alpenglow/vulkan/buffer.hpp>

namespace alpenglow::sandbox {

// One buffer a frame in flight, used in turn. A change made after FrameRing::begin() writes to a buffer that no frame
// in flight reads: it was replaced at least as many frames ago as there are slots.
class DynamicBuffer {
public:
    DynamicBuffer() = default;
    DynamicBuffer(VkBufferUsageFlags usage, std::uint32_t frames_in_flight)
        : usage_(usage), buffers_(frames_in_flight) {}

    // Replaces the content; `write` fills the bytes in place.
    template <class Write>
    Status replace(const vulkan::Device& device, std::size_t size_bytes, Write write) {
        current_ = (current_ + 1) % static_cast<std::uint32_t>(buffers_.size());
        std::optional<vulkan::Buffer>& buffer = buffers_[current_];
        if (!buffer || buffer->size_bytes() < size_bytes) {
            // Half as much again, so that slow growth does not allocate each time.
            Result<vulkan::Buffer> larger = vulkan::Buffer::create(
                device, std::max<std::size_t>(size_bytes + size_bytes / 2, 256), usage_, vulkan::Placement::upload);
            if (!larger) {
                return larger.error();
            }
            buffer = std::move(larger).value();
        }
        write(buffer->mapped().first(size_bytes));
        return Ok{};
    }

    // Replaces the content with a copy of the items.
    template <class T>
    Status replace(const vulkan::Device& device, std::span<const T> items) {
        return replace(device, items.size_bytes(), [&](std::span<std::byte> bytes) {
            if (!items.empty()) {
                std::memcpy(bytes.data(), items.data(), items.size_bytes());
            }
        });
    }

    // The newest content; replace() must have been called.
    [[nodiscard]] VkBuffer get() const { return buffers_[current_]->get(); }

private:
    VkBufferUsageFlags usage_ = 0;
    std::vector<std::optional<vulkan::Buffer>> buffers_;
    std::uint32_t current_ = 0;
};

} // namespace alpenglow::sandbox
