// Moving bytes between CPU and GPU, outside the frame: each call waits until the transfer is done.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/image.hpp>

namespace alpenglow::vulkan {

// One change of layout of a whole image, with the work before and after it that it separates.
struct ImageBarrier {
    VkImageLayout from = VK_IMAGE_LAYOUT_UNDEFINED;
    VkImageLayout to = VK_IMAGE_LAYOUT_UNDEFINED;
    VkPipelineStageFlags after_stage = VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT;
    VkAccessFlags after_access = 0;
    VkPipelineStageFlags before_stage = VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT;
    VkAccessFlags before_access = 0;
};
void record_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, const ImageBarrier& barrier);

// Makes what transfers wrote visible to the CPU once the submission is done.
void record_host_read_barrier(VkCommandBuffer commands);

// Records commands once, submits them and waits.
Status submit_and_wait(const Device& device, const std::function<void(VkCommandBuffer)>& record);

// Copies bytes into the buffer, in place where it is mapped and through a staging buffer where it is not.
// offset_bytes + bytes.size() must not exceed the buffer's size.
Status upload_buffer(const Device& device, const Buffer& buffer, std::span<const std::byte> bytes,
                     VkDeviceSize offset_bytes = 0);

// Fills all mip levels, level 0 first, each row by row and tightly packed, and leaves the image in
// VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL. The image must be a transfer destination.
Status upload_image(const Device& device, const Image& image, std::span<const std::byte> bytes);

// The buffer's bytes; it must be a transfer source where it is not mapped.
Result<std::vector<std::byte>> read_buffer(const Device& device, const Buffer& buffer);

// Mip level 0, row by row and tightly packed. The image must be a transfer source, is in `layout` before and after, and
// all work on it has been submitted.
Result<std::vector<std::byte>> read_image(const Device& device, const Image& image, VkImageLayout layout);

} // namespace alpenglow::vulkan
