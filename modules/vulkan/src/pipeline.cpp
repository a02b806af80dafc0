#include <alpenglow/vulkan/pipeline.hpp>

#include <array>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {
namespace {

VkPipelineColorBlendAttachmentState blend_state(Blend blend) {
    VkPipelineColorBlendAttachmentState state{};
    state.colorWriteMask =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    state.blendEnable = blend != Blend::none ? VK_TRUE : VK_FALSE;
    state.colorBlendOp = VK_BLEND_OP_ADD;
    state.alphaBlendOp = VK_BLEND_OP_ADD;
    state.srcColorBlendFactor = VK_BLEND_FACTOR_ONE;
    state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    switch (blend) {
    case Blend::none:
        break;
    case Blend::alpha:
        state.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
        state.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
        state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
        break;
    case Blend::add:
        state.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
        state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
        break;
    case Blend::multiply:
        state.srcColorBlendFactor = VK_BLEND_FACTOR_DST_COLOR;
        state.dstColorBlendFactor = VK_BLEND_FACTOR_ZERO;
        state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;
        state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
        break;
    case Blend::over:
        state.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
        state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
        break;
    }
    return state;
}

Result<ShaderModule> create_shader_module(const Device& device, std::span<const std::uint32_t> spirv) {
    VkShaderModuleCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    info.codeSize = spirv.size_bytes();
    info.pCode = spirv.data();
    VkShaderModule module = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateShaderModule(device.get(), &info, nullptr, &module); result != VK_SUCCESS) {
        return call_error("vkCreateShaderModule", result);
    }
    return ShaderModule(device.get(), module);
}

} // namespace

Result<Pipeline> create_graphics_pipeline(const Device& device, const GraphicsPipelineOptions& options) {
    std::vector<VkSpecializationMapEntry> entries;
    for (std::uint32_t id = 0; id < options.constants.size(); ++id) {
        entries.push_back({id, id * 4, 4});
    }
    const VkSpecializationInfo specialization{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                              options.constants.size_bytes(), options.constants.data()};
    std::vector<ShaderModule> modules;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    for (const ShaderStage& stage : options.stages) {
        Result<ShaderModule> module = create_shader_module(device, stage.spirv);
        if (!module) {
            return module.error();
        }
        VkPipelineShaderStageCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        info.stage = stage.stage;
        info.module = module->get();
        info.pName = "main";
        info.pSpecializationInfo = &specialization;
        stages.push_back(info);
        modules.push_back(std::move(module).value());
    }

    VkPipelineVertexInputStateCreateInfo input{};
    input.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    input.vertexBindingDescriptionCount = static_cast<std::uint32_t>(options.bindings.size());
    input.pVertexBindingDescriptions = options.bindings.data();
    input.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(options.attributes.size());
    input.pVertexAttributeDescriptions = options.attributes.data();
    VkPipelineInputAssemblyStateCreateInfo assembly{};
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = options.topology;
    VkPipelineViewportStateCreateInfo viewport{};
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{};
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = options.cull;
    raster.frontFace = options.front;
    raster.lineWidth = 1.0F;
    raster.depthBiasEnable =
        options.depth_bias_constant != 0.0F || options.depth_bias_slope != 0.0F ? VK_TRUE : VK_FALSE;
    raster.depthBiasConstantFactor = options.depth_bias_constant;
    raster.depthBiasSlopeFactor = options.depth_bias_slope;
    VkPipelineMultisampleStateCreateInfo samples{};
    samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{};
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = options.depth_test ? VK_TRUE : VK_FALSE;
    depth.depthWriteEnable = options.depth_write ? VK_TRUE : VK_FALSE;
    depth.depthCompareOp = options.depth_compare;
    const VkPipelineColorBlendAttachmentState attachment = blend_state(options.blend);
    VkPipelineColorBlendStateCreateInfo blend{};
    blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blend.attachmentCount = options.has_color ? 1 : 0;
    blend.pAttachments = &attachment;
    const std::array<VkDynamicState, 2> dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{};
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size());
    dynamic.pDynamicStates = dynamic_states.data();

    VkGraphicsPipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
    info.stageCount = static_cast<std::uint32_t>(stages.size());
    info.pStages = stages.data();
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = options.layout;
    info.renderPass = options.pass;
    VkPipeline pipeline = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateGraphicsPipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
        result != VK_SUCCESS) {
        return call_error("vkCreateGraphicsPipelines", result);
    }
    return Pipeline(device.get(), pipeline);
}

Result<DescriptorSetLayout> create_descriptor_set_layout(const Device& device,
                                                         std::span<const VkDescriptorSetLayoutBinding> bindings) {
    VkDescriptorSetLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    info.bindingCount = static_cast<std::uint32_t>(bindings.size());
    info.pBindings = bindings.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateDescriptorSetLayout(device.get(), &info, nullptr, &layout);
        result != VK_SUCCESS) {
        return call_error("vkCreateDescriptorSetLayout", result);
    }
    return DescriptorSetLayout(device.get(), layout);
}

Result<PipelineLayout> create_pipeline_layout(const Device& device, std::span<const VkDescriptorSetLayout> sets,
                                              std::span<const VkPushConstantRange> push_constants) {
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = static_cast<std::uint32_t>(sets.size());
    info.pSetLayouts = sets.data();
    info.pushConstantRangeCount = static_cast<std::uint32_t>(push_constants.size());
    info.pPushConstantRanges = push_constants.data();
    VkPipelineLayout layout = VK_NULL_HANDLE;
    if (const VkResult result = vkCreatePipelineLayout(device.get(), &info, nullptr, &layout); result != VK_SUCCESS) {
        return call_error("vkCreatePipelineLayout", result);
    }
    return PipelineLayout(device.get(), layout);
}

Result<DescriptorPool> create_descriptor_pool(const Device& device, std::uint32_t max_sets,
                                              std::span<const VkDescriptorPoolSize> sizes) {
    VkDescriptorPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    info.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    info.maxSets = max_sets;
    info.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
    info.pPoolSizes = sizes.data();
    VkDescriptorPool pool = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateDescriptorPool(device.get(), &info, nullptr, &pool); result != VK_SUCCESS) {
        return call_error("vkCreateDescriptorPool", result);
    }
    return DescriptorPool(device.get(), pool);
}

Result<VkDescriptorSet> allocate_descriptor_set(const Device& device, VkDescriptorPool pool,
                                                VkDescriptorSetLayout layout) {
    VkDescriptorSetAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    info.descriptorPool = pool;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    if (const VkResult result = vkAllocateDescriptorSets(device.get(), &info, &set); result != VK_SUCCESS) {
        return call_error("vkAllocateDescriptorSets", result);
    }
    return set;
}

namespace {

VkWriteDescriptorSet descriptor_write(VkDescriptorSet set, std::uint32_t binding, VkDescriptorType type) {
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = type;
    return write;
}

} // namespace

void write_buffer_descriptor(const Device& device, VkDescriptorSet set, std::uint32_t binding, VkBuffer buffer,
                             VkDeviceSize size_bytes) {
    const VkDescriptorBufferInfo info{buffer, 0, size_bytes};
    VkWriteDescriptorSet write = descriptor_write(set, binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
    write.pBufferInfo = &info;
    vkUpdateDescriptorSets(device.get(), 1, &write, 0, nullptr);
}

void write_image_descriptor(const Device& device, VkDescriptorSet set, std::uint32_t binding, VkImageView view,
                            VkSampler sampler) {
    const VkDescriptorImageInfo info{sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkWriteDescriptorSet write = descriptor_write(set, binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
    write.pImageInfo = &info;
    vkUpdateDescriptorSets(device.get(), 1, &write, 0, nullptr);
}

Result<Sampler> create_sampler(const Device& device, const SamplerOptions& options) {
    VkSamplerCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    info.magFilter = options.filter;
    info.minFilter = options.filter;
    info.mipmapMode = options.mipmap;
    info.addressModeU = options.address;
    info.addressModeV = options.address;
    info.addressModeW = options.address;
    info.compareEnable = options.compare_greater ? VK_TRUE : VK_FALSE;
    info.compareOp = VK_COMPARE_OP_GREATER_OR_EQUAL;
    info.maxLod = VK_LOD_CLAMP_NONE;
    VkSampler sampler = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateSampler(device.get(), &info, nullptr, &sampler); result != VK_SUCCESS) {
        return call_error("vkCreateSampler", result);
    }
    return Sampler(device.get(), sampler);
}

} // namespace alpenglow::vulkan
