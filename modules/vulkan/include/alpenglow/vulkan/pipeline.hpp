// Graphics pipelines from SPIR-V, and the small objects that go with them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/handle.hpp>

namespace alpenglow::vulkan {

struct ShaderStage {
    VkShaderStageFlagBits stage = VK_SHADER_STAGE_VERTEX_BIT;
    std::span<const std::uint32_t> spirv; // entry point "main"
};

enum class Blend {
    none,     // source
    alpha,    // source * a + target * (1 - a)
    add,      // source + target
    multiply, // source * target
    over,     // source + target * (1 - a): source is premultiplied
};

struct GraphicsPipelineOptions {
    std::span<const ShaderStage> stages;
    std::span<const std::uint32_t> constants{}; // specialization constants with ids 0, 1, ..., for every stage
    std::span<const VkVertexInputBindingDescription> bindings{};
    std::span<const VkVertexInputAttributeDescription> attributes{};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkRenderPass pass = VK_NULL_HANDLE;
    bool has_color = true; // false for a pass of depth alone
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkCullModeFlags cull = VK_CULL_MODE_NONE;
    VkFrontFace front = VK_FRONT_FACE_COUNTER_CLOCKWISE; // as seen in the framebuffer, whose y points down
    Blend blend = Blend::none;
    bool depth_test = false;
    bool depth_write = false;
    VkCompareOp depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL; // reversed depth: 1 is near, 0 far
    float depth_bias_constant = 0.0F;
    float depth_bias_slope = 0.0F;
};

// Viewport and scissor are dynamic. Drivers may finish compiling at the first draw (lavapipe does): warm up by drawing.
Result<Pipeline> create_graphics_pipeline(const Device& device, const GraphicsPipelineOptions& options);

Result<DescriptorSetLayout> create_descriptor_set_layout(const Device& device,
                                                         std::span<const VkDescriptorSetLayoutBinding> bindings);
Result<PipelineLayout> create_pipeline_layout(const Device& device, std::span<const VkDescriptorSetLayout> sets,
                                              std::span<const VkPushConstantRange> push_constants = {});
Result<DescriptorPool> create_descriptor_pool(const Device& device, std::uint32_t max_sets,
                                              std::span<const VkDescriptorPoolSize> sizes);
Result<VkDescriptorSet> allocate_descriptor_set(const Device& device, VkDescriptorPool pool,
                                                VkDescriptorSetLayout layout);

// Points one binding of a set, no frame in flight using it, at a uniform buffer or at a sampled image in
// SHADER_READ_ONLY_OPTIMAL.
void write_buffer_descriptor(const Device& device, VkDescriptorSet set, std::uint32_t binding, VkBuffer buffer,
                             VkDeviceSize size_bytes);
void write_image_descriptor(const Device& device, VkDescriptorSet set, std::uint32_t binding, VkImageView view,
                            VkSampler sampler);

struct SamplerOptions {
    VkFilter filter = VK_FILTER_LINEAR;
    VkSamplerMipmapMode mipmap = VK_SAMPLER_MIPMAP_MODE_NEAREST;
    VkSamplerAddressMode address = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    bool compare_greater = false; // a shadow sampler for reversed depth
};
Result<Sampler> create_sampler(const Device& device, const SamplerOptions& options);

} // namespace alpenglow::vulkan
