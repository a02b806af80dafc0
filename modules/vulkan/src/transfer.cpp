#include <alpenglow/vulkan/transfer.hpp>

#include <cassert>
#include <cstring>

#include <alpenglow/vulkan/error.hpp>
#include <alpenglow/vulkan/mip_chain.hpp>

namespace alpenglow::vulkan {
void record_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, const ImageBarrier& barrier) {
    VkImageMemoryBarrier info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    info.srcAccessMask = barrier.after_access;
    info.dstAccessMask = barrier.before_access;
    info.oldLayout = barrier.from;
    info.newLayout = barrier.to;
    info.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    info.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    info.image = image;
    info.subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, 1};
    vkCmdPipelineBarrier(commands, barrier.after_stage, barrier.before_stage, 0, 0, nullptr, 0, nullptr, 1, &info);
}

void record_host_read_barrier(VkCommandBuffer commands) {
    VkMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0,
                         nullptr, 0, nullptr);
}

Status submit_and_wait(const Device& device, const std::function<void(VkCommandBuffer)>& record) {
    VkCommandPoolCreateInfo pool_info{};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
    pool_info.queueFamilyIndex = device.queue_family();
    VkCommandPool pool_handle = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateCommandPool(device.get(), &pool_info, nullptr, &pool_handle);
        result != VK_SUCCESS) {
        return call_error("vkCreateCommandPool", result);
    }
    const CommandPool pool(device.get(), pool_handle);

    VkCommandBufferAllocateInfo allocation{};
    allocation.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocation.commandPool = pool_handle;
    allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocation.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    if (const VkResult result = vkAllocateCommandBuffers(device.get(), &allocation, &commands); result != VK_SUCCESS) {
        return call_error("vkAllocateCommandBuffers", result);
    }
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    if (const VkResult result = vkBeginCommandBuffer(commands, &begin); result != VK_SUCCESS) {
        return call_error("vkBeginCommandBuffer", result);
    }
    record(commands);
    if (const VkResult result = vkEndCommandBuffer(commands); result != VK_SUCCESS) {
        return call_error("vkEndCommandBuffer", result);
    }
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    if (const VkResult result = vkQueueSubmit(device.queue(), 1, &submit, VK_NULL_HANDLE); result != VK_SUCCESS) {
        return call_error("vkQueueSubmit", result);
    }
    if (const VkResult result = vkQueueWaitIdle(device.queue()); result != VK_SUCCESS) {
        return call_error("vkQueueWaitIdle", result);
    }
    return Ok{};
}

Status upload_buffer(const Device& device, const Buffer& buffer, std::span<const std::byte> bytes,
                     VkDeviceSize offset_bytes) {
    assert(offset_bytes + bytes.size() <= buffer.size_bytes());
    if (bytes.empty()) {
        return Ok{};
    }
    if (!buffer.mapped().empty()) {
        std::memcpy(buffer.mapped().data() + offset_bytes, bytes.data(), bytes.size());
        return Ok{};
    }
    Result<Buffer> staging = Buffer::create(device, bytes.size(), 0, Placement::upload);
    if (!staging) {
        return staging.error();
    }
    std::memcpy(staging->mapped().data(), bytes.data(), bytes.size());
    return submit_and_wait(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, offset_bytes, bytes.size()};
        vkCmdCopyBuffer(commands, staging->get(), buffer.get(), 1, &copy);
    });
}

Status upload_image(const Device& device, const Image& image, std::span<const std::byte> bytes) {
    std::vector<VkBufferImageCopy> copies;
    std::size_t offset = 0;
    for (std::uint32_t level = 0; level < image.mip_levels(); ++level) {
        const VkExtent2D extent = mip_extent(image.extent(), level);
        VkBufferImageCopy copy{};
        copy.bufferOffset = offset;
        copy.imageSubresource = {image.aspect(), level, 0, 1};
        copy.imageExtent = {extent.width, extent.height, 1};
        copies.push_back(copy);
        offset += std::size_t{extent.width} * extent.height * texel_bytes(image.format());
    }
    assert(bytes.size() == offset);
    Result<Buffer> staging = Buffer::create(device, bytes.size(), 0, Placement::upload);
    if (!staging) {
        return staging.error();
    }
    std::memcpy(staging->mapped().data(), bytes.data(), bytes.size());
    return submit_and_wait(device, [&](VkCommandBuffer commands) {
        record_barrier(commands, image.get(), image.aspect(),
                       {VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                        VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0, VK_PIPELINE_STAGE_TRANSFER_BIT,
                        VK_ACCESS_TRANSFER_WRITE_BIT});
        vkCmdCopyBufferToImage(commands, staging->get(), image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                               static_cast<std::uint32_t>(copies.size()), copies.data());
        record_barrier(commands, image.get(), image.aspect(),
                       {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                        VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                        VK_PIPELINE_STAGE_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                        VK_ACCESS_SHADER_READ_BIT});
    });
}

Result<std::vector<std::byte>> read_buffer(const Device& device, const Buffer& buffer) {
    const std::size_t size = static_cast<std::size_t>(buffer.size_bytes());
    if (!buffer.mapped().empty()) {
        return std::vector<std::byte>(buffer.mapped().begin(), buffer.mapped().end());
    }
    Result<Buffer> staging = Buffer::create(device, size, 0, Placement::readback);
    if (!staging) {
        return staging.error();
    }
    const Status copied = submit_and_wait(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, 0, size};
        vkCmdCopyBuffer(commands, buffer.get(), staging->get(), 1, &copy);
        record_host_read_barrier(commands);
    });
    if (!copied) {
        return copied.error();
    }
    return std::vector<std::byte>(staging->mapped().begin(), staging->mapped().end());
}

Result<std::vector<std::byte>> read_image(const Device& device, const Image& image, VkImageLayout layout) {
    const VkExtent2D extent = image.extent();
    const std::size_t size = std::size_t{extent.width} * extent.height * texel_bytes(image.format());
    Result<Buffer> staging = Buffer::create(device, size, 0, Placement::readback);
    if (!staging) {
        return staging.error();
    }
    const Status copied = submit_and_wait(device, [&](VkCommandBuffer commands) {
        record_barrier(commands, image.get(), image.aspect(),
                       {layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                        VK_ACCESS_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT});
        VkBufferImageCopy copy{};
        copy.imageSubresource = {image.aspect(), 0, 0, 1};
        copy.imageExtent = {extent.width, extent.height, 1};
        vkCmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging->get(), 1, &copy);
        record_barrier(commands, image.get(), image.aspect(),
                       {VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout, VK_PIPELINE_STAGE_TRANSFER_BIT,
                        VK_ACCESS_TRANSFER_READ_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                        VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT});
        record_host_read_barrier(commands);
    });
    if (!copied) {
        return copied.error();
    }
    return std::vector<std::byte>(staging->mapped().begin(), staging->mapped().end());
}

} // namespace alpenglow::vulkan
