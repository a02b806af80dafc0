// Draws an environment map behind everything, pixel by pixel.
#pragma once

#include <cstdint>
#include <optional>

#include "sandbox/render/image_sets.hpp"
#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

class EnvironmentLayer final : public Layer {
public:
    explicit EnvironmentLayer(const LayerContext& context) : context_(context) {}

    [[nodiscard]] bool wanted(const FrameData& frame) const override { return frame.environment != nullptr; }
    Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) override;
    void record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    std::vector<vulkan::ReloadablePipeline*> pipelines() override;

private:
    Status create();

    LayerContext context_;
    vulkan::PipelineLayout layout_; // the frame's set, the image's, EnvironmentPush
    std::optional<vulkan::ReloadablePipeline> pipeline_;
    ImageSets sets_; // one
    std::optional<vulkan::Image> image_;
    float image_scale_ = 1.0F; // from texels to cd/m^2 a unit of EnvironmentRenderData::scale
    std::optional<std::uint32_t> revision_;
};

} // namespace alpenglow::sandbox
