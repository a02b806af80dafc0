// Render passes of one subpass, one colour target and at most one depth target, and targets to draw into.
#pragma once

#include <optional>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/image.hpp>

namespace alpenglow::vulkan {

// Where an attachment's content comes from and where it goes. Both formats may be VK_FORMAT_UNDEFINED for "none".
struct RenderPassOptions {
    VkFormat color = VK_FORMAT_R8G8B8A8_UNORM;
    VkAttachmentLoadOp color_load = VK_ATTACHMENT_LOAD_OP_CLEAR;
    VkImageLayout color_from = VK_IMAGE_LAYOUT_UNDEFINED; // the layout before; UNDEFINED discards
    VkImageLayout color_to =
        VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL; // after: TRANSFER_SRC, SHADER_READ_ONLY or COLOR_ATTACHMENT
    VkFormat depth = VK_FORMAT_UNDEFINED;
    VkAttachmentLoadOp depth_load = VK_ATTACHMENT_LOAD_OP_CLEAR;
    bool keep_depth = false; // store it and leave it in SHADER_READ_ONLY_OPTIMAL, as a shadow map does
};

// The dependencies order the pass after earlier and before later uses of its attachments as attachment, as transfer
// source and in fragment shaders.
Result<RenderPass> create_render_pass(const Device& device, const RenderPassOptions& options);

// What a pass draws into: its images and the framebuffer of them.
struct RenderTarget {
    std::optional<Image> color;
    std::optional<Image> depth;
    Framebuffer framebuffer;
    VkExtent2D extent{};
};

// `color_usage` and `depth_usage` come on top of the use as attachment, e.g. VK_IMAGE_USAGE_TRANSFER_SRC_BIT.
Result<RenderTarget> create_render_target(const Device& device, const RenderPassOptions& options, VkRenderPass pass,
                                          VkExtent2D extent, VkImageUsageFlags color_usage = 0,
                                          VkImageUsageFlags depth_usage = 0);

// Begins the pass over the whole target and sets viewport and scissor to it.
void begin_render_pass(VkCommandBuffer commands, VkRenderPass pass, const RenderTarget& target,
                       VkClearColorValue clear_color = {}, float clear_depth = 0.0F);

} // namespace alpenglow::vulkan
