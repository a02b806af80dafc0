// Draws CloudRenderData over terrain and sky.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <alpenglow/vulkan/image.hpp>
#include <alpenglow/vulkan/pipeline.hpp>

#include "sandbox/render/cloud_image.hpp"
#include "sandbox/render/cloud_march.hpp"
#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/image_sets.hpp"
#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

class CloudLayer final : public Layer {
public:
    explicit CloudLayer(const LayerContext& context) : context_(context), marcher_(context) {}

    [[nodiscard]] bool wanted(const FrameData& frame) const override {
        return frame.clouds != nullptr && !frame.capturing;
    }
    Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) override;
    void record_before(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    void record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    std::vector<vulkan::ReloadablePipeline*> pipelines() override;

private:
    Status create();
    Status fit(std::size_t picture, VkExtent2D extent);

    LayerContext context_;
    CloudMarcher marcher_; // of pictures that the device makes; the rest is for the CPU's
    std::optional<vulkan::ReloadablePipeline> pipeline_;
    // As DynamicBuffer: one image a frame in flight, used in turn.
    std::vector<std::optional<vulkan::Image>> pictures_;
    ImageSets sets_; // of the pictures
    std::size_t current_ = 0;
    DynamicBuffer staging_, vertices_;
    std::uint32_t vertex_count_ = 0;
    bool copy_ = false; // the current image is to be filled
    // What the image was made from.
    std::uint32_t revision_ = 0;
    std::uint32_t sky_revision_ = 0;
    VkExtent2D extent_{};
    float exposure_ = 0.0F;
};

} // namespace alpenglow::sandbox
