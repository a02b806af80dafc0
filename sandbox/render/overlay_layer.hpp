// Lays OverlayRenderData over the finished frame.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <alpenglow/vulkan/image.hpp>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/image_sets.hpp"
#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

class OverlayLayer final : public Layer {
public:
    explicit OverlayLayer(const LayerContext& context) : context_(context) {}

    [[nodiscard]] bool wanted(const FrameData& frame) const override {
        return frame.overlay != nullptr && !frame.capturing;
    }
    Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) override;
    void record_before(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    void record_overlay(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    std::vector<vulkan::ReloadablePipeline*> pipelines() override;

private:
    Status create();

    LayerContext context_;
    std::optional<vulkan::ReloadablePipeline> pipeline_;
    // One image a frame in flight, used in turn: the one before may still be read.
    std::vector<std::optional<vulkan::Image>> pictures_;
    ImageSets sets_; // of the pictures
    std::size_t current_ = 0;
    DynamicBuffer staging_;
    bool copy_ = false; // the current picture's pixels are still in the staging buffer
    VkExtent2D extent_{};
    std::optional<std::uint32_t> revision_;
};

} // namespace alpenglow::sandbox
