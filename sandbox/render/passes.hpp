// The pipelines of a frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/reloadable_pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>

namespace alpenglow::sandbox {

// What differs between devices: `lean` for the CPU (light per vertex, one pass), `full` for a GPU (shadow map, light
// per pixel, half-float target resolved by a second pass).
enum class Quality { lean, full };

inline constexpr VkFormat kColorFormat = VK_FORMAT_R8G8B8A8_UNORM;
inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

struct Passes {
    vulkan::DescriptorSetLayout frame_set; // the uniform block, the shadow map
    vulkan::DescriptorSetLayout image_set; // one sampled image
    vulkan::PipelineLayout scene_layout;   // frame_set, one word of push constants for the vertex shader
    vulkan::PipelineLayout image_layout;   // image_set, one vec4 of push constants for the vertex shader

    vulkan::RenderPassOptions scene_options, final_options, hud_options;
    vulkan::RenderPass scene; // terrain to moon; lean: also the HUD
    vulkan::RenderPass final; // full alone: resolve and HUD
    vulkan::RenderPass hud;   // draws the HUD's picture

    std::vector<vulkan::ReloadablePipeline> pipelines; // by Name
    enum Name : std::uint8_t { terrain, objects, sky, shadows, sun, moon, hud_picture };
    [[nodiscard]] VkPipeline operator[](Name name) const { return pipelines[name].get(); }
};

// `shader_directory` is the folder shaders/ whose files are followed for changes; empty: none is.
Result<Passes> create_passes(const vulkan::Device& device, Quality quality,
                             const std::filesystem::path& shader_directory);

} // namespace alpenglow::sandbox
