#include "sandbox/render/renderer.hpp"

#include <array>
#include <cassert>
#include <cstring>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/sky_dome.hpp"

namespace alpenglow::sandbox {
namespace {

// Device-local, filled once. None for no items.
template <class T>
Status upload_once(const vulkan::Device& device, const std::vector<T>& items, VkBufferUsageFlags usage,
                   std::optional<vulkan::Buffer>& buffer) {
    if (items.empty()) {
        return Ok{};
    }
    const std::span<const std::byte> bytes = std::as_bytes(std::span(items));
    Result<vulkan::Buffer> created = vulkan::Buffer::create(device, bytes.size(), usage, vulkan::Placement::device);
    if (!created) {
        return created.error();
    }
    buffer = std::move(created).value();
    return vulkan::upload_buffer(device, *buffer, bytes);
}

// The dome's vertices and the skirt below: the horizon's light down to the nadir.
void write_sky(std::span<const SkyVertex> sky, std::span<std::byte> bytes) {
    std::memcpy(bytes.data(), sky.data(), sky.size_bytes());
    std::array<SkyVertex, SkyDome::skirt_vertices> skirt{};
    for (std::uint32_t i = 0; i < SkyDome::azimuths; ++i) {
        const SkyVertex& horizon = sky[i];
        skirt[i] = {{horizon.direction.x, horizon.direction.y, -0.1F}, horizon.radiance_cd_m2};
        skirt[SkyDome::azimuths + i] = {{0.0F, 0.0F, -1.0F}, horizon.radiance_cd_m2};
    }
    std::memcpy(bytes.data() + sky.size_bytes(), skirt.data(), sizeof skirt);
}

void bind_vertices(VkCommandBuffer commands, std::uint32_t binding, VkBuffer buffer) {
    const VkDeviceSize offset = 0;
    vkCmdBindVertexBuffers(commands, binding, 1, &buffer, &offset);
}

bool is_lit(glm::vec3 illuminance) {
    return illuminance.x > 0.0F || illuminance.y > 0.0F || illuminance.z > 0.0F;
}

} // namespace

Result<std::unique_ptr<Renderer>> Renderer::create(const vulkan::Device& device, const WorldData& world,
                                                   const RendererOptions& options) {
    std::unique_ptr<Renderer> renderer(new Renderer(device));
    Renderer& r = *renderer;
    r.quality_ = options.quality.value_or(device.info().is_cpu ? Quality::lean : Quality::full);
    const std::uint32_t frames = options.frames_in_flight;

    Result<Passes> passes = create_passes(device, r.quality_, options.shader_directory);
    if (!passes) {
        return passes.error();
    }
    r.passes_ = std::move(passes).value();
    Result<vulkan::FrameRing> ring = vulkan::FrameRing::create(device, frames);
    if (!ring) {
        return ring.error();
    }
    r.ring_ = std::move(ring).value();
    const std::array<VkDescriptorPoolSize, 2> sizes{
        {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, frames}, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2 + frames}}};
    Result<vulkan::DescriptorPool> descriptors = vulkan::create_descriptor_pool(device, frames + 2, sizes);
    if (!descriptors) {
        return descriptors.error();
    }
    r.descriptors_ = std::move(descriptors).value();
    for (std::uint32_t i = 0; i < frames; ++i) {
        Result<vulkan::Buffer> block = vulkan::Buffer::create(
            device, sizeof(gpu::FrameBlock), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, vulkan::Placement::upload);
        Result<VkDescriptorSet> set =
            vulkan::allocate_descriptor_set(device, r.descriptors_.get(), r.passes_.frame_set.get());
        if (!block || !set) {
            return !block ? block.error() : set.error();
        }
        const VkDescriptorBufferInfo info{block->get(), 0, sizeof(gpu::FrameBlock)};
        VkWriteDescriptorSet write{};
        write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write.dstSet = *set;
        write.descriptorCount = 1;
        write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        write.pBufferInfo = &info;
        vkUpdateDescriptorSets(device.get(), 1, &write, 0, nullptr);
        r.slots_.push_back({std::move(block).value(), *set});
    }
    r.terrain_indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, frames};
    r.shadow_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, frames};
    r.shadow_indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, frames};
    r.sky_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, frames};
    r.visible_instances_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, frames};
    if (Status uploaded = r.upload_world(world); !uploaded) {
        return uploaded.error();
    }
    if (Status created = r.create_targets(options.extent); !created) {
        return created.error();
    }
    return renderer;
}

Renderer::~Renderer() {
    static_cast<void>(device_.wait_idle());
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
        instances_.push_back(make_instance(object));
    }
    visible_ = VisibleObjects(world);
    const std::vector<std::uint32_t> sky = sky_dome_indices();
    sky_index_count_ = static_cast<std::uint32_t>(sky.size());
    for (const Status& uploaded :
         {upload_once(device_, world.terrain.vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, terrain_vertices_),
          upload_once(device_, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, object_vertices_),
          upload_once(device_, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, object_indices_),
          upload_once(device_, sky, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, sky_indices_)}) {
        if (!uploaded) {
            return uploaded;
        }
    }
    return Ok{};
}

Status Renderer::create_targets(VkExtent2D extent) {
    Result<vulkan::RenderTarget> target = vulkan::create_render_target(
        device_, passes_.scene_options, passes_.scene.get(), extent, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    if (!target) {
        return target.error();
    }
    scene_target_ = std::move(target).value();
    extent_ = extent;
    return Ok{};
}

Status Renderer::resize(VkExtent2D extent) {
    if (const Status idle = device_.wait_idle(); !idle) {
        return idle;
    }
    return create_targets(extent);
}

Status Renderer::update_buffers(const FrameData& frame, std::uint32_t slot, DrawStats& stats) {
    Status status = Ok{};
    const auto replace = [&](DynamicBuffer& buffer, std::size_t size_bytes, auto&&... content) {
        if (status) {
            status = buffer.replace(device_, content...);
            ++stats.uploads;
            stats.upload_bytes += size_bytes;
        }
    };
    if (terrain_revision_ != frame.terrain_indices_revision) {
        terrain_revision_ = frame.terrain_indices_revision;
        replace(terrain_indices_, frame.terrain_indices.size_bytes(), frame.terrain_indices);
    }
    if (shadow_revision_ != frame.shadow_revision) {
        shadow_revision_ = frame.shadow_revision;
        replace(shadow_vertices_, frame.shadow_vertices.size_bytes(), frame.shadow_vertices);
        replace(shadow_indices_, frame.shadow_indices.size_bytes(), frame.shadow_indices);
    }
    if (sky_revision_ != frame.sky_revision) {
        sky_revision_ = frame.sky_revision;
        sky_extract_ = extract_sky(frame);
        if (!frame.sky_vertices.empty()) {
            assert(frame.sky_vertices.size() == SkyDome::vertices);
            const std::size_t size = frame.sky_vertices.size_bytes() + SkyDome::skirt_vertices * sizeof(SkyVertex);
            replace(sky_vertices_, size, size,
                    [&](std::span<std::byte> bytes) { write_sky(frame.sky_vertices, bytes); });
        }
    }
    stats.objects_considered = static_cast<std::uint32_t>(instances_.size());
    if (visible_.update(clip_from_relative(frame), frame.camera_m, pixels_per_radian(frame, extent_.height))) {
        const std::size_t size = visible_.objects().size() * sizeof(gpu::Instance);
        replace(visible_instances_, size, size, [&](std::span<std::byte> bytes) {
            std::byte* to = bytes.data();
            for (const std::uint32_t object : visible_.objects()) {
                std::memcpy(to, &instances_[object], sizeof(gpu::Instance));
                to += sizeof(gpu::Instance);
            }
        });
    }
    stats.objects_drawn = static_cast<std::uint32_t>(visible_.objects().size());
    const gpu::FrameBlock block = make_frame_block(frame, sky_extract_, extent_.height);
    std::memcpy(slots_[slot].block->mapped().data(), &block, sizeof block);
    return status;
}

void Renderer::record_scene(VkCommandBuffer commands, const FrameData& frame, std::uint32_t slot,
                            DrawStats& stats) const {
    const auto bind = [&](Passes::Name name) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_[name]);
    };
    const auto draw_indexed = [&](std::uint32_t count, std::uint32_t instances, std::uint32_t first_index,
                                  std::int32_t vertex_offset, std::uint32_t first_instance) {
        vkCmdDrawIndexed(commands, count, instances, first_index, vertex_offset, first_instance);
        ++stats.draws;
        stats.triangles += count / 3 * instances;
    };
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.scene_layout.get(), 0, 1,
                            &slots_[slot].set, 0, nullptr);
    // Near things first, the sky last: what is hidden costs no fragment.
    if (!visible_.objects().empty()) {
        bind(Passes::objects);
        bind_vertices(commands, 0, object_vertices_->get());
        bind_vertices(commands, 1, visible_instances_.get());
        vkCmdBindIndexBuffer(commands, object_indices_->get(), 0, VK_INDEX_TYPE_UINT32);
        for (const ObjectRun& run : visible_.runs()) {
            const Mesh& mesh = meshes_[run.mesh];
            draw_indexed(mesh.index_count, run.count, mesh.first_index, mesh.vertex_offset, run.first);
        }
    }
    if (!frame.terrain_indices.empty()) {
        bind(Passes::terrain);
        bind_vertices(commands, 0, terrain_vertices_->get());
        bind_vertices(commands, 1, terrain_vertices_->get()); // not read: the terrain is one piece
        vkCmdBindIndexBuffer(commands, terrain_indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        draw_indexed(static_cast<std::uint32_t>(frame.terrain_indices.size()), 1, 0, 0, 0);
    }
    if (!frame.shadow_indices.empty() && is_lit(frame.sun_illuminance_lux)) {
        bind(Passes::shadows);
        bind_vertices(commands, 0, shadow_vertices_.get());
        vkCmdBindIndexBuffer(commands, shadow_indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        draw_indexed(static_cast<std::uint32_t>(frame.shadow_indices.size()), 1, 0, 0, 0);
    }
    if (!frame.sky_vertices.empty()) {
        bind(Passes::sky);
        bind_vertices(commands, 0, sky_vertices_.get());
        vkCmdBindIndexBuffer(commands, sky_indices_->get(), 0, VK_INDEX_TYPE_UINT32);
        draw_indexed(sky_index_count_, 1, 0, 0, 0);
    }
    const auto draw_disc = [&](Passes::Name name, std::uint32_t body) {
        bind(name);
        vkCmdPushConstants(commands, passes_.scene_layout.get(), VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof body, &body);
        vkCmdDraw(commands, 4, 1, 0, 0);
        ++stats.draws;
        stats.triangles += 2;
    };
    if (is_lit(frame.moon_illuminance_lux)) {
        draw_disc(Passes::moon, 1);
    }
    if (is_lit(frame.sun_illuminance_lux)) {
        draw_disc(Passes::sun, 0);
    }
}

Result<DrawStats> Renderer::draw(const FrameData& frame, vulkan::Swapchain* swapchain) {
    DrawStats stats;
    Result<vulkan::FrameRing::Frame> begun = ring_->begin();
    if (!begun) {
        return begun.error();
    }
    const VkCommandBuffer commands = begun->commands;
    if (const Status updated = update_buffers(frame, begun->slot, stats); !updated) {
        return updated.error();
    }
    vulkan::begin_render_pass(commands, passes_.scene.get(), scene_target_);
    record_scene(commands, frame, begun->slot, stats);
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
            swapchain->record_copy(commands, *scene_target_.color, *acquired);
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
    return vulkan::read_image(device_, *scene_target_.color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

std::vector<std::string> Renderer::reload_shaders() {
    std::vector<std::string> messages;
    for (vulkan::ReloadablePipeline& pipeline : passes_.pipelines) {
        const Result<bool> reloaded = pipeline.reload_if_changed();
        if (!reloaded) {
            messages.push_back(reloaded.error().message());
        } else if (*reloaded) {
            messages.push_back(pipeline.name() + " reloaded");
        }
    }
    return messages;
}

} // namespace alpenglow::sandbox
