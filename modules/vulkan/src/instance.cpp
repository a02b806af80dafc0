#include <alpenglow/vulkan/instance.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL receive_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                               const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<MessageLog*>(user)->add(data->pMessage);
    return VK_FALSE;
}

bool has_layer(const char* name) {
    std::uint32_t count = 0;
    vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(),
                       [name](const VkLayerProperties& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

} // namespace

void MessageLog::add(std::string message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
}

std::size_t MessageLog::count() const {
    const std::lock_guard lock(mutex_);
    return messages_.size();
}

std::vector<std::string> MessageLog::messages() const {
    const std::lock_guard lock(mutex_);
    return messages_;
}

Result<Instance> Instance::create(const InstanceOptions& options) {
    Instance instance;
    std::vector<const char*> extensions(options.extensions.begin(), options.extensions.end());
    std::vector<const char*> layers;
    if (options.validation) {
        if (!has_layer(kValidationLayer)) {
            return Error{std::string("the layer ") + kValidationLayer + " is not installed", "vulkan validation",
                         "the package vulkan-validationlayers"};
        }
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    }

    // Only validation messages: the loader's own warnings, about drivers that it could not load, are not about us.
    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = receive_message;
    messenger.pUserData = instance.log_.get();

    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{};
    features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    features.pNext = &messenger; // also hears what happens while the instance itself is made and destroyed
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronization;

    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = options.application;
    application.pEngineName = "alpenglow";
    application.apiVersion = VK_API_VERSION_1_1;

    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pNext = options.validation ? &features : nullptr;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = static_cast<std::uint32_t>(layers.size());
    info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    if (const VkResult result = vkCreateInstance(&info, nullptr, &instance.instance_); result != VK_SUCCESS) {
        Error error = call_error("vkCreateInstance", result);
        if (result == VK_ERROR_INCOMPATIBLE_DRIVER) {
            error = {"no usable device: no Vulkan driver was found", "vulkan",
                     "a driver for Vulkan 1.1, such as the package mesa-vulkan-drivers"};
        }
        return error;
    }

    if (options.validation) {
        const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(instance.instance_, "vkCreateDebugUtilsMessengerEXT"));
        if (const VkResult result = create(instance.instance_, &messenger, nullptr, &instance.messenger_);
            result != VK_SUCCESS) {
            return call_error("vkCreateDebugUtilsMessengerEXT", result);
        }
    }
    return instance;
}

Instance::Instance(Instance&& other) noexcept
    : instance_(std::exchange(other.instance_, VK_NULL_HANDLE)),
      messenger_(std::exchange(other.messenger_, VK_NULL_HANDLE)), log_(std::move(other.log_)) {}

Instance& Instance::operator=(Instance&& other) noexcept {
    std::swap(instance_, other.instance_);
    std::swap(messenger_, other.messenger_);
    std::swap(log_, other.log_);
    return *this;
}

Instance::~Instance() {
    if (messenger_ != VK_NULL_HANDLE) {
        const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
        destroy(instance_, messenger_, nullptr);
    }
    if (instance_ != VK_NULL_HANDLE) {
        vkDestroyInstance(instance_, nullptr);
    }
}

} // namespace alpenglow::vulkan
