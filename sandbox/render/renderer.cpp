#include "sandbox/render/renderer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include <alpenglow/vulkan/mip_chain.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/detail_image.hpp"
#include "sandbox/render/frustum.hpp"
#include "sandbox/render/layers.hpp"
#include "sandbox/render/upload.hpp"

namespace alpenglow::sandbox {
namespace {

bool is_lit(glm::vec3 illuminance) {
    return illuminance.x > 0.0F || illuminance.y > 0.0F || illuminance.z > 0.0F;
}

} // namespace

Result<std::unique_ptr<Renderer>> Renderer::create(const vulkan::Device& device, const WorldData& world,
                                                   const RendererOptions& options) {
    std::unique_ptr<Renderer> renderer(new Renderer(device));
    Renderer& r = *renderer;
    r.quality_ = options.quality;
    if (r.quality_ == Quality::automatic) {
        r.quality_ = device.info().is_cpu ? Quality::lean : Quality::full;
    }
    r.frames_in_flight_ = options.frames_in_flight;
    r.shader_directory_ = options.shader_directory;
    Result<Passes> passes = create_passes(device, r.quality_, options.shader_directory);
    if (!passes) {
        return passes.error();
    }
    r.passes_ = std::move(passes).value();
    Result<vulkan::FrameRing> ring = vulkan::FrameRing::create(device, r.frames_in_flight_);
    if (!ring) {
        return ring.error();
    }
    r.ring_ = std::move(ring).value();
    r.terrain_grids_ = world.terrain_grids;
    r.terrain_indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, r.frames_in_flight_};
    r.decal_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, r.frames_in_flight_};
    r.decal_indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, r.frames_in_flight_};
    r.sky_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, r.frames_in_flight_};
    r.visible_instances_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, r.frames_in_flight_};
    if (const Status created = r.create_descriptors(); !created) {
        return created.error();
    }
    if (const Status created = r.create_targets(options.extent); !created) {
        return created.error();
    }
    if (const Status uploaded = r.upload_world(world); !uploaded) {
        return uploaded.error();
    }
    if (const Status uploaded = r.upload_terrain_images(world); !uploaded) {
        return uploaded.error();
    }
    r.layers_ = make_layers({.device = device,
                             .passes = r.passes_,
                             .quality = r.quality_,
                             .frames_in_flight = r.frames_in_flight_,
                             .shader_directory = options.shader_directory});
    return renderer;
}

Renderer::~Renderer() {
    static_cast<void>(device_.wait_idle());
}

Status Renderer::create_descriptors() {
    const auto grids = static_cast<std::uint32_t>(terrain_grids_.size());
    const std::uint32_t images = grids + 3; // and detail, the scene to resolve, the HUD's picture
    const std::array<VkDescriptorPoolSize, 2> sizes{
        {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, frames_in_flight_},
         {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, images + frames_in_flight_}}};
    Result<vulkan::DescriptorPool> pool = vulkan::create_descriptor_pool(device_, frames_in_flight_ + images, sizes);
    if (!pool) {
        return pool.error();
    }
    descriptors_ = std::move(pool).value();

    const bool full = quality_ == Quality::full;
    Result<vulkan::Sampler> terrain = vulkan::create_sampler(
        device_, {.mipmap = full ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST});
    Result<vulkan::Sampler> detail = vulkan::create_sampler(
        device_, full ? vulkan::SamplerOptions{.mipmap = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                               .address = VK_SAMPLER_ADDRESS_MODE_REPEAT}
                      : vulkan::SamplerOptions{.filter = VK_FILTER_NEAREST, // grain: 2 ms less than linear
                                               .address = VK_SAMPLER_ADDRESS_MODE_REPEAT});
    Result<vulkan::Sampler> shadow = vulkan::create_sampler(device_, {.compare_greater = true});
    Result<vulkan::Sampler> point = vulkan::create_sampler(device_, {.filter = VK_FILTER_NEAREST});
    for (const Result<vulkan::Sampler>* sampler : {&terrain, &detail, &shadow, &point}) {
        if (!*sampler) {
            return sampler->error();
        }
    }
    terrain_sampler_ = std::move(terrain).value();
    detail_sampler_ = std::move(detail).value();
    shadow_sampler_ = std::move(shadow).value();
    point_sampler_ = std::move(point).value();

    for (std::uint32_t i = 0; i < frames_in_flight_; ++i) {
        Result<vulkan::Buffer> block = vulkan::Buffer::create(
            device_, sizeof(gpu::FrameBlock), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, vulkan::Placement::upload);
        Result<VkDescriptorSet> set =
            vulkan::allocate_descriptor_set(device_, descriptors_.get(), passes_.frame_set.get());
        if (!block || !set) {
            return !block ? block.error() : set.error();
        }
        vulkan::write_buffer_descriptor(device_, *set, 0, block->get(), sizeof(gpu::FrameBlock));
        slots_.push_back({std::move(block).value(), *set});
    }
    terrain_images_.resize(grids);
    std::vector<VkDescriptorSet*> sets{&resolve_set_, &hud_set_, &detail_set_};
    for (TerrainImage& image : terrain_images_) {
        sets.push_back(&image.set);
    }
    for (VkDescriptorSet* set : sets) {
        Result<VkDescriptorSet> allocated =
            vulkan::allocate_descriptor_set(device_, descriptors_.get(), passes_.image_set.get());
        if (!allocated) {
            return allocated.error();
        }
        *set = *allocated;
    }
    return Ok{};
}

Status Renderer::upload_world(const WorldData& world) {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
    for (const MeshData& mesh : world.object_meshes) {
        meshes_.push_back({static_cast<std::uint32_t>(indices.size()), static_cast<std::uint32_t>(mesh.indices.size()),
                           static_cast<std::int32_t>(vertices.size())});
        vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
        indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
    }
    for (const ObjectInstance& object : world.objects) {
        if (all_runs_.empty() || all_runs_.back().mesh != object.mesh) {
            all_runs_.push_back({object.mesh, static_cast<std::uint32_t>(instances_.size()), 0});
        }
        ++all_runs_.back().count;
        instances_.push_back(make_instance(object));
    }
    visible_ = VisibleObjects(world);
    const std::vector<std::uint32_t> sky = sky_dome_indices();
    for (const Status& uploaded :
         {upload_once(device_, world.terrain.vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, terrain_vertices_),
          upload_once(device_, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, object_vertices_),
          upload_once(device_, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, object_indices_),
          upload_once(device_, instances_, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, all_instances_),
          upload_once(device_, sky, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, sky_indices_)}) {
        if (!uploaded) {
            return uploaded;
        }
    }
    return Ok{};
}

Status Renderer::upload_terrain_images(const WorldData& world) {
    const auto upload = [&](std::uint32_t size, const std::vector<std::byte>& texels, VkSampler sampler,
                            VkDescriptorSet set, std::optional<vulkan::Image>& image) -> Status {
        Result<vulkan::Image> created =
            vulkan::Image::create(device_, {VK_FORMAT_R8G8B8A8_UNORM,
                                            {size, size},
                                            VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                            vulkan::mip_level_count({size, size})});
        if (!created) {
            return created.error();
        }
        image = std::move(created).value();
        vulkan::write_image_descriptor(device_, set, 0, image->view(), sampler);
        return vulkan::upload_image(device_, *image, vulkan::make_mip_chain(texels, {size, size}));
    };
    Status status = upload(kDetailSize, detail_texels(), detail_sampler_.get(), detail_set_, detail_image_);
    for (std::size_t i = 0; status && i < terrain_grids_.size(); ++i) {
        const TerrainGrid& grid = terrain_grids_[i];
        TerrainImage& terrain = terrain_images_[i];
        terrain.from_position = image_from_position(grid);
        status = upload(grid.samples, terrain_texels(world.terrain.vertices, grid), terrain_sampler_.get(), terrain.set,
                        terrain.image);
    }
    return status;
}

Status Renderer::create_targets(VkExtent2D extent) {
    const bool full = quality_ == Quality::full;
    const auto create = [&](const vulkan::RenderPassOptions& options, const vulkan::RenderPass& pass, VkExtent2D size,
                            VkImageUsageFlags color, VkImageUsageFlags depth, vulkan::RenderTarget& target) -> Status {
        Result<vulkan::RenderTarget> created =
            vulkan::create_render_target(device_, options, pass.get(), size, color, depth);
        if (!created) {
            return created.error();
        }
        target = std::move(created).value();
        return Ok{};
    };
    Status status = create(passes_.scene_options, passes_.scene, extent,
                           full ? VK_IMAGE_USAGE_SAMPLED_BIT : VK_IMAGE_USAGE_TRANSFER_SRC_BIT, 0, scene_target_);
    if (status && full) {
        status =
            create(passes_.final_options, passes_.final, extent, VK_IMAGE_USAGE_TRANSFER_SRC_BIT, 0, final_target_);
    }
    if (status && full && !shadow_target_.depth) {
        status = create(passes_.shadow_options, passes_.shadow, {kShadowMapSize, kShadowMapSize}, 0,
                        VK_IMAGE_USAGE_SAMPLED_BIT, shadow_target_);
    }
    if (status && full) {
        vulkan::write_image_descriptor(device_, resolve_set_, 0, scene_target_.color->view(), point_sampler_.get());
        for (const Slot& slot : slots_) {
            vulkan::write_image_descriptor(device_, slot.set, 1, shadow_target_.depth->view(), shadow_sampler_.get());
        }
    }
    extent_ = extent;
    return status;
}

Status Renderer::resize(VkExtent2D extent) {
    if (const Status idle = device_.wait_idle(); !idle) {
        return idle;
    }
    if (const Status created = create_targets(extent); !created) {
        return created;
    }
    return hud_ ? hud_->resize(extent) : Status(Ok{});
}

Status Renderer::enable_hud(const vulkan::Instance& instance) {
    Result<std::unique_ptr<Hud>> hud = Hud::create(instance, device_, passes_, hud_set_, extent_, frames_in_flight_);
    if (!hud) {
        return hud.error();
    }
    hud_ = std::move(hud).value();
    return Ok{};
}

Status Renderer::update_buffers(const FrameData& frame, std::uint32_t slot, DrawStats& stats) {
    Status status = Ok{};
    const auto replace = [&](DynamicBuffer& buffer, std::size_t size_bytes, auto&& write) {
        if (status) {
            status = buffer.replace(device_, size_bytes, write);
            ++stats.uploads;
            stats.upload_bytes += size_bytes;
        }
    };
    const auto copy = [&](DynamicBuffer& buffer, const auto& items) {
        replace(buffer, items.size_bytes(), [&](std::span<std::byte> bytes) {
            if (!items.empty()) {
                std::memcpy(bytes.data(), items.data(), items.size_bytes());
            }
        });
    };
    if (terrain_revision_ != frame.terrain_indices_revision) {
        terrain_revision_ = frame.terrain_indices_revision;
        std::vector<std::uint32_t> sorted(frame.terrain_indices.size());
        terrain_runs_ = sort_terrain(frame.terrain_indices, terrain_grids_, glm::vec2(frame.camera_m), sorted);
        copy(terrain_indices_, std::span<const std::uint32_t>(sorted));
    }
    if (decal_revision_ != frame.shadow_revision && quality_ == Quality::lean) {
        decal_revision_ = frame.shadow_revision;
        copy(decal_vertices_, frame.shadow_vertices);
        copy(decal_indices_, frame.shadow_indices);
    }
    if (sky_revision_ != frame.sky_revision) {
        sky_revision_ = frame.sky_revision;
        sky_extract_ = extract_sky(frame);
        if (!frame.sky_vertices.empty()) {
            assert(frame.sky_vertices.size() == SkyDome::vertices);
            copy(sky_vertices_, frame.sky_vertices);
        }
    }
    if (!frame.sky_vertices.empty()) {
        sky_runs_ = visible_sky(sky_patches_, frame.sky_vertices, side_planes(clip_from_relative(frame)));
    }
    stats.objects_considered = static_cast<std::uint32_t>(instances_.size());
    if (visible_.update(clip_from_relative(frame), frame.camera_m, pixels_per_radian(frame, extent_.height))) {
        replace(visible_instances_, visible_.objects().size() * sizeof(gpu::Instance), [&](std::span<std::byte> bytes) {
            std::byte* to = bytes.data();
            for (const std::uint32_t object : visible_.objects()) {
                std::memcpy(to, &instances_[object], sizeof(gpu::Instance));
                to += sizeof(gpu::Instance);
            }
        });
    }
    stats.objects_drawn = static_cast<std::uint32_t>(visible_.objects().size());
    block_ = make_frame_block(frame, sky_extract_, extent_.height);
    std::memcpy(slots_[slot].block->mapped().data(), &block_, sizeof block_);
    return status;
}

void Renderer::record_objects(VkCommandBuffer commands, std::span<const ObjectRun> runs, VkBuffer instances,
                              DrawStats& stats) const {
    bind_vertices(commands, 0, object_vertices_->get());
    bind_vertices(commands, 1, instances);
    vkCmdBindIndexBuffer(commands, object_indices_->get(), 0, VK_INDEX_TYPE_UINT32);
    for (const ObjectRun& run : runs) {
        const Mesh& mesh = meshes_[run.mesh];
        vkCmdDrawIndexed(commands, mesh.index_count, run.count, mesh.first_index, mesh.vertex_offset, run.first);
        ++stats.draws;
        stats.triangles += mesh.index_count / 3 * run.count;
    }
}

void Renderer::record_shadow_map(VkCommandBuffer commands, DrawStats& stats) {
    // Seen from the light, objects stand still: the map holds as long as light and camera do.
    if (block_.shadow_from_relative == shadow_drawn_for_ && block_.camera_m == shadow_drawn_at_) {
        return;
    }
    shadow_drawn_for_ = block_.shadow_from_relative;
    shadow_drawn_at_ = block_.camera_m;
    vulkan::begin_render_pass(commands, passes_.shadow.get(), shadow_target_);
    if (!instances_.empty()) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_[Passes::shadow_map]);
        record_objects(commands, all_runs_, all_instances_->get(), stats);
    }
    vkCmdEndRenderPass(commands);
}

void Renderer::record_scene(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const auto bind = [&](Passes::Name name) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_[name]);
    };
    const auto draw_indexed = [&](std::uint32_t count, std::uint32_t first_index) {
        vkCmdDrawIndexed(commands, count, 1, first_index, 0, 0);
        ++stats.draws;
        stats.triangles += count / 3;
    };
    const VkPipelineLayout layout = passes_.scene_layout.get();
    const auto push = [&](const ScenePush& constants) {
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                           sizeof constants, &constants);
    };
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 2, 1, &detail_set_, 0, nullptr);
    const auto bind_terrain_image = [&](std::uint32_t grid, float distance_m) {
        const TerrainImage& terrain = terrain_images_[grid];
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 1, 1, &terrain.set, 0, nullptr);
        const auto level = [&](float texel_m) { return level_at(distance_m, block_.camera_m.w, texel_m); };
        push({terrain.from_position,
              {kDetailTiles[0], kDetailTiles[1]},
              {level(terrain_grids_[grid].spacing_m), level(kDetailTiles[1] / kDetailSize)}});
    };
    // Near things first, the sky last: what is hidden costs no fragment.
    if (!visible_.objects().empty()) {
        bind(Passes::objects);
        if (!terrain_images_.empty()) {
            bind_terrain_image(0, 0.0F); // objects do not read it, but share the terrain's shader
        }
        record_objects(commands, visible_.runs(), visible_instances_.get(), stats);
    }
    for (Layer* layer : drawn_layers_) {
        layer->record_opaque(commands, frame, stats);
    }
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 2, 1, &detail_set_, 0, nullptr);
    if (!frame.terrain_indices.empty()) {
        bind_vertices(commands, 0, terrain_vertices_->get());
        bind_vertices(commands, 1, terrain_vertices_->get()); // not read: the terrain is one piece
        vkCmdBindIndexBuffer(commands, terrain_indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        for (const TerrainRun& run : terrain_runs_) {
            bind(run.near ? Passes::terrain : Passes::terrain_far);
            bind_terrain_image(run.grid, run.distance_m);
            draw_indexed(run.index_count, run.first_index);
        }
    }
    if (!frame.shadow_indices.empty() && quality_ == Quality::lean &&
        (is_lit(frame.sun_illuminance_lux) || is_lit(frame.moon_illuminance_lux))) {
        bind(Passes::decals);
        bind_vertices(commands, 0, decal_vertices_.get());
        vkCmdBindIndexBuffer(commands, decal_indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        draw_indexed(static_cast<std::uint32_t>(frame.shadow_indices.size()), 0);
    }
    if (!frame.sky_vertices.empty()) {
        bind(Passes::sky);
        bind_vertices(commands, 0, sky_vertices_.get());
        vkCmdBindIndexBuffer(commands, sky_indices_->get(), 0, VK_INDEX_TYPE_UINT32);
        for (const IndexRun& run : sky_runs_) {
            draw_indexed(run.count, run.first);
        }
    }
    const auto draw_disc = [&](Passes::Name name, std::uint32_t body) {
        bind(name);
        push({.grid = glm::vec4(std::bit_cast<float>(body), 0.0F, 0.0F, 0.0F)});
        vkCmdDraw(commands, 4, 1, 0, 0);
        ++stats.draws;
        stats.triangles += 2;
    };
    if (is_lit(frame.moon_seen_lux.value_or(frame.moon_illuminance_lux))) {
        draw_disc(Passes::moon, 1);
    }
    if (is_lit(frame.sun_seen_lux.value_or(frame.sun_illuminance_lux))) {
        draw_disc(Passes::sun, 0);
    }
    for (Layer* layer : drawn_layers_) {
        layer->record_blended(commands, frame, stats);
    }
}

const vulkan::Image& Renderer::output() const {
    return quality_ == Quality::full ? *final_target_.color : *scene_target_.color;
}

Result<DrawStats> Renderer::draw(const FrameData& frame, vulkan::Swapchain* swapchain, ImDrawData* hud) {
    assert(hud == nullptr || hud_ != nullptr);
    DrawStats stats;
    Result<vulkan::FrameRing::Frame> begun = ring_->begin();
    if (!begun) {
        return begun.error();
    }
    const VkCommandBuffer commands = begun->commands;
    if (const Status updated = update_buffers(frame, begun->slot, stats); !updated) {
        return updated.error();
    }
    drawn_layers_.clear();
    for (const std::unique_ptr<Layer>& layer : layers_) {
        if (layer->wanted(frame)) {
            if (const Status uploaded = layer->upload(frame, extent_, begun->slot, stats); !uploaded) {
                return uploaded.error();
            }
            drawn_layers_.push_back(layer.get());
        }
    }
    for (Layer* layer : drawn_layers_) {
        layer->record_before(commands, frame, stats);
    }
    if (hud != nullptr) {
        stats.hud_redrawn = hud_->record_picture(commands, *hud);
    }
    const auto overlay = [&] {
        for (Layer* layer : drawn_layers_) {
            layer->record_overlay(commands, frame, stats);
        }
        if (hud != nullptr) {
            hud_->record_overlay(commands, passes_[Passes::hud_picture], passes_.image_layout.get());
        }
    };
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.scene_layout.get(), 0, 1,
                            &slots_[begun->slot].set, 0, nullptr);
    if (quality_ == Quality::full) {
        record_shadow_map(commands, stats);
        vulkan::begin_render_pass(commands, passes_.scene.get(), scene_target_);
        record_scene(commands, frame, stats);
        vkCmdEndRenderPass(commands);
        vulkan::begin_render_pass(commands, passes_.final.get(), final_target_);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_[Passes::resolve]);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.image_layout.get(), 0, 1,
                                &resolve_set_, 0, nullptr);
        vkCmdDraw(commands, 3, 1, 0, 0);
    } else {
        vulkan::begin_render_pass(commands, passes_.scene.get(), scene_target_);
        record_scene(commands, frame, stats);
    }
    overlay();
    vkCmdEndRenderPass(commands);

    std::optional<vulkan::Swapchain::Acquired> acquired;
    vulkan::FrameSignals signals;
    if (swapchain != nullptr) {
        Result<std::optional<vulkan::Swapchain::Acquired>> next = swapchain->acquire(begun->slot);
        if (!next) {
            return next.error();
        }
        acquired = *next;
        if (acquired) {
            swapchain->record_copy(commands, output(), *acquired);
            signals = {acquired->available, VK_PIPELINE_STAGE_TRANSFER_BIT, acquired->finished};
        }
    }
    if (const Status submitted = ring_->submit(*begun, signals); !submitted) {
        return submitted.error();
    }
    if (acquired) {
        const Result<bool> presented = swapchain->present(*acquired);
        if (!presented) {
            return presented.error();
        }
        stats.presented = *presented;
    }
    return stats;
}

Status Renderer::capture(const FrameData& frame, const glm::vec3& point_m, int face, std::span<glm::vec3> texels) {
    if (const Status done = finish(); !done) {
        return done;
    }
    if (!capture_) {
        std::vector<MeshRange> meshes;
        for (const Mesh& mesh : meshes_) {
            meshes.push_back({mesh.first_index, mesh.index_count, mesh.vertex_offset});
        }
        Result<std::unique_ptr<SceneCapture>> created =
            SceneCapture::create(device_, shader_directory_,
                                 {.terrain_vertices = terrain_vertices_ ? terrain_vertices_->get() : VK_NULL_HANDLE,
                                  .object_vertices = object_vertices_ ? object_vertices_->get() : VK_NULL_HANDLE,
                                  .object_indices = object_indices_ ? object_indices_->get() : VK_NULL_HANDLE,
                                  .meshes = std::move(meshes),
                                  .instances = instances_,
                                  .objects = visible_,
                                  .sky_indices = sky_indices_->get(),
                                  .sky_index_count = static_cast<std::uint32_t>(sky_dome_indices().size())});
        if (!created) {
            return created.error();
        }
        capture_ = std::move(created).value();
    }
    return capture_->render(frame, point_m, face, texels);
}

Status Renderer::finish() {
    for (std::uint32_t slot = 0; slot < ring_->size(); ++slot) {
        if (const Status done = ring_->wait(slot); !done) {
            return done;
        }
    }
    return Ok{};
}

Result<std::vector<std::byte>> Renderer::read_pixels() {
    if (const Status done = finish(); !done) {
        return done.error();
    }
    return vulkan::read_image(device_, output(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

std::vector<std::string> Renderer::reload_shaders() {
    std::vector<std::string> messages;
    std::vector<vulkan::ReloadablePipeline*> pipelines;
    for (std::optional<vulkan::ReloadablePipeline>& pipeline : passes_.pipelines) {
        if (pipeline) {
            pipelines.push_back(&*pipeline);
        }
    }
    for (const std::unique_ptr<Layer>& layer : layers_) {
        const std::vector<vulkan::ReloadablePipeline*> more = layer->pipelines();
        pipelines.insert(pipelines.end(), more.begin(), more.end());
    }
    for (vulkan::ReloadablePipeline* pipeline : pipelines) {
        const Result<bool> reloaded = pipeline->reload_if_changed();
        if (!reloaded) {
            messages.push_back(reloaded.error().message());
        } else if (*reloaded) {
            messages.push_back(pipeline->name() + " reloaded");
        }
    }
    return messages;
}

} // namespace alpenglow::sandbox
