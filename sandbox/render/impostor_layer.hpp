// Draws ImpostorRenderData: an atlas of pictures on bent meshes, what flies among them, and outlines.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/image_sets.hpp"
#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

// Lean: the atlas holds display colours in 8 bits; full: exposed radiance in half floats. Either is made anew, a few
// tiles a frame, where the exposure has moved on.
class ImpostorLayer final : public Layer {
public:
    explicit ImpostorLayer(const LayerContext& context) : context_(context) {}

    [[nodiscard]] bool wanted(const FrameData& frame) const override;
    Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) override;
    void record_before(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    void record_opaque(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    void record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    std::vector<vulkan::ReloadablePipeline*> pipelines() override;

private:
    Status create(int width, int height);

    LayerContext context_;
    std::optional<ImageSets> sets_; // one
    std::optional<vulkan::Image> atlas_;
    bool fresh_ = false;                                                // the atlas has no layout yet
    std::array<std::optional<vulkan::ReloadablePipeline>, 3> pictures_; // by ImpostorRun::Kind
    std::optional<vulkan::ReloadablePipeline> craft_, lines_;
    DynamicBuffer staging_, vertices_, indices_, craft_vertices_, line_vertices_;
    std::optional<std::uint32_t> tiles_revision_, mesh_revision_, craft_revision_, lines_revision_;
    std::vector<VkBufferImageCopy> copies_; // of this frame
};

} // namespace alpenglow::sandbox
