#include <alpenglow/vulkan/frame_ring.hpp>

#include <limits>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {

Result<FrameRing> FrameRing::create(const Device& device, std::uint32_t frames_in_flight) {
    FrameRing ring;
    ring.device_ = device.get();
    ring.queue_ = device.queue();
    for (std::uint32_t i = 0; i < frames_in_flight; ++i) {
        Slot slot;
        VkCommandPoolCreateInfo pool_info{};
        pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        pool_info.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
        pool_info.queueFamilyIndex = device.queue_family();
        VkCommandPool pool = VK_NULL_HANDLE;
        if (const VkResult result = vkCreateCommandPool(device.get(), &pool_info, nullptr, &pool);
            result != VK_SUCCESS) {
            return call_error("vkCreateCommandPool", result);
        }
        slot.pool = {device.get(), pool};
        VkCommandBufferAllocateInfo allocation{};
        allocation.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        allocation.commandPool = pool;
        allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
        allocation.commandBufferCount = 1;
        if (const VkResult result = vkAllocateCommandBuffers(device.get(), &allocation, &slot.commands);
            result != VK_SUCCESS) {
            return call_error("vkAllocateCommandBuffers", result);
        }
        VkFenceCreateInfo fence_info{};
        fence_info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
        fence_info.flags = VK_FENCE_CREATE_SIGNALED_BIT;
        VkFence fence = VK_NULL_HANDLE;
        if (const VkResult result = vkCreateFence(device.get(), &fence_info, nullptr, &fence); result != VK_SUCCESS) {
            return call_error("vkCreateFence", result);
        }
        slot.done = {device.get(), fence};
        ring.slots_.push_back(std::move(slot));
    }
    return ring;
}

Status FrameRing::wait(std::uint32_t slot) const {
    const VkFence fence = slots_[slot].done.get();
    if (const VkResult result = vkWaitForFences(device_, 1, &fence, VK_TRUE, std::numeric_limits<std::uint64_t>::max());
        result != VK_SUCCESS) {
        return call_error("vkWaitForFences", result);
    }
    return Ok{};
}

Result<FrameRing::Frame> FrameRing::begin() {
    const Slot& slot = slots_[next_];
    if (const Status waited = wait(next_); !waited) {
        return waited.error();
    }
    if (const VkResult result = vkResetCommandPool(device_, slot.pool.get(), 0); result != VK_SUCCESS) {
        return call_error("vkResetCommandPool", result);
    }
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    if (const VkResult result = vkBeginCommandBuffer(slot.commands, &begin); result != VK_SUCCESS) {
        return call_error("vkBeginCommandBuffer", result);
    }
    return Frame{next_, slot.commands};
}

Status FrameRing::submit(const Frame& frame, const FrameSignals& signals) {
    const Slot& slot = slots_[frame.slot];
    if (const VkResult result = vkEndCommandBuffer(slot.commands); result != VK_SUCCESS) {
        return call_error("vkEndCommandBuffer", result);
    }
    VkSubmitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    info.waitSemaphoreCount = signals.wait != VK_NULL_HANDLE ? 1 : 0;
    info.pWaitSemaphores = &signals.wait;
    info.pWaitDstStageMask = &signals.wait_stage;
    info.commandBufferCount = 1;
    info.pCommandBuffers = &slot.commands;
    info.signalSemaphoreCount = signals.signal != VK_NULL_HANDLE ? 1 : 0;
    info.pSignalSemaphores = &signals.signal;
    const VkFence fence = slot.done.get();
    if (const VkResult result = vkResetFences(device_, 1, &fence); result != VK_SUCCESS) {
        return call_error("vkResetFences", result);
    }
    if (const VkResult result = vkQueueSubmit(queue_, 1, &info, fence); result != VK_SUCCESS) {
        return call_error("vkQueueSubmit", result);
    }
    next_ = (frame.slot + 1) % size();
    return Ok{};
}

Result<Semaphore> create_semaphore(const Device& device) {
    VkSemaphoreCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    VkSemaphore semaphore = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateSemaphore(device.get(), &info, nullptr, &semaphore); result != VK_SUCCESS) {
        return call_error("vkCreateSemaphore", result);
    }
    return Semaphore(device.get(), semaphore);
}

} // namespace alpenglow::vulkan
