#include "sandbox/render/cloud_layer.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/pipelines.hpp"
#include "sandbox/render/upload.hpp"

#include <alpenglow_shaders/clouds.frag.hpp>
#include <alpenglow_shaders/clouds.vert.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr std::array<VkVertexInputBindingDescription, 1> kBindings{
    {{0, sizeof(CloudVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 1> kAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(CloudVertex, place)}}};

} // namespace

Status CloudLayer::create() {
    if (pipeline_) {
        return Ok{};
    }
    vulkan::GraphicsPipelineOptions options{};
    options.bindings = kBindings;
    options.attributes = kAttributes;
    options.layout = context_.passes.scene_layout.get();
    options.pass = context_.passes.scene.get();
    options.depth_test = true;
    options.blend = vulkan::Blend::over;
    Result<vulkan::ReloadablePipeline> pipeline = make_pipeline(
        context_.device,
        {vertex_shader(clouds_vert, "passes/clouds.vert"), fragment_shader(clouds_frag, "passes/clouds.frag")},
        {context_.quality == Quality::full ? 1U : 0U}, options, context_.shader_directory);
    Result<ImageSets> sets =
        ImageSets::create(context_.device, context_.passes.image_set.get(), context_.frames_in_flight);
    if (!pipeline || !sets) {
        return !pipeline ? pipeline.error() : sets.error();
    }
    sets_ = std::move(sets).value();
    pictures_.resize(context_.frames_in_flight);
    staging_ = {VK_BUFFER_USAGE_TRANSFER_SRC_BIT, context_.frames_in_flight};
    vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight};
    pipeline_ = std::move(pipeline).value();
    return Ok{};
}

Status CloudLayer::fit(std::size_t picture, VkExtent2D extent) {
    std::optional<vulkan::Image>& kept = pictures_[picture];
    if (kept && kept->extent().width == extent.width && kept->extent().height == extent.height) {
        return Ok{};
    }
    Result<vulkan::Image> image = vulkan::Image::create(
        context_.device,
        {.format = context_.quality == Quality::full ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R8G8B8A8_UNORM,
         .extent = extent,
         .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    if (!image) {
        return image.error();
    }
    kept = std::move(image).value();
    sets_.show(context_.device, picture, *kept);
    return Ok{};
}

Status CloudLayer::upload(const FrameData& frame, VkExtent2D extent, std::uint32_t /*slot*/, DrawStats& stats) {
    if (frame.clouds->march != nullptr) {
        return marcher_.upload(frame, extent, stats);
    }
    if (const Status created = create(); !created) {
        return created;
    }
    const CloudRenderData& clouds = *frame.clouds;
    // Half a step of 8 bits is a change of exposure by a hundredth.
    const bool exposed = std::abs(frame.exposure - exposure_) <= 0.005F * exposure_;
    if (clouds.revision == revision_ && frame.sky_revision == sky_revision_ && exposed &&
        extent.width == extent_.width && extent.height == extent_.height) {
        return Ok{};
    }
    revision_ = clouds.revision;
    sky_revision_ = frame.sky_revision;
    exposure_ = frame.exposure;
    extent_ = extent;
    const CloudImage image = make_cloud_image(clouds, frame, make_frame_block(frame, extract_sky(frame), extent.height),
                                              extent.width, extent.height, context_.quality != Quality::full);
    vertex_count_ = static_cast<std::uint32_t>(image.vertices.size());
    if (vertex_count_ == 0) {
        return Ok{};
    }
    current_ = (current_ + 1) % pictures_.size();
    Status status =
        fit(current_, {static_cast<std::uint32_t>(clouds.width), static_cast<std::uint32_t>(clouds.height)});
    if (status) {
        status = staging_.replace(context_.device, std::span<const std::byte>(image.texels));
    }
    if (status) {
        status = vertices_.replace(context_.device, std::span<const CloudVertex>(image.vertices));
    }
    copy_ = static_cast<bool>(status);
    stats.uploads += 2;
    stats.upload_bytes += image.texels.size() + image.vertices.size() * sizeof(CloudVertex);
    return status;
}

void CloudLayer::record_before(VkCommandBuffer commands, const FrameData& frame, DrawStats& /*stats*/) {
    if (frame.clouds->march != nullptr) {
        marcher_.record_before(commands);
        return;
    }
    if (!std::exchange(copy_, false)) {
        return;
    }
    const vulkan::Image& image = *pictures_[current_];
    vulkan::record_barrier(commands, image.get(), image.aspect(),
                           {.from = VK_IMAGE_LAYOUT_UNDEFINED,
                            .to = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                            .after_stage = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                            .after_access = 0,
                            .before_stage = VK_PIPELINE_STAGE_TRANSFER_BIT,
                            .before_access = VK_ACCESS_TRANSFER_WRITE_BIT});
    VkBufferImageCopy region{};
    region.imageSubresource = {image.aspect(), 0, 0, 1};
    region.imageExtent = {image.extent().width, image.extent().height, 1};
    vkCmdCopyBufferToImage(commands, staging_.get(), image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    vulkan::record_barrier(commands, image.get(), image.aspect(),
                           {.from = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                            .to = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                            .after_stage = VK_PIPELINE_STAGE_TRANSFER_BIT,
                            .after_access = VK_ACCESS_TRANSFER_WRITE_BIT,
                            .before_stage = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                            .before_access = VK_ACCESS_SHADER_READ_BIT});
}

void CloudLayer::record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    if (frame.clouds->march != nullptr) {
        marcher_.record_blended(commands, frame, stats);
        return;
    }
    if (vertex_count_ == 0) {
        return;
    }
    const CloudRenderData& clouds = *frame.clouds;
    const VkPipelineLayout layout = context_.passes.scene_layout.get();
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_->get());
    const VkDescriptorSet set = sets_[current_];
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 1, 1, &set, 0, nullptr);
    ScenePush push;
    push.grid = {0.5F * static_cast<float>(extent_.width) / (static_cast<float>(clouds.width) * clouds.scale),
                 0.5F * static_cast<float>(extent_.height) / (static_cast<float>(clouds.height) * clouds.scale), 0.5F,
                 0.5F};
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push,
                       &push);
    bind_vertices(commands, 0, vertices_.get());
    vkCmdDraw(commands, vertex_count_, 1, 0, 0);
    ++stats.draws;
    stats.triangles += vertex_count_ / 3;
}

std::vector<vulkan::ReloadablePipeline*> CloudLayer::pipelines() {
    std::vector<vulkan::ReloadablePipeline*> all = marcher_.pipelines();
    if (pipeline_) {
        all.push_back(&*pipeline_);
    }
    return all;
}

} // namespace alpenglow::sandbox
