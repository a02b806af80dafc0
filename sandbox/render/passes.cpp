#include "sandbox/render/passes.hpp"

#include <array>
#include <cstddef>
#include <span>

#include "sandbox/render/gpu_data.hpp"
#include "sandbox/render/pipelines.hpp"

#include <alpenglow_shaders/disc.vert.hpp>
#include <alpenglow_shaders/hud.frag.hpp>
#include <alpenglow_shaders/hud.vert.hpp>
#include <alpenglow_shaders/moon.frag.hpp>
#include <alpenglow_shaders/object_lean.vert.hpp>
#include <alpenglow_shaders/resolve.frag.hpp>
#include <alpenglow_shaders/resolve.vert.hpp>
#include <alpenglow_shaders/shadow_decal.frag.hpp>
#include <alpenglow_shaders/shadow_decal.vert.hpp>
#include <alpenglow_shaders/shadow_map.vert.hpp>
#include <alpenglow_shaders/sky.vert.hpp>
#include <alpenglow_shaders/sun.frag.hpp>
#include <alpenglow_shaders/surface_full.frag.hpp>
#include <alpenglow_shaders/surface_full.vert.hpp>
#include <alpenglow_shaders/terrain_lean.frag.hpp>
#include <alpenglow_shaders/terrain_lean.vert.hpp>

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
constexpr std::array<VkVertexInputAttributeDescription, 3> kShadowAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ShadowVertex, position_m)},
     {1, 0, VK_FORMAT_R32_SFLOAT, offsetof(ShadowVertex, shade)},
     {2, 0, VK_FORMAT_R32G32B32A32_UINT, offsetof(ShadowVertex, horizon)}}};

// A pipeline to be.
struct Recipe {
    Passes::Name name;
    std::vector<vulkan::ShaderSource> sources;
    std::vector<std::uint32_t> constants;
    vulkan::GraphicsPipelineOptions options;
};

// Descriptor set layouts and pipeline layouts.
Status create_layouts(const vulkan::Device& device, Quality quality, Passes& passes) {
    constexpr VkShaderStageFlags kBoth = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    const std::array<VkDescriptorSetLayoutBinding, 2> frame_bindings{
        {{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, kBoth, nullptr},
         {1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}}};
    const VkDescriptorSetLayoutBinding image_binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                                     VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    Result<vulkan::DescriptorSetLayout> frame_set =
        vulkan::create_descriptor_set_layout(device, std::span(frame_bindings).first(quality == Quality::full ? 2 : 1));
    Result<vulkan::DescriptorSetLayout> image_set = vulkan::create_descriptor_set_layout(device, {&image_binding, 1});
    if (!frame_set || !image_set) {
        return !frame_set ? frame_set.error() : image_set.error();
    }
    passes.frame_set = std::move(frame_set).value();
    passes.image_set = std::move(image_set).value();
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, 16};
    const VkPushConstantRange scene_push{kBoth, 0, sizeof(ScenePush)};
    const std::array<VkDescriptorSetLayout, 3> sets{passes.frame_set.get(), passes.image_set.get(),
                                                    passes.image_set.get()};
    Result<vulkan::PipelineLayout> scene = vulkan::create_pipeline_layout(device, sets, {&scene_push, 1});
    Result<vulkan::PipelineLayout> image = vulkan::create_pipeline_layout(device, std::span(sets).last(1), {&push, 1});
    if (!scene || !image) {
        return !scene ? scene.error() : image.error();
    }
    passes.scene_layout = std::move(scene).value();
    passes.image_layout = std::move(image).value();
    return Ok{};
}

Status create_render_passes(const vulkan::Device& device, Quality quality, Passes& passes) {
    const bool full = quality == Quality::full;
    passes.scene_options = {.color = full ? kHdrFormat : kColorFormat,
                            .color_to =
                                full ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                            .depth = kDepthFormat};
    passes.shadow_options = {.color = VK_FORMAT_UNDEFINED, .depth = kDepthFormat, .keep_depth = true};
    passes.final_options = {.color = kColorFormat, .color_load = VK_ATTACHMENT_LOAD_OP_DONT_CARE};
    passes.hud_options = {.color = kColorFormat, .color_to = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const auto create = [&](const vulkan::RenderPassOptions& options, vulkan::RenderPass& pass) -> Status {
        Result<vulkan::RenderPass> created = vulkan::create_render_pass(device, options);
        if (!created) {
            return created.error();
        }
        pass = std::move(created).value();
        return Ok{};
    };
    Status status = create(passes.scene_options, passes.scene);
    if (status) {
        status = create(passes.hud_options, passes.hud);
    }
    if (status && full) {
        status = create(passes.shadow_options, passes.shadow);
    }
    if (status && full) {
        status = create(passes.final_options, passes.final);
    }
    return status;
}

// Terrain and objects in the scene's pass, and the dome behind them.
vulkan::GraphicsPipelineOptions surface_options(const Passes& passes) {
    vulkan::GraphicsPipelineOptions surface{};
    surface.bindings = kSurfaceBindings;
    surface.attributes = kSurfaceAttributes;
    surface.layout = passes.scene_layout.get();
    surface.pass = passes.scene.get();
    surface.cull = VK_CULL_MODE_BACK_BIT;
    surface.depth_test = true;
    surface.depth_write = true;
    return surface;
}

vulkan::GraphicsPipelineOptions sky_options(const Passes& passes) {
    vulkan::GraphicsPipelineOptions sky = surface_options(passes);
    sky.bindings = kSkyBindings;
    sky.attributes = kSkyAttributes;
    sky.cull = VK_CULL_MODE_NONE;
    sky.depth_write = false;
    return sky;
}

std::vector<Recipe> list_pipelines(Quality quality, const Passes& passes) {
    const bool full = quality == Quality::full;
    const vulkan::GraphicsPipelineOptions surface = surface_options(passes);
    vulkan::GraphicsPipelineOptions shadow_map = surface;
    shadow_map.pass = passes.shadow.get();
    shadow_map.has_color = false;
    shadow_map.cull = VK_CULL_MODE_NONE;
    vulkan::GraphicsPipelineOptions decals = surface;
    decals.bindings = kShadowBindings;
    decals.attributes = kShadowAttributes;
    decals.cull = VK_CULL_MODE_NONE;
    decals.depth_write = false;
    decals.blend = vulkan::Blend::multiply;
    vulkan::GraphicsPipelineOptions disc{};
    disc.layout = passes.scene_layout.get();
    disc.pass = passes.scene.get();
    disc.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    disc.depth_test = true;
    vulkan::GraphicsPipelineOptions sun = disc;
    sun.blend = vulkan::Blend::alpha;
    vulkan::GraphicsPipelineOptions moon = disc;
    moon.blend = vulkan::Blend::add;
    vulkan::GraphicsPipelineOptions resolve{};
    resolve.layout = passes.image_layout.get();
    resolve.pass = passes.final.get();
    vulkan::GraphicsPipelineOptions hud{};
    hud.layout = passes.image_layout.get();
    hud.pass = full ? passes.final.get() : passes.scene.get();
    hud.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    hud.blend = vulkan::Blend::over;

    const std::uint32_t hdr = full ? 1 : 0;
    const vulkan::ShaderSource disc_source = vertex_shader(disc_vert, "passes/disc.vert");
    std::vector<Recipe> recipes{
        {Passes::sky, {vertex_shader(sky_vert, "passes/sky.vert"), color_shader(quality)}, {hdr}, sky_options(passes)},
        {Passes::sun, {disc_source, fragment_shader(sun_frag, "passes/sun.frag")}, {hdr}, sun},
        {Passes::moon, {disc_source, fragment_shader(moon_frag, "passes/moon.frag")}, {hdr}, moon},
        {Passes::hud_picture,
         {vertex_shader(hud_vert, "passes/hud.vert"), fragment_shader(hud_frag, "passes/hud.frag")},
         {},
         hud},
    };
    if (full) {
        const std::vector<vulkan::ShaderSource> sources{vertex_shader(surface_full_vert, "passes/surface_full.vert"),
                                                        fragment_shader(surface_full_frag, "passes/surface_full.frag")};
        recipes.push_back({Passes::terrain, sources, {0}, surface});
        recipes.push_back({Passes::terrain_far, sources, {0}, surface});
        recipes.push_back({Passes::objects, sources, {1}, surface});
        recipes.push_back(
            {Passes::shadow_map, {vertex_shader(shadow_map_vert, "passes/shadow_map.vert")}, {}, shadow_map});
        recipes.push_back(
            {Passes::resolve,
             {vertex_shader(resolve_vert, "passes/resolve.vert"), fragment_shader(resolve_frag, "passes/resolve.frag")},
             {},
             resolve});
    } else {
        const std::vector<vulkan::ShaderSource> terrain{vertex_shader(terrain_lean_vert, "passes/terrain_lean.vert"),
                                                        fragment_shader(terrain_lean_frag, "passes/terrain_lean.frag")};
        recipes.push_back({Passes::terrain, terrain, {0, 1}, surface});
        recipes.push_back({Passes::terrain_far, terrain, {0, 0}, surface});
        recipes.push_back({Passes::objects,
                           {vertex_shader(object_lean_vert, "passes/object_lean.vert"), color_shader(quality)},
                           {1, 0},
                           surface});
        recipes.push_back({Passes::decals,
                           {vertex_shader(shadow_decal_vert, "passes/shadow_decal.vert"),
                            fragment_shader(shadow_decal_frag, "passes/shadow_decal.frag")},
                           {},
                           decals});
    }
    return recipes;
}

Status cook_all(const vulkan::Device& device, std::vector<Recipe> recipes,
                const std::filesystem::path& shader_directory, Passes& passes) {
    for (Recipe& recipe : recipes) {
        const Passes::Name name = recipe.name;
        Result<vulkan::ReloadablePipeline> pipeline = make_pipeline(
            device, std::move(recipe.sources), std::move(recipe.constants), recipe.options, shader_directory);
        if (!pipeline) {
            return pipeline.error();
        }
        passes.pipelines[name] = std::move(pipeline).value();
    }
    return Ok{};
}

} // namespace

Result<Passes> create_passes(const vulkan::Device& device, Quality quality,
                             const std::filesystem::path& shader_directory) {
    Passes passes;
    if (const Status created = create_layouts(device, quality, passes); !created) {
        return created.error();
    }
    if (const Status created = create_render_passes(device, quality, passes); !created) {
        return created.error();
    }
    if (const Status cooked = cook_all(device, list_pipelines(quality, passes), shader_directory, passes); !cooked) {
        return cooked.error();
    }
    return passes;
}

Result<Passes> create_capture_passes(const vulkan::Device& device, const std::filesystem::path& shader_directory) {
    Passes passes;
    if (const Status created = create_layouts(device, Quality::lean, passes); !created) {
        return created.error();
    }
    passes.scene_options = {
        .color = kHdrFormat, .color_to = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, .depth = kDepthFormat};
    Result<vulkan::RenderPass> scene = vulkan::create_render_pass(device, passes.scene_options);
    if (!scene) {
        return scene.error();
    }
    passes.scene = std::move(scene).value();
    const vulkan::GraphicsPipelineOptions surface = surface_options(passes);
    const vulkan::ShaderSource color = color_shader(Quality::full);
    const std::vector<vulkan::ShaderSource> lit{vertex_shader(object_lean_vert, "passes/object_lean.vert"), color};
    std::vector<Recipe> recipes{
        {Passes::terrain, lit, {0, 1}, surface},
        {Passes::objects, lit, {1, 1}, surface},
        {Passes::sky, {vertex_shader(sky_vert, "passes/sky.vert"), color}, {1}, sky_options(passes)}};
    if (const Status cooked = cook_all(device, std::move(recipes), shader_directory, passes); !cooked) {
        return cooked.error();
    }
    return passes;
}

} // namespace alpenglow::sandbox
