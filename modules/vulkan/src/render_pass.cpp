#include <alpenglow/vulkan/render_pass.hpp>

#include <array>
#include <cstdint>
#include <vector>

#include <alpenglow/vulkan/error.hpp>

namespace alpenglow::vulkan {

Result<RenderPass> create_render_pass(const Device& device, const RenderPassOptions& options) {
    std::vector<VkAttachmentDescription> attachments;
    VkAttachmentReference color{};
    VkAttachmentReference depth{};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    if (options.color != VK_FORMAT_UNDEFINED) {
        VkAttachmentDescription description{};
        description.format = options.color;
        description.samples = VK_SAMPLE_COUNT_1_BIT;
        description.loadOp = options.color_load;
        description.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        description.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        description.initialLayout = options.color_from;
        description.finalLayout = options.color_to;
        color = {static_cast<std::uint32_t>(attachments.size()), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &color;
        attachments.push_back(description);
    }
    if (options.depth != VK_FORMAT_UNDEFINED) {
        VkAttachmentDescription description{};
        description.format = options.depth;
        description.samples = VK_SAMPLE_COUNT_1_BIT;
        description.loadOp = options.depth_load;
        description.storeOp = options.keep_depth ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE;
        description.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        description.initialLayout = options.depth_load == VK_ATTACHMENT_LOAD_OP_LOAD
                                        ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL
                                        : VK_IMAGE_LAYOUT_UNDEFINED;
        description.finalLayout = options.keep_depth ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL
                                                     : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        depth = {static_cast<std::uint32_t>(attachments.size()), VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
        subpass.pDepthStencilAttachment = &depth;
        attachments.push_back(description);
    }

    // Both ways between this pass's attachments and whatever else touches the same images on this queue.
    constexpr VkPipelineStageFlags kInside = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                             VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                             VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkPipelineStageFlags kOutside =
        kInside | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    constexpr VkAccessFlags kWrites =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    constexpr VkAccessFlags kInsideAccess =
        kWrites | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    std::array<VkSubpassDependency, 2> dependencies{};
    dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;
    dependencies[0].dstSubpass = 0;
    dependencies[0].srcStageMask = kOutside;
    dependencies[0].dstStageMask = kInside;
    dependencies[0].srcAccessMask = kWrites;
    dependencies[0].dstAccessMask = kInsideAccess;
    dependencies[1].srcSubpass = 0;
    dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;
    dependencies[1].srcStageMask = kInside;
    dependencies[1].dstStageMask = kOutside;
    dependencies[1].srcAccessMask = kWrites;
    dependencies[1].dstAccessMask = kInsideAccess | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT;

    VkRenderPassCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
    info.attachmentCount = static_cast<std::uint32_t>(attachments.size());
    info.pAttachments = attachments.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = static_cast<std::uint32_t>(dependencies.size());
    info.pDependencies = dependencies.data();
    VkRenderPass pass = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateRenderPass(device.get(), &info, nullptr, &pass); result != VK_SUCCESS) {
        return call_error("vkCreateRenderPass", result);
    }
    return RenderPass(device.get(), pass);
}

Result<RenderTarget> create_render_target(const Device& device, const RenderPassOptions& options, VkRenderPass pass,
                                          VkExtent2D extent, VkImageUsageFlags color_usage,
                                          VkImageUsageFlags depth_usage) {
    RenderTarget target;
    target.extent = extent;
    std::vector<VkImageView> views;
    if (options.color != VK_FORMAT_UNDEFINED) {
        Result<Image> color =
            Image::create(device, {options.color, extent, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | color_usage, 1});
        if (!color) {
            return color.error();
        }
        views.push_back(color->view());
        target.color = std::move(color).value();
    }
    if (options.depth != VK_FORMAT_UNDEFINED) {
        Result<Image> depth = Image::create(
            device, {options.depth, extent, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | depth_usage, 1});
        if (!depth) {
            return depth.error();
        }
        views.push_back(depth->view());
        target.depth = std::move(depth).value();
    }
    VkFramebufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
    info.renderPass = pass;
    info.attachmentCount = static_cast<std::uint32_t>(views.size());
    info.pAttachments = views.data();
    info.width = extent.width;
    info.height = extent.height;
    info.layers = 1;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    if (const VkResult result = vkCreateFramebuffer(device.get(), &info, nullptr, &framebuffer); result != VK_SUCCESS) {
        return call_error("vkCreateFramebuffer", result);
    }
    target.framebuffer = {device.get(), framebuffer};
    return target;
}

void begin_render_pass(VkCommandBuffer commands, VkRenderPass pass, const RenderTarget& target,
                       VkClearColorValue clear_color, float clear_depth) {
    std::array<VkClearValue, 2> clears{};
    std::uint32_t count = 0;
    if (target.color) {
        clears[count++].color = clear_color;
    }
    if (target.depth) {
        clears[count++].depthStencil = {clear_depth, 0};
    }
    VkRenderPassBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO;
    info.renderPass = pass;
    info.framebuffer = target.framebuffer.get();
    info.renderArea = {{0, 0}, target.extent};
    info.clearValueCount = count;
    info.pClearValues = clears.data();
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
    const VkViewport viewport{
        0.0F, 0.0F, static_cast<float>(target.extent.width), static_cast<float>(target.extent.height), 0.0F, 1.0F};
    const VkRect2D scissor{{0, 0}, target.extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
}

} // namespace alpenglow::vulkan
