// Draws ProbeRenderData: a mesh that brings its own light, and balls lit by their probes.
#pragma once

#include <cstdint>
#include <optional>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/layer.hpp"

namespace alpenglow::sandbox {

class ProbeLayer final : public Layer {
public:
    explicit ProbeLayer(const LayerContext& context) : context_(context) {}

    [[nodiscard]] bool wanted(const FrameData& frame) const override { return frame.probes != nullptr; }
    Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) override;
    void record_opaque(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) override;
    std::vector<vulkan::ReloadablePipeline*> pipelines() override;

private:
    Status create();

    LayerContext context_;
    std::optional<vulkan::ReloadablePipeline> colored_, spheres_;
    std::optional<vulkan::Buffer> sphere_vertices_, sphere_indices_;
    std::uint32_t sphere_index_count_ = 0;
    struct Mesh {
        DynamicBuffer vertices, indices;
        std::optional<std::uint32_t> revision;
    };
    Mesh yard_, display_;
    DynamicBuffer sphere_instances_;
    std::optional<std::uint32_t> spheres_revision_;
};

} // namespace alpenglow::sandbox
