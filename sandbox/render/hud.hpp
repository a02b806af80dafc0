// The HUD's picture: what Dear ImGui drew, kept in an image and drawn again only when it has changed.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/instance.hpp>
#include <alpenglow/vulkan/render_pass.hpp>

#include "sandbox/render/passes.hpp"

struct ImDrawData;

namespace alpenglow::sandbox {

// A rectangle of pixels.
struct HudRectangle {
    std::int32_t left = 0, top = 0, right = 0, bottom = 0;
};

// The rectangles that the windows of the HUD cover, clipped to the image and merged where they overlap.
[[nodiscard]] std::vector<HudRectangle> hud_rectangles(const ImDrawData& data, VkExtent2D extent);

// A hash of everything that decides what the HUD looks like.
[[nodiscard]] std::uint64_t hud_hash(const ImDrawData& data);

// Owns ImGui's Vulkan backend: there is one for each ImGui context, which the caller makes before and destroys after.
class Hud {
public:
    static Result<std::unique_ptr<Hud>> create(const vulkan::Instance& instance, const vulkan::Device& device,
                                               const Passes& passes, VkDescriptorSet set, VkExtent2D extent,
                                               std::uint32_t frames_in_flight);
    ~Hud();
    Hud(const Hud&) = delete;
    Hud& operator=(const Hud&) = delete;

    // A new, empty picture. The device must be idle.
    Status resize(VkExtent2D extent);

    // Draws the picture if it differs from what it shows. True: it was drawn. Outside any render pass.
    bool record_picture(VkCommandBuffer commands, ImDrawData& data);

    // Lays the picture over the frame, inside the pass that `pipeline` was made for.
    void record_overlay(VkCommandBuffer commands, VkPipeline pipeline, VkPipelineLayout layout) const;

private:
    Hud(const vulkan::Device& device, const Passes& passes, VkDescriptorSet set)
        : device_(device), passes_(passes), set_(set) {}

    const vulkan::Device& device_;
    const Passes& passes_;
    VkDescriptorSet set_;
    vulkan::Sampler sampler_;
    vulkan::DescriptorPool descriptors_; // the backend's
    bool backend_ = false;
    vulkan::RenderTarget target_;
    std::uint64_t hash_ = 0;
    bool drawn_ = false;
    std::vector<HudRectangle> rectangles_;
};

} // namespace alpenglow::sandbox
