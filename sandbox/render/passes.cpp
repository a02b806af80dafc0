#include "sandbox/render/passes.hpp"

#include <array>
#include <cstddef>
#include <span>

#include "sandbox/render/gpu_data.hpp"

#include <alpenglow_shaders/color.frag.hpp>
#include <alpenglow_shaders/disc.vert.hpp>
#include <alpenglow_shaders/hud.frag.hpp>
#include <alpenglow_shaders/hud.vert.hpp>
#include <alpenglow_shaders/moon.frag.hpp>
#include <alpenglow_shaders/shadow_decal.frag.hpp>
#include <alpenglow_shaders/shadow_decal.vert.hpp>
#include <alpenglow_shaders/sky.vert.hpp>
#include <alpenglow_shaders/sun.frag.hpp>
#include <alpenglow_shaders/surface_lean.vert.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr std::array<VkVertexInputBindingDescription, 2> kSurfaceBindings{
    {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}, {1, sizeof(gpu::Instance), VK_VERTEX_INPUT_RATE_INSTANCE}}};
constexpr std::array<VkVertexInputAttributeDescription, 8> kSurfaceAttributes{{
    {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position_m)},
    {1, 0, VK_FORMAT_R8G8B8A8_SNORM, offsetof(Vertex, normal)},
    {2, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(Vertex, albedo)},
    {3, 0, VK_FORMAT_R32G32B32A32_UINT, offsetof(Vertex, horizon)},
    {4, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(gpu::Instance, world_row_x)},
    {5, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(gpu::Instance, world_row_y)},
    {6, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(gpu::Instance, world_row_z)},
    {7, 1, VK_FORMAT_R32G32B32A32_UINT, offsetof(gpu::Instance, horizon)},
}};
constexpr std::array<VkVertexInputBindingDescription, 1> kSkyBindings{
    {{0, sizeof(SkyVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 2> kSkyAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(SkyVertex, direction)},
     {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(SkyVertex, radiance_cd_m2)}}};
constexpr std::array<VkVertexInputBindingDescription, 1> kShadowBindings{
    {{0, sizeof(ShadowVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 2> kShadowAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ShadowVertex, position_m)},
     {1, 0, VK_FORMAT_R32_SFLOAT, offsetof(ShadowVertex, shade)}}};

// A pipeline as create_passes() lists it.
struct Recipe {
    vulkan::ShaderSource vertex, fragment;
    std::vector<std::uint32_t> constants{};
    vulkan::GraphicsPipelineOptions options{};
};

Result<vulkan::ReloadablePipeline> cook(const vulkan::Device& device, Recipe recipe,
                                        const std::filesystem::path& shader_directory) {
    for (vulkan::ShaderSource* source : {&recipe.vertex, &recipe.fragment}) {
        source->file = shader_directory.empty() ? std::filesystem::path() : shader_directory / source->file;
    }
    std::vector<vulkan::ShaderSource> sources{recipe.vertex, recipe.fragment};
    return vulkan::ReloadablePipeline::create(
        device, std::move(sources), {shader_directory},
        [&device, options = recipe.options,
         constants = std::move(recipe.constants)](std::span<const vulkan::ShaderStage> stages) mutable {
            options.stages = stages;
            options.constants = constants;
            return vulkan::create_graphics_pipeline(device, options);
        });
}

} // namespace

Result<Passes> create_passes(const vulkan::Device& device, Quality quality,
                             const std::filesystem::path& shader_directory) {
    Passes passes;
    const VkDescriptorSetLayoutBinding block{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1,
                                             VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    const VkDescriptorSetLayoutBinding image{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                             VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    Result<vulkan::DescriptorSetLayout> frame_set = vulkan::create_descriptor_set_layout(device, {&block, 1});
    Result<vulkan::DescriptorSetLayout> image_set = vulkan::create_descriptor_set_layout(device, {&image, 1});
    if (!frame_set || !image_set) {
        return !frame_set ? frame_set.error() : image_set.error();
    }
    passes.frame_set = std::move(frame_set).value();
    passes.image_set = std::move(image_set).value();
    const VkPushConstantRange word{VK_SHADER_STAGE_VERTEX_BIT, 0, 4};
    const VkPushConstantRange four{VK_SHADER_STAGE_VERTEX_BIT, 0, 16};
    const VkDescriptorSetLayout frame_handle = passes.frame_set.get();
    const VkDescriptorSetLayout image_handle = passes.image_set.get();
    Result<vulkan::PipelineLayout> scene_layout =
        vulkan::create_pipeline_layout(device, {&frame_handle, 1}, {&word, 1});
    Result<vulkan::PipelineLayout> image_layout =
        vulkan::create_pipeline_layout(device, {&image_handle, 1}, {&four, 1});
    if (!scene_layout || !image_layout) {
        return !scene_layout ? scene_layout.error() : image_layout.error();
    }
    passes.scene_layout = std::move(scene_layout).value();
    passes.image_layout = std::move(image_layout).value();

    passes.scene_options = {.color = kColorFormat, .depth = kDepthFormat};
    // Everything is drawn over: dome and terrain leave no pixel.
    passes.scene_options.color_load = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    passes.hud_options = {.color = kColorFormat, .color_to = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    Result<vulkan::RenderPass> scene = vulkan::create_render_pass(device, passes.scene_options);
    Result<vulkan::RenderPass> hud = vulkan::create_render_pass(device, passes.hud_options);
    if (!scene || !hud) {
        return !scene ? scene.error() : hud.error();
    }
    passes.scene = std::move(scene).value();
    passes.hud = std::move(hud).value();

    const auto stage = [](VkShaderStageFlagBits flag, std::span<const std::uint32_t> spirv, const char* file) {
        return vulkan::ShaderSource{flag, spirv, file};
    };
    const auto vertex = [&](std::span<const std::uint32_t> spirv, const char* file) {
        return stage(VK_SHADER_STAGE_VERTEX_BIT, spirv, file);
    };
    const auto fragment = [&](std::span<const std::uint32_t> spirv, const char* file) {
        return stage(VK_SHADER_STAGE_FRAGMENT_BIT, spirv, file);
    };
    const std::uint32_t hdr = quality == Quality::full ? 1 : 0;

    vulkan::GraphicsPipelineOptions surface{};
    surface.bindings = kSurfaceBindings;
    surface.attributes = kSurfaceAttributes;
    surface.layout = passes.scene_layout.get();
    surface.pass = passes.scene.get();
    surface.cull = VK_CULL_MODE_BACK_BIT;
    surface.depth_test = true;
    surface.depth_write = true;
    vulkan::GraphicsPipelineOptions sky = surface;
    sky.bindings = kSkyBindings;
    sky.attributes = kSkyAttributes;
    sky.cull = VK_CULL_MODE_NONE;
    sky.depth_write = false;
    vulkan::GraphicsPipelineOptions shadows = surface;
    shadows.bindings = kShadowBindings;
    shadows.attributes = kShadowAttributes;
    shadows.cull = VK_CULL_MODE_NONE;
    shadows.depth_write = false;
    shadows.blend = vulkan::Blend::multiply;
    vulkan::GraphicsPipelineOptions disc{};
    disc.layout = passes.scene_layout.get();
    disc.pass = passes.scene.get();
    disc.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    disc.depth_test = true;
    vulkan::GraphicsPipelineOptions sun = disc;
    sun.blend = vulkan::Blend::alpha;
    vulkan::GraphicsPipelineOptions moon = disc;
    moon.blend = vulkan::Blend::add;
    vulkan::GraphicsPipelineOptions hud_picture{};
    hud_picture.layout = passes.image_layout.get();
    hud_picture.pass = passes.scene.get();
    hud_picture.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    hud_picture.blend = vulkan::Blend::over;

    // In the order of Passes::Name.
    std::vector<Recipe> recipes;
    recipes.push_back({vertex(surface_lean_vert, "passes/surface_lean.vert"),
                       fragment(color_frag, "passes/color.frag"),
                       {0},
                       surface});
    recipes.push_back({vertex(surface_lean_vert, "passes/surface_lean.vert"),
                       fragment(color_frag, "passes/color.frag"),
                       {1},
                       surface});
    recipes.push_back({vertex(sky_vert, "passes/sky.vert"), fragment(color_frag, "passes/color.frag"), {hdr}, sky});
    recipes.push_back({vertex(shadow_decal_vert, "passes/shadow_decal.vert"),
                       fragment(shadow_decal_frag, "passes/shadow_decal.frag"),
                       {},
                       shadows});
    recipes.push_back({vertex(disc_vert, "passes/disc.vert"), fragment(sun_frag, "passes/sun.frag"), {hdr}, sun});
    recipes.push_back({vertex(disc_vert, "passes/disc.vert"), fragment(moon_frag, "passes/moon.frag"), {hdr}, moon});
    recipes.push_back({vertex(hud_vert, "passes/hud.vert"), fragment(hud_frag, "passes/hud.frag"), {}, hud_picture});
    for (Recipe& recipe : recipes) {
        Result<vulkan::ReloadablePipeline> pipeline = cook(device, std::move(recipe), shader_directory);
        if (!pipeline) {
            return pipeline.error();
        }
        passes.pipelines.push_back(std::move(pipeline).value());
    }
    return passes;
}

} // namespace alpenglow::sandbox
