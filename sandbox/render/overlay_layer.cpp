#include "sandbox/render/overlay_layer.hpp"

#include <array>
#include <cstring>
#include <utility>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/pipelines.hpp"
#include "sandbox/world/overlay_render_data.hpp"

#include <alpenglow_shaders/overlay.frag.hpp>
#include <alpenglow_shaders/overlay.vert.hpp>

namespace alpenglow::sandbox {

// What does not depend on the picture, once.
Status OverlayLayer::create() {
    if (pipeline_) {
        return Ok{};
    }
    const auto count = static_cast<std::uint32_t>(context_.frames_in_flight + 1);
    Result<ImageSets> sets =
        ImageSets::create(context_.device, context_.passes.image_set.get(), count, {.filter = VK_FILTER_NEAREST});
    if (!sets) {
        return sets.error();
    }
    sets_ = std::move(sets).value();
    pictures_.resize(count);
    staging_ = {VK_BUFFER_USAGE_TRANSFER_SRC_BIT, count};

    vulkan::GraphicsPipelineOptions options{};
    options.layout = context_.passes.image_layout.get();
    options.pass = context_.quality == Quality::full ? context_.passes.final.get() : context_.passes.scene.get();
    options.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    options.blend = vulkan::Blend::over;
    Result<vulkan::ReloadablePipeline> pipeline = make_pipeline(
        context_.device,
        {vertex_shader(overlay_vert, "passes/overlay.vert"), fragment_shader(overlay_frag, "passes/overlay.frag")}, {},
        options, context_.shader_directory);
    if (!pipeline) {
        return pipeline.error();
    }
    pipeline_ = std::move(pipeline).value();
    return Ok{};
}

Status OverlayLayer::upload(const FrameData& frame, VkExtent2D extent, std::uint32_t /*slot*/, DrawStats& stats) {
    const OverlayRenderData& overlay = *frame.overlay;
    extent_ = extent;
    if (const Status created = create(); !created) {
        return created;
    }
    if (revision_ == overlay.revision) {
        return Ok{};
    }
    revision_ = overlay.revision;
    current_ = (current_ + 1) % pictures_.size();
    std::optional<vulkan::Image>& picture = pictures_[current_];
    const VkExtent2D size{static_cast<std::uint32_t>(overlay.width), static_cast<std::uint32_t>(overlay.height)};
    if (!picture || picture->extent().width != size.width || picture->extent().height != size.height) {
        Result<vulkan::Image> image =
            vulkan::Image::create(context_.device, {VK_FORMAT_R8G8B8A8_UNORM, size,
                                                    VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
        if (!image) {
            return image.error();
        }
        picture = std::move(image).value();
        sets_.show(context_.device, current_, *picture);
    }
    if (const Status staged = staging_.replace(context_.device, overlay.rgba); !staged) {
        return staged;
    }
    copy_ = true;
    ++stats.uploads;
    stats.upload_bytes += overlay.rgba.size_bytes();
    return Ok{};
}

void OverlayLayer::record_before(VkCommandBuffer commands, const FrameData& /*frame*/, DrawStats& /*stats*/) {
    if (!std::exchange(copy_, false)) {
        return;
    }
    const vulkan::Image& image = *pictures_[current_];
    vulkan::record_barrier(commands, image.get(), VK_IMAGE_ASPECT_COLOR_BIT,
                           {VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                            VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, 0, VK_PIPELINE_STAGE_TRANSFER_BIT,
                            VK_ACCESS_TRANSFER_WRITE_BIT});
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {image.extent().width, image.extent().height, 1};
    vkCmdCopyBufferToImage(commands, staging_.get(), image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    vulkan::record_barrier(commands, image.get(), VK_IMAGE_ASPECT_COLOR_BIT,
                           {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                            VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                            VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT});
}

void OverlayLayer::record_overlay(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const OverlayRenderData& overlay = *frame.overlay;
    const VkPipelineLayout layout = context_.passes.image_layout.get();
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_->get());
    const VkDescriptorSet set = sets_[current_];
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, nullptr);
    const auto clip = [](int at, std::uint32_t size) {
        return 2.0F * static_cast<float>(at) / static_cast<float>(size) - 1.0F;
    };
    const std::array<float, 4> corners{clip(overlay.left, extent_.width), clip(overlay.top, extent_.height),
                                       clip(overlay.left + overlay.width, extent_.width),
                                       clip(overlay.top + overlay.height, extent_.height)};
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof corners, corners.data());
    vkCmdDraw(commands, 4, 1, 0, 0);
    ++stats.draws;
    stats.triangles += 2;
}

std::vector<vulkan::ReloadablePipeline*> OverlayLayer::pipelines() {
    return pipeline_ ? std::vector<vulkan::ReloadablePipeline*>{&*pipeline_}
                     : std::vector<vulkan::ReloadablePipeline*>{};
}

} // namespace alpenglow::sandbox
