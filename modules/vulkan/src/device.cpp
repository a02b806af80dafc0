#include <alpenglow/vulkan/device.hpp>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {
namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
    std::uint32_t count = 0;
    if (vkEnumeratePhysicalDevices(instance, &count, nullptr) != VK_SUCCESS) {
        return {};
    }
    std::vector<VkPhysicalDevice> devices(count);
    if (vkEnumeratePhysicalDevices(instance, &count, devices.data()) < VK_SUCCESS) {
        return {};
    }
    devices.resize(count);
    return devices;
}

DeviceInfo describe(VkPhysicalDevice physical) {
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(physical, &properties);
    return {properties.deviceName, properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU, properties.apiVersion,
            properties.limits};
}

bool has_swapchain(VkPhysicalDevice physical) {
    std::uint32_t count = 0;
    vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data());
    return std::any_of(extensions.begin(), extensions.end(), [](const VkExtensionProperties& extension) {
        return std::strcmp(extension.extensionName, VK_KHR_SWAPCHAIN_EXTENSION_NAME) == 0;
    });
}

std::optional<std::uint32_t> find_queue_family(VkPhysicalDevice physical, VkSurfaceKHR surface) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    for (std::uint32_t i = 0; i < count; ++i) {
        VkBool32 presents = VK_TRUE;
        if (surface != VK_NULL_HANDLE &&
            vkGetPhysicalDeviceSurfaceSupportKHR(physical, i, surface, &presents) != VK_SUCCESS) {
            presents = VK_FALSE;
        }
        if ((families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0 && presents == VK_TRUE) {
            return i;
        }
    }
    return std::nullopt;
}

int preference(VkPhysicalDevice physical) {
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(physical, &properties);
    switch (properties.deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return 1;
    default:
        return 0;
    }
}

std::string wanted_name(const DeviceOptions& options) {
    if (!options.name.empty()) {
        return options.name;
    }
    const char* variable = std::getenv("ALPENGLOW_DEVICE");
    return variable != nullptr ? variable : "";
}

} // namespace

std::vector<DeviceInfo> list_devices(const Instance& instance) {
    std::vector<DeviceInfo> infos;
    for (const VkPhysicalDevice physical : physical_devices(instance.get())) {
        infos.push_back(describe(physical));
    }
    return infos;
}

Result<Device> Device::create(const Instance& instance, const DeviceOptions& options) {
    const std::string name = wanted_name(options);
    Device device;
    int best = -1;
    std::string seen;
    for (const VkPhysicalDevice physical : physical_devices(instance.get())) {
        DeviceInfo info = describe(physical);
        seen += (seen.empty() ? "" : ", ") + info.name;
        const std::optional<std::uint32_t> family = find_queue_family(physical, options.surface);
        const bool usable = info.api_version >= VK_API_VERSION_1_1 && family.has_value() &&
                            (options.surface == VK_NULL_HANDLE || has_swapchain(physical)) &&
                            lower(info.name).find(lower(name)) != std::string::npos;
        if (usable && preference(physical) > best) {
            best = preference(physical);
            device.physical_ = physical;
            device.queue_family_ = *family;
            device.info_ = std::move(info);
        }
    }
    if (best < 0) {
        return Error{"no usable device" + (name.empty() ? "" : " named \"" + name + "\"") + " among " +
                         (seen.empty() ? "none" : seen),
                     "vulkan",
                     std::string("a device with Vulkan 1.1 and a graphics queue") +
                         (options.surface != VK_NULL_HANDLE ? " that presents to the window" : "")};
    }

    const float priority = 1.0F;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = device.queue_family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    const char* swapchain = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = options.surface != VK_NULL_HANDLE ? 1 : 0;
    info.ppEnabledExtensionNames = &swapchain;
    if (const VkResult result = vkCreateDevice(device.physical_, &info, nullptr, &device.device_);
        result != VK_SUCCESS) {
        return call_error("vkCreateDevice", result);
    }
    vkGetDeviceQueue(device.device_, device.queue_family_, 0, &device.queue_);
    vkGetPhysicalDeviceMemoryProperties(device.physical_, &device.memory_);
    return device;
}

Device::Device(Device&& other) noexcept
    : device_(std::exchange(other.device_, VK_NULL_HANDLE)), physical_(other.physical_), queue_(other.queue_),
      queue_family_(other.queue_family_), info_(std::move(other.info_)), memory_(other.memory_) {}

Device& Device::operator=(Device&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(physical_, other.physical_);
    std::swap(queue_, other.queue_);
    std::swap(queue_family_, other.queue_family_);
    std::swap(info_, other.info_);
    std::swap(memory_, other.memory_);
    return *this;
}

Device::~Device() {
    if (device_ != VK_NULL_HANDLE) {
        vkDestroyDevice(device_, nullptr);
    }
}

std::optional<std::uint32_t> Device::memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags flags) const {
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i) {
        if ((type_bits & (1U << i)) != 0 && (memory_.memoryTypes[i].propertyFlags & flags) == flags) {
            return i;
        }
    }
    return std::nullopt;
}

Status Device::wait_idle() const {
    if (const VkResult result = vkDeviceWaitIdle(device_); result != VK_SUCCESS) {
        return call_error("vkDeviceWaitIdle", result);
    }
    return Ok{};
}

} // namespace alpenglow::vulkan
