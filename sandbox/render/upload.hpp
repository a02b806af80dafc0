// Device memory that is filled once.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/transfer.hpp>

namespace alpenglow::sandbox {

// None for no items.
template <class T>
Status upload_once(const vulkan::Device& device, const std::vector<T>& items, VkBufferUsageFlags usage,
                   std::optional<vulkan::Buffer>& buffer) {
    if (items.empty()) {
        return Ok{};
    }
    const std::span<const std::byte> bytes = std::as_bytes(std::span(items));
    Result<vulkan::Buffer> created = vulkan::Buffer::create(device, bytes.size(), usage, vulkan::Placement::device);
    if (!created) {
        return created.error();
    }
    buffer = std::move(created).value();
    return vulkan::upload_buffer(device, *buffer, bytes);
}

inline void bind_vertices(VkCommandBuffer commands, std::uint32_t binding, VkBuffer buffer) {
    const VkDeviceSize offset = 0;
    vkCmdBindVertexBuffers(commands, binding, 1, &buffer, &offset);
}

} // namespace alpenglow::sandbox
