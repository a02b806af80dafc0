#include <alpenglow/vulkan/buffer.hpp>

#include <cassert>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {

Result<Buffer> Buffer::create(const Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage,
                              Placement placement) {
    assert(size_bytes > 0);
    Buffer buffer;
    buffer.size_bytes_ = size_bytes;

    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size_bytes;
    info.usage = usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (placement != Placement::device) {
        info.usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    }
    VkBuffer handle = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateBuffer(device.get(), &info, nullptr, &handle); result != VK_SUCCESS) {
        return call_error("vkCreateBuffer", result);
    }
    buffer.buffer_ = {device.get(), handle};

    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device.get(), handle, &needs);
    constexpr VkMemoryPropertyFlags kMapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    std::optional<std::uint32_t> type;
    if (placement == Placement::device) {
        type = device.memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    } else if (placement == Placement::readback) {
        type = device.memory_type(needs.memoryTypeBits, kMapped | VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
    }
    if (!type) {
        type = device.memory_type(needs.memoryTypeBits, placement == Placement::device ? 0 : kMapped);
    }
    if (!type) {
        return Error{"the device has no memory type for a buffer", "vulkan", "host-visible coherent memory"};
    }
    VkMemoryAllocateInfo allocation{};
    allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = *type;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    if (const VkResult result = vkAllocateMemory(device.get(), &allocation, nullptr, &memory); result != VK_SUCCESS) {
        return call_error("vkAllocateMemory for a buffer", result);
    }
    buffer.memory_ = {device.get(), memory};
    if (const VkResult result = vkBindBufferMemory(device.get(), handle, memory, 0); result != VK_SUCCESS) {
        return call_error("vkBindBufferMemory", result);
    }
    if (placement != Placement::device) {
        void* bytes = nullptr;
        if (const VkResult result = vkMapMemory(device.get(), memory, 0, size_bytes, 0, &bytes); result != VK_SUCCESS) {
            return call_error("vkMapMemory", result);
        }
        buffer.mapped_ = {static_cast<std::byte*>(bytes), static_cast<std::size_t>(size_bytes)};
    }
    return buffer;
}

} // namespace alpenglow::vulkan
