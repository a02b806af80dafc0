// Ownership of one Vulkan object: destroyed with its device's function when the handle goes.
#pragma once

#include <utility>

#include <vulkan/vulkan.h>

namespace alpenglow::vulkan {

// A move-only owner. The device must outlive it, and the GPU must be done with the object when it goes.
template <class T, void(VKAPI_PTR* Destroy)(VkDevice, T, const VkAllocationCallbacks*)>
class Handle {
public:
    Handle() = default;
    Handle(VkDevice device, T object) : device_(device), object_(object) {}
    Handle(Handle&& other) noexcept : device_(other.device_), object_(std::exchange(other.object_, VK_NULL_HANDLE)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(object_, other.object_);
        return *this;
    }
    ~Handle() {
        if (object_ != VK_NULL_HANDLE) {
            Destroy(device_, object_, nullptr);
        }
    }

    [[nodiscard]] T get() const { return object_; }
    explicit operator bool() const { return object_ != VK_NULL_HANDLE; }

private:
    VkDevice device_ = VK_NULL_HANDLE;
    T object_ = VK_NULL_HANDLE;
};

using CommandPool = Handle<VkCommandPool, vkDestroyCommandPool>;
using DescriptorPool = Handle<VkDescriptorPool, vkDestroyDescriptorPool>;
using DescriptorSetLayout = Handle<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using DeviceMemory = Handle<VkDeviceMemory, vkFreeMemory>;
using Fence = Handle<VkFence, vkDestroyFence>;
using Framebuffer = Handle<VkFramebuffer, vkDestroyFramebuffer>;
using ImageView = Handle<VkImageView, vkDestroyImageView>;
using Pipeline = Handle<VkPipeline, vkDestroyPipeline>;
using PipelineLayout = Handle<VkPipelineLayout, vkDestroyPipelineLayout>;
using RenderPass = Handle<VkRenderPass, vkDestroyRenderPass>;
using Sampler = Handle<VkSampler, vkDestroySampler>;
using Semaphore = Handle<VkSemaphore, vkDestroySemaphore>;
using ShaderModule = Handle<VkShaderModule, vkDestroyShaderModule>;

} // namespace alpenglow::vulkan
