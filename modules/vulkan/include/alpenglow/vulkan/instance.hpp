// The Vulkan instance and, on request, the validation layer's messages.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include <alpenglow/core/result.hpp>

namespace alpenglow::vulkan {

// What the validation layer said: warnings and errors, in order of arrival. Safe to read from any thread.
class MessageLog {
public:
    void add(std::string message);
    [[nodiscard]] std::size_t count() const;
    [[nodiscard]] std::vector<std::string> messages() const;

private:
    mutable std::mutex mutex_;
    std::vector<std::string> messages_;
};

struct InstanceOptions {
    bool validation = false;                   // VK_LAYER_KHRONOS_validation with synchronization validation
    std::span<const char* const> extensions{}; // what the window system asks for
    const char* application = "alpenglow";
};

// A Vulkan 1.1 instance. Fails where no loader, driver, layer or extension answers.
class Instance {
public:
    static Result<Instance> create(const InstanceOptions& options = {});
    Instance(Instance&& other) noexcept;
    Instance& operator=(Instance&& other) noexcept;
    ~Instance();

    [[nodiscard]] VkInstance get() const { return instance_; }
    [[nodiscard]] bool validates() const { return messenger_ != VK_NULL_HANDLE; }
    [[nodiscard]] const MessageLog& messages() const { return *log_; }

private:
    Instance() = default;

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    std::unique_ptr<MessageLog> log_ = std::make_unique<MessageLog>(); // its address is the messenger's user data
};

} // namespace alpenglow::vulkan
