#include "sandbox/render/environment_layer.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include <glm/gtc/packing.hpp>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/gpu_data.hpp"
#include "sandbox/render/pipelines.hpp"
#include "sandbox/world/environment_render_data.hpp"

#include <alpenglow_shaders/environment.frag.hpp>
#include <alpenglow_shaders/environment.vert.hpp>

namespace alpenglow::sandbox {
namespace {

struct EnvironmentPush {
    glm::mat4 direction_from_clip;
    float scale; // from texels to exposed radiance
    float azimuth_rad;
};

} // namespace

// Once.
Status EnvironmentLayer::create() {
    if (pipeline_) {
        return Ok{};
    }
    constexpr VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                                       sizeof(EnvironmentPush)};
    const std::array<VkDescriptorSetLayout, 2> sets{context_.passes.frame_set.get(), context_.passes.image_set.get()};
    Result<vulkan::PipelineLayout> layout = vulkan::create_pipeline_layout(context_.device, sets, {&push, 1});
    Result<ImageSets> image_sets = ImageSets::create(context_.device, context_.passes.image_set.get(), 1,
                                                     {.address = VK_SAMPLER_ADDRESS_MODE_REPEAT});
    if (!layout || !image_sets) {
        return !layout ? layout.error() : image_sets.error();
    }
    layout_ = std::move(layout).value();
    sets_ = std::move(image_sets).value();
    vulkan::GraphicsPipelineOptions options{};
    options.layout = layout_.get();
    options.pass = context_.passes.scene.get();
    options.depth_test = true; // at the far end: only where nothing stands
    Result<vulkan::ReloadablePipeline> pipeline =
        make_pipeline(context_.device,
                      {vertex_shader(environment_vert, "passes/environment.vert"),
                       fragment_shader(environment_frag, "passes/environment.frag")},
                      {context_.quality == Quality::full ? 1U : 0U}, options, context_.shader_directory);
    if (!pipeline) {
        return pipeline.error();
    }
    pipeline_ = std::move(pipeline).value();
    return Ok{};
}

Status EnvironmentLayer::upload(const FrameData& frame, VkExtent2D /*extent*/, std::uint32_t /*slot*/,
                                DrawStats& stats) {
    const EnvironmentRenderData& map = *frame.environment;
    if (const Status created = create(); !created || revision_ == map.revision) {
        return created;
    }
    if (const Status idle = context_.device.wait_idle(); !idle) { // a frame may still read the image before
        return idle;
    }
    // Half floats hold the sun's ratio to the rest, once the brightest texel is brought to their end.
    constexpr float greatest_half = 65504.0F;
    float brightest = 1e-30F;
    for (const glm::vec3& texel : map.radiance) {
        brightest = std::max({brightest, texel.r, texel.g, texel.b});
    }
    image_scale_ = std::max(1.0F, brightest / greatest_half);
    std::vector<std::byte> texels(map.radiance.size() * sizeof(std::uint64_t));
    for (std::size_t i = 0; i < map.radiance.size(); ++i) {
        const std::uint64_t packed = glm::packHalf4x16(glm::vec4(map.radiance[i] / image_scale_, 1.0F));
        std::memcpy(texels.data() + i * sizeof packed, &packed, sizeof packed);
    }
    const VkExtent2D size{static_cast<std::uint32_t>(map.width), static_cast<std::uint32_t>(map.height)};
    Result<vulkan::Image> created =
        vulkan::Image::create(context_.device, {VK_FORMAT_R16G16B16A16_SFLOAT, size,
                                                VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, 1});
    if (!created) {
        return created.error();
    }
    image_ = std::move(created).value();
    sets_.show(context_.device, 0, *image_);
    revision_ = map.revision;
    ++stats.uploads;
    stats.upload_bytes += texels.size();
    return vulkan::upload_image(context_.device, *image_, texels);
}

void EnvironmentLayer::record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const EnvironmentRenderData& map = *frame.environment;
    // An infinitely far point has no place along the view: its direction comes from the inverse of the rotation and the
    // scale of the projection alone.
    const glm::mat3 turn = glm::transpose(glm::mat3(frame.view));
    const glm::vec3 right = turn[0] / frame.projection[0][0];
    const glm::vec3 up = turn[1] / frame.projection[1][1];
    const EnvironmentPush push{glm::mat4(glm::vec4(right, 0.0F), glm::vec4(up, 0.0F), glm::vec4(-turn[2], 0.0F),
                                         glm::vec4(0.0F, 0.0F, 0.0F, 1.0F)),
                               image_scale_ * map.scale * frame.exposure, map.azimuth_rad};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_->get());
    const VkDescriptorSet set = sets_[0];
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 1, 1, &set, 0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                       sizeof push, &push);
    vkCmdDraw(commands, 3, 1, 0, 0);
    ++stats.draws;
    ++stats.triangles;
}

std::vector<vulkan::ReloadablePipeline*> EnvironmentLayer::pipelines() {
    return pipeline_ ? std::vector<vulkan::ReloadablePipeline*>{&*pipeline_}
                     : std::vector<vulkan::ReloadablePipeline*>{};
}

} // namespace alpenglow::sandbox
