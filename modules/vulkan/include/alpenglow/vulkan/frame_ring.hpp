// Frames in flight: the CPU records one while the GPU still draws the ones before.
#pragma once

#include <cstdint>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/handle.hpp>

namespace alpenglow::vulkan {

// What a submitted frame waits for and tells.
struct FrameSignals {
    VkSemaphore wait = VK_NULL_HANDLE; // waited for before `wait_stage`
    VkPipelineStageFlags wait_stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
    VkSemaphore signal = VK_NULL_HANDLE; // signalled when the frame is done
};

// A ring of slots, each with a command buffer and a fence.
class FrameRing {
public:
    static Result<FrameRing> create(const Device& device, std::uint32_t frames_in_flight);

    struct Frame {
        std::uint32_t slot = 0; // below frames_in_flight: what the slot's last frame used is free again
        VkCommandBuffer commands = VK_NULL_HANDLE; // recording
    };
    // Waits until the next slot's last frame is done, then begins its command buffer.
    Result<Frame> begin();

    // Ends and submits the frame that begin() returned last.
    Status submit(const Frame& frame, const FrameSignals& signals = {});

    // Waits until the slot's last submitted frame is done.
    Status wait(std::uint32_t slot) const;

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(slots_.size()); }

private:
    struct Slot {
        CommandPool pool;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        Fence done; // signalled while the slot is free
    };
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::vector<Slot> slots_;
    std::uint32_t next_ = 0;
};

Result<Semaphore> create_semaphore(const Device& device);

} // namespace alpenglow::vulkan
