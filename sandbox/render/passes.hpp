// The pipelines of a frame.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/reloadable_pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>

#include "sandbox/world/quality.hpp"

namespace alpenglow::sandbox {

inline constexpr VkFormat kColorFormat = VK_FORMAT_R8G8B8A8_UNORM;
inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

inline constexpr VkFormat kHdrFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
inline constexpr std::uint32_t kShadowMapSize = 2048;

// Push constants of the scene's shaders.
struct ScenePush {
    glm::vec4 grid{0.0F};   // image_from_position(); for discs the first word says sun or moon
    glm::vec2 tiles{1.0F};  // sides of the two sizes of the detail's tile, the finer first
    glm::vec2 levels{0.0F}; // lean: mip levels of the grid's image and of the coarser detail
};

struct Passes {
    // By name; some have no use in one quality or the other.
    enum Name : std::uint8_t {
        terrain,
        terrain_far,
        objects,
        sky,
        decals,
        sun,
        moon,
        shadow_map,
        resolve,
        hud_picture,
        count
    };

    vulkan::DescriptorSetLayout frame_set; // 0: the frame's block; 1, full alone: the shadow map
    vulkan::DescriptorSetLayout image_set; // 0: an image
    vulkan::PipelineLayout scene_layout;   // frame_set, image_set (a terrain grid), image_set (detail), ScenePush
    vulkan::PipelineLayout image_layout;   // image_set, 16 bytes for the vertex shader

    vulkan::RenderPassOptions scene_options, shadow_options, final_options, hud_options;
    vulkan::RenderPass scene;  // terrain to moon; lean: also the HUD's overlay
    vulkan::RenderPass shadow; // full: depth of objects from the light
    vulkan::RenderPass final;  // full: resolve and the HUD's overlay
    vulkan::RenderPass hud;    // the HUD's picture

    std::array<std::optional<vulkan::ReloadablePipeline>, count> pipelines;
    [[nodiscard]] VkPipeline operator[](Name name) const { return pipelines[name]->get(); }
};

// `quality` is lean or full. `shader_directory` is the folder shaders/ whose files are followed for changes; empty:
// none is.
Result<Passes> create_passes(const vulkan::Device& device, Quality quality,
                             const std::filesystem::path& shader_directory);

// Those of SceneCapture: terrain, objects and sky in radiance, lit per vertex.
Result<Passes> create_capture_passes(const vulkan::Device& device, const std::filesystem::path& shader_directory);

} // namespace alpenglow::sandbox
