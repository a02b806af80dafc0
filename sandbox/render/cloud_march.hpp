// The clouds' picture made on the device: marched from the CPU's tables where the picture has changed, and the air in
// front of it where that has.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/image_sets.hpp"
#include "sandbox/render/layer.hpp"
#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {

class CloudMarcher {
public:
    explicit CloudMarcher(const LayerContext& context) : context_(context) {}

    // FrameData::clouds has a CloudMarch.
    Status upload(const FrameData& frame, VkExtent2D extent, DrawStats& stats);
    void record_before(VkCommandBuffer commands);
    void record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats);
    std::vector<vulkan::ReloadablePipeline*> pipelines();

private:
    Status create();
    Status fit(VkExtent2D extent);
    Status place_tables(const CloudMarch& march, DrawStats& stats);
    Status place_picture(const FrameData& frame);

    LayerContext context_;
    vulkan::DescriptorSetLayout set_layout_;
    vulkan::PipelineLayout layout_;
    vulkan::DescriptorPool pool_;
    vulkan::Sampler nearest_;
    std::vector<VkDescriptorSet> sets_; // used in turn, as DynamicBuffer
    std::size_t current_ = 0;
    vulkan::RenderPassOptions march_options_, air_options_;
    vulkan::RenderPass march_pass_, air_pass_;
    std::optional<vulkan::RenderTarget> marched_, picture_;
    std::optional<ImageSets> show_picture_, show_marched_; // one each
    std::optional<vulkan::ReloadablePipeline> march_, air_, draw_;

    std::optional<vulkan::Buffer> tables_;
    struct Placed {
        std::size_t first = 0, count = 0; // words
        std::uint32_t revision = 0;
    };
    std::vector<Placed> placed_;
    DynamicBuffer staging_, picture_words_, landscape_, block_;
    std::vector<VkBufferCopy> copies_;         // of this frame
    bool march_due_ = false, air_due_ = false; // in this frame
    // What was made last.
    std::uint32_t revision_ = 0, sky_revision_ = 0;
    float exposure_ = 0.0F;
    VkExtent2D extent_{};
    glm::vec4 image_{0.0F};
    glm::vec2 half_angles_{1.0F};
};

} // namespace alpenglow::sandbox
