// The choice of a physical device and the logical device with its one queue.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/instance.hpp>

namespace alpenglow::vulkan {

struct DeviceOptions {
    std::string name{};                    // part of the device's name, case ignored; empty: the environment variable
                                           // ALPENGLOW_DEVICE; both empty: the best device
    VkSurfaceKHR surface = VK_NULL_HANDLE; // where given, the queue can present to it
};

struct DeviceInfo {
    std::string name;
    bool is_cpu = false; // a software rasterizer such as lavapipe
    std::uint32_t api_version = 0;
    VkPhysicalDeviceLimits limits{};
};

// The devices of this machine, as the driver lists them, usable or not.
std::vector<DeviceInfo> list_devices(const Instance& instance);

// A logical device with one queue that draws, transfers and, where a surface was given, presents. Prefers a discrete
// GPU to an integrated or virtual one, and any of these to the CPU. Needs Vulkan 1.1 and no optional feature.
class Device {
public:
    static Result<Device> create(const Instance& instance, const DeviceOptions& options = {});
    Device(Device&& other) noexcept;
    Device& operator=(Device&& other) noexcept;
    ~Device();

    [[nodiscard]] VkDevice get() const { return device_; }
    [[nodiscard]] VkPhysicalDevice physical() const { return physical_; }
    [[nodiscard]] VkQueue queue() const { return queue_; }
    [[nodiscard]] std::uint32_t queue_family() const { return queue_family_; }
    [[nodiscard]] const DeviceInfo& info() const { return info_; }

    // The first memory type among `type_bits` with all of `flags`.
    [[nodiscard]] std::optional<std::uint32_t> memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags flags) const;

    // Returns when the device has nothing left to do.
    Status wait_idle() const;

private:
    Device() = default;

    VkDevice device_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::uint32_t queue_family_ = 0;
    DeviceInfo info_;
    VkPhysicalDeviceMemoryProperties memory_{};
};

} // namespace alpenglow::vulkan
