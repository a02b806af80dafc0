// What one part of a scene adds to a frame. The renderer owns the frame; a layer uploads and records its own share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/reloadable_pipeline.hpp>

#include "sandbox/render/passes.hpp"
#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

// What a draw() did.
struct DrawStats {
    std::uint32_t uploads = 0; // buffers and images filled anew, not counting the uniform block of each frame
    std::uint64_t upload_bytes = 0;
    std::uint32_t draws = 0;     // draw calls
    std::uint32_t triangles = 0; // submitted, whether in view or not
    std::uint32_t objects_considered = 0;
    std::uint32_t objects_drawn = 0;
    bool hud_redrawn = false; // the HUD had changed
    bool presented = false;   // false with a swapchain: it must be recreated
};

// What layers share with the renderer. All of it outlives them.
struct LayerContext {
    const vulkan::Device& device;
    const Passes& passes; // scene_layout's set 0, the frame's block, is bound while layers record
    Quality quality = Quality::lean;
    std::uint32_t frames_in_flight = 2;
    std::filesystem::path shader_directory; // see make_pipeline()
};

class Layer {
public:
    virtual ~Layer() = default;
    // Whether the frame has anything for this layer. Where not, none of what follows is called; pipelines and images
    // are best made by the first upload(), so that scenes without the layer pay nothing for it.
    [[nodiscard]] virtual bool wanted(const FrameData& frame) const = 0;
    // Brings the device up to date with the frame. `slot`: of the frame in flight, no longer read by the device.
    virtual Status upload(const FrameData& frame, VkExtent2D extent, std::uint32_t slot, DrawStats& stats) = 0;
    // Copies and passes of its own, before the scene's.
    virtual void record_before(VkCommandBuffer /*commands*/, const FrameData& /*frame*/, DrawStats& /*stats*/) {}
    // In the scene's pass: among the opaque things, before terrain and sky.
    virtual void record_opaque(VkCommandBuffer /*commands*/, const FrameData& /*frame*/, DrawStats& /*stats*/) {}
    // In the scene's pass: over terrain, sky, sun and moon. Layers record from far to near, in their order.
    virtual void record_blended(VkCommandBuffer /*commands*/, const FrameData& /*frame*/, DrawStats& /*stats*/) {}
    // Over the finished picture, in display colours, below the HUD: lean: in the scene's pass, full: in the final one.
    virtual void record_overlay(VkCommandBuffer /*commands*/, const FrameData& /*frame*/, DrawStats& /*stats*/) {}
    // Pipelines to follow for changes of their shaders.
    virtual std::vector<vulkan::ReloadablePipeline*> pipelines() { return {}; }
};

} // namespace alpenglow::sandbox
