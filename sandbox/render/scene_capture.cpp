#include "sandbox/render/scene_capture.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include <glm/gtc/packing.hpp>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/layers.hpp"
#include "sandbox/render/upload.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float near_m = 0.05F; // walls may stand close to a probe
constexpr float far_m = 1e6F;

// The three axes of a face as seen from inside: columns to the right, rows down, and out. Cube maps count columns as
// seen from outside, so that a picture is mirrored.
struct FaceAxes {
    glm::vec3 right, down, forward;
};
constexpr std::array<FaceAxes, 6> kFaces{{
    {{0, 0, 1}, {0, -1, 0}, {1, 0, 0}},
    {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0}},
    {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
    {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
}};

glm::mat4 view_of(const FaceAxes& axes, const glm::vec3& eye) {
    const auto along = [&](const glm::vec3& axis) { return -(axis.x * eye.x + axis.y * eye.y + axis.z * eye.z); };
    const glm::vec3 r = axes.right;
    const glm::vec3 u = -axes.down;
    const glm::vec3 f = axes.forward;
    return {glm::vec4(r.x, u.x, -f.x, 0.0F), glm::vec4(r.y, u.y, -f.y, 0.0F), glm::vec4(r.z, u.z, -f.z, 0.0F),
            glm::vec4(along(r), along(u), -along(f), 1.0F)};
}

// A right angle across.
glm::mat4 face_projection() {
    const float depth = far_m / (near_m - far_m);
    return {glm::vec4(1.0F, 0.0F, 0.0F, 0.0F), glm::vec4(0.0F, -1.0F, 0.0F, 0.0F), glm::vec4(0.0F, 0.0F, depth, -1.0F),
            glm::vec4(0.0F, 0.0F, near_m * depth, 0.0F)};
}

} // namespace

Result<std::unique_ptr<SceneCapture>> SceneCapture::create(const vulkan::Device& device,
                                                           const std::filesystem::path& shader_directory,
                                                           SceneGeometry geometry) {
    std::unique_ptr<SceneCapture> capture(new SceneCapture(device, std::move(geometry)));
    if (const Status created = capture->create_passes(shader_directory); !created) {
        return created.error();
    }
    if (const Status created = capture->create_buffers(); !created) {
        return created.error();
    }
    capture->layers_ = make_layers({.device = device,
                                    .passes = capture->passes_,
                                    .quality = Quality::full,
                                    .frames_in_flight = 1,
                                    .shader_directory = shader_directory});
    return capture;
}

Status SceneCapture::create_passes(const std::filesystem::path& shader_directory) {
    Result<Passes> passes = create_capture_passes(device_, shader_directory);
    if (!passes) {
        return passes.error();
    }
    passes_ = std::move(passes).value();
    constexpr auto edge = static_cast<std::uint32_t>(capture_edge);
    Result<vulkan::RenderTarget> target = vulkan::create_render_target(
        device_, passes_.scene_options, passes_.scene.get(), {edge, edge}, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    if (!target) {
        return target.error();
    }
    target_ = std::move(target).value();
    return Ok{};
}

Status SceneCapture::create_buffers() {
    constexpr VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1};
    Result<vulkan::DescriptorPool> pool = vulkan::create_descriptor_pool(device_, 1, {&size, 1});
    Result<vulkan::Buffer> block = vulkan::Buffer::create(
        device_, sizeof(gpu::FrameBlock), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, vulkan::Placement::upload);
    if (!pool || !block) {
        return !pool ? pool.error() : block.error();
    }
    descriptors_ = std::move(pool).value();
    block_ = std::move(block).value();
    Result<VkDescriptorSet> set = vulkan::allocate_descriptor_set(device_, descriptors_.get(), passes_.frame_set.get());
    if (!set) {
        return set.error();
    }
    set_ = *set;
    vulkan::write_buffer_descriptor(device_, set_, 0, block_->get(), sizeof(gpu::FrameBlock));
    sky_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, 1};
    instances_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, 1};
    terrain_indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, 1};
    return Ok{};
}

Status SceneCapture::upload(const FrameData& view, DrawStats& stats) {
    Status status = Ok{};
    if (sky_revision_ != view.sky_revision) {
        sky_revision_ = view.sky_revision;
        sky_extract_ = extract_sky(view);
        if (!view.sky_vertices.empty()) {
            status = sky_vertices_.replace(device_, view.sky_vertices);
        }
    }
    if (status && terrain_revision_ != view.terrain_indices_revision) {
        terrain_revision_ = view.terrain_indices_revision;
        status = terrain_indices_.replace(device_, view.terrain_indices);
    }
    const gpu::FrameBlock block = make_frame_block(view, sky_extract_, capture_edge);
    std::memcpy(block_->mapped().data(), &block, sizeof block);
    geometry_.objects.update(clip_from_relative(view), view.camera_m, pixels_per_radian(view, capture_edge));
    if (status) {
        status = instances_.replace(device_, geometry_.objects.objects().size() * sizeof(gpu::Instance),
                                    [&](std::span<std::byte> bytes) {
                                        std::byte* to = bytes.data();
                                        for (const std::uint32_t object : geometry_.objects.objects()) {
                                            std::memcpy(to, &geometry_.instances[object], sizeof(gpu::Instance));
                                            to += sizeof(gpu::Instance);
                                        }
                                    });
    }
    drawn_layers_.clear();
    for (const std::unique_ptr<Layer>& layer : layers_) {
        if (status && layer->wanted(view)) {
            status = layer->upload(view, target_.extent, 0, stats);
            drawn_layers_.push_back(layer.get());
        }
    }
    return status;
}

void SceneCapture::record(VkCommandBuffer commands, const FrameData& view, DrawStats& stats) {
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.scene_layout.get(), 0, 1, &set_, 0,
                            nullptr);
    for (Layer* layer : drawn_layers_) {
        layer->record_before(commands, view, stats);
    }
    const auto bind = [&](Passes::Name name) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_[name]);
    };
    vulkan::begin_render_pass(commands, passes_.scene.get(), target_);
    if (!geometry_.objects.objects().empty()) {
        bind(Passes::objects);
        bind_vertices(commands, 0, geometry_.object_vertices);
        bind_vertices(commands, 1, instances_.get());
        vkCmdBindIndexBuffer(commands, geometry_.object_indices, 0, VK_INDEX_TYPE_UINT32);
        for (const ObjectRun& run : geometry_.objects.runs()) {
            const MeshRange& mesh = geometry_.meshes[run.mesh];
            vkCmdDrawIndexed(commands, mesh.index_count, run.count, mesh.first_index, mesh.vertex_offset, run.first);
        }
    }
    for (Layer* layer : drawn_layers_) {
        layer->record_opaque(commands, view, stats);
    }
    if (!view.terrain_indices.empty()) {
        bind(Passes::terrain);
        bind_vertices(commands, 0, geometry_.terrain_vertices);
        bind_vertices(commands, 1, geometry_.terrain_vertices); // not read
        vkCmdBindIndexBuffer(commands, terrain_indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands, static_cast<std::uint32_t>(view.terrain_indices.size()), 1, 0, 0, 0);
    }
    if (!view.sky_vertices.empty()) {
        bind(Passes::sky);
        bind_vertices(commands, 0, sky_vertices_.get());
        vkCmdBindIndexBuffer(commands, geometry_.sky_indices, 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands, geometry_.sky_index_count, 1, 0, 0, 0);
    }
    for (Layer* layer : drawn_layers_) {
        layer->record_blended(commands, view, stats);
    }
    vkCmdEndRenderPass(commands);
}

Status SceneCapture::render(const FrameData& frame, const glm::vec3& point_m, int face, std::span<glm::vec3> texels) {
    assert(face >= 0 && face < 6 && texels.size() == std::size_t{capture_edge} * capture_edge);
    FrameData view = frame;
    view.overlay = nullptr; // lies over the player's picture alone
    view.view = view_of(kFaces[static_cast<std::size_t>(face)], point_m);
    view.projection = face_projection();
    view.camera_m = point_m;
    view.capturing = true;
    DrawStats stats;
    if (const Status uploaded = upload(view, stats); !uploaded) {
        return uploaded;
    }
    if (const Status done =
            vulkan::submit_and_wait(device_, [&](VkCommandBuffer commands) { record(commands, view, stats); });
        !done) {
        return done;
    }
    const auto bytes = vulkan::read_image(device_, *target_.color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    if (!bytes) {
        return bytes.error();
    }
    const float per_exposure = 1.0F / view.exposure;
    for (int row = 0; row < capture_edge; ++row) {
        for (int column = 0; column < capture_edge; ++column) {
            std::uint64_t packed = 0;
            const auto texel = static_cast<std::size_t>(row * capture_edge + capture_edge - 1 - column);
            std::memcpy(&packed, bytes->data() + texel * sizeof packed, sizeof packed);
            texels[static_cast<std::size_t>(row * capture_edge + column)] =
                glm::vec3(glm::unpackHalf4x16(packed)) * per_exposure;
        }
    }
    return Ok{};
}

} // namespace alpenglow::sandbox
