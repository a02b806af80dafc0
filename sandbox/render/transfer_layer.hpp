// Draws TransferRenderData: bodies lit by their transfer, by the CPU's colours or by the tables themselves, and smoke.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <alpenglow/vulkan/pipeline.hpp>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

struct TransferBody;

class TransferLayer final : public Layer {
public:
    explicit TransferLayer(const LayerContext& context) : context_(context) {}

    [[nodiscard]] bool wanted(const FrameData& frame) const override { return frame.transfer != nullptr; }
    Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) override;
    void record_opaque(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    void record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    std::vector<vulkan::ReloadablePipeline*> pipelines() override;

private:
    // What one frame in flight reads of a body's tables.
    struct Slot {
        VkDescriptorSet set = VK_NULL_HANDLE;
        std::shared_ptr<vulkan::Buffer> words; // of the set
        std::optional<vulkan::Buffer> block;
        std::uint32_t shade_revision = 0;
    };
    struct Body {
        DynamicBuffer vertices, indices, light;
        std::uint32_t mesh_revision = 0, light_revision = 0, table_revision = 0;
        std::shared_ptr<vulkan::Buffer> words; // both tables' blocks
        std::uint32_t glossy_words = 0;        // the first of the glossy table
        vulkan::DescriptorPool pool;
        std::vector<Slot> slots;
    };
    Status create();
    Status create_body(Body& body);
    Status upload_tables(const TransferBody& from, Body& body, std::uint32_t slot, DrawStats& stats);

    LayerContext context_;
    std::optional<vulkan::ReloadablePipeline> colored_, lit_, smoke_;
    vulkan::DescriptorSetLayout set_layout_;
    vulkan::PipelineLayout layout_;
    std::vector<Body> bodies_;
    DynamicBuffer smoke_vertices_, smoke_indices_;
    std::uint32_t smoke_revision_ = 0;
    std::uint32_t slot_ = 0;
};

} // namespace alpenglow::sandbox
