#include "sandbox/render/impostor_layer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>

#include <glm/common.hpp>
#include <glm/gtc/packing.hpp>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/pipelines.hpp"
#include "sandbox/render/tone.hpp"
#include "sandbox/render/upload.hpp"
#include "sandbox/world/impostor_render_data.hpp"

#include <alpenglow_shaders/colored.vert.hpp>
#include <alpenglow_shaders/impostor.frag.hpp>
#include <alpenglow_shaders/impostor.vert.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr std::array<VkVertexInputBindingDescription, 1> kColorBindings{
    {{0, sizeof(ColorVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 2> kColorAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ColorVertex, position_m)},
     {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(ColorVertex, light)}}};
constexpr std::array<VkVertexInputBindingDescription, 1> kPictureBindings{
    {{0, sizeof(ImpostorVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 3> kPictureAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ImpostorVertex, position_m)},
     {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(ImpostorVertex, texel)},
     {2, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ImpostorVertex, weights)}}};

// Premultiplied display colours, 8 bits.
void encode_lean(const ImpostorTile& tile, float exposure, std::byte* to) {
    const glm::vec3 gain = exposure * tile.gain;
    for (std::size_t i = 0; i < tile.texels.size(); ++i) {
        const glm::vec4 c = tile.texels[i];
        std::array<std::uint8_t, 4> bytes{};
        if (c.w > 1e-4F) {
            const glm::vec3 shown = display(glm::vec3(c) * gain / c.w) * c.w;
            const auto byte = [](float v) {
                return static_cast<std::uint8_t>(std::clamp(v, 0.0F, 1.0F) * 255.0F + 0.5F);
            };
            bytes = {byte(shown.r), byte(shown.g), byte(shown.b), byte(c.w)};
        }
        std::memcpy(to + 4 * i, bytes.data(), 4);
    }
}

// Premultiplied exposed radiance, half floats.
void encode_full(const ImpostorTile& tile, float exposure, std::byte* to) {
    const glm::vec4 gain(exposure * tile.gain, 1.0F);
    for (std::size_t i = 0; i < tile.texels.size(); ++i) {
        const glm::uint64 packed = glm::packHalf4x16(glm::min(tile.texels[i] * gain, glm::vec4(65000.0F)));
        std::memcpy(to + 8 * i, &packed, 8);
    }
}

} // namespace

bool ImpostorLayer::wanted(const FrameData& frame) const {
    return frame.impostors != nullptr && !frame.capturing;
}

Status ImpostorLayer::create(int width, int height) {
    const bool full = context_.quality == Quality::full;
    if (!sets_) {
        Result<ImageSets> sets = ImageSets::create(context_.device, context_.passes.image_set.get(), 1);
        if (!sets) {
            return sets.error();
        }
        sets_ = std::move(sets).value();
        staging_ = {VK_BUFFER_USAGE_TRANSFER_SRC_BIT, context_.frames_in_flight + 1};
        vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight + 1};
        indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, context_.frames_in_flight + 1};
        craft_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight + 1};
        line_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight + 1};
    }
    if (atlas_ && atlas_->extent().width == static_cast<std::uint32_t>(width) &&
        atlas_->extent().height == static_cast<std::uint32_t>(height)) {
        return Ok{};
    }
    if (atlas_) { // frames in flight may still read the old one
        if (const Status idle = context_.device.wait_idle(); !idle) {
            return idle;
        }
    }
    const VkExtent2D extent{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
    Result<vulkan::Image> image =
        vulkan::Image::create(context_.device, {full ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R8G8B8A8_UNORM, extent,
                                                VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    if (!image) {
        return image.error();
    }
    atlas_ = std::move(image).value();
    fresh_ = true;
    sets_->show(context_.device, 0, *atlas_);

    vulkan::GraphicsPipelineOptions picture{};
    picture.bindings = kPictureBindings;
    picture.attributes = kPictureAttributes;
    picture.layout = context_.passes.scene_layout.get();
    picture.pass = context_.passes.scene.get();
    picture.depth_test = true;
    picture.blend = vulkan::Blend::over;
    vulkan::GraphicsPipelineOptions craft{};
    craft.bindings = kColorBindings;
    craft.attributes = kColorAttributes;
    craft.layout = picture.layout;
    craft.pass = picture.pass;
    craft.depth_test = true;
    craft.depth_write = true;
    vulkan::GraphicsPipelineOptions lines = craft;
    lines.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
    lines.depth_write = false;
    const auto make = [&](std::optional<vulkan::ReloadablePipeline>& pipeline,
                          std::vector<vulkan::ShaderSource> sources, std::vector<std::uint32_t> constants,
                          const vulkan::GraphicsPipelineOptions& options) -> Status {
        Result<vulkan::ReloadablePipeline> made = make_pipeline(
            context_.device, std::move(sources), std::move(constants), options, context_.shader_directory);
        if (!made) {
            return made.error();
        }
        pipeline = std::move(made).value();
        return Ok{};
    };
    const std::uint32_t hdr = full ? 1 : 0;
    Status status = Ok{};
    for (std::uint32_t kind = 0; status && kind < pictures_.size(); ++kind) {
        status = make(pictures_[kind],
                      {vertex_shader(impostor_vert, "passes/impostor.vert"),
                       fragment_shader(impostor_frag, "passes/impostor.frag")},
                      {hdr, kind, std::bit_cast<std::uint32_t>(static_cast<float>(width)),
                       std::bit_cast<std::uint32_t>(static_cast<float>(height))},
                      picture);
    }
    const vulkan::ShaderSource color = color_shader(context_.quality);
    if (status) {
        status = make(craft_, {vertex_shader(colored_vert, "passes/colored.vert"), color}, {hdr}, craft);
    }
    if (status) {
        status = make(lines_, {vertex_shader(colored_vert, "passes/colored.vert"), color}, {hdr}, lines);
    }
    return status;
}

Status ImpostorLayer::upload(const FrameData& frame, VkExtent2D /*extent*/, std::uint32_t /*slot*/, DrawStats& stats) {
    const ImpostorRenderData& data = *frame.impostors;
    Status status = create(data.atlas_width, data.atlas_height);
    const auto copy = [&](DynamicBuffer& buffer, const auto& items) {
        if (status && !items.empty()) {
            status = buffer.replace(context_.device, items);
            ++stats.uploads;
            stats.upload_bytes += items.size_bytes();
        }
    };
    if (status && tiles_revision_ != data.tiles_revision) {
        tiles_revision_ = data.tiles_revision;
        const bool full = context_.quality == Quality::full;
        const std::size_t texel_bytes = full ? 8 : 4;
        std::size_t bytes = 0;
        for (const ImpostorTile& tile : data.tiles) {
            VkBufferImageCopy region{};
            region.bufferOffset = bytes;
            region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
            region.imageOffset = {tile.x, tile.y, 0};
            region.imageExtent = {static_cast<std::uint32_t>(tile.width), static_cast<std::uint32_t>(tile.height), 1};
            copies_.push_back(region);
            bytes += tile.texels.size() * texel_bytes;
        }
        if (bytes > 0) {
            status = staging_.replace(context_.device, bytes, [&](std::span<std::byte> to) {
                std::size_t at = 0;
                for (const ImpostorTile& tile : data.tiles) {
                    (full ? encode_full : encode_lean)(tile, frame.exposure, to.data() + at);
                    at += tile.texels.size() * texel_bytes;
                }
            });
            stats.uploads += static_cast<std::uint32_t>(data.tiles.size());
            stats.upload_bytes += bytes;
        }
    }
    if (status && mesh_revision_ != data.mesh_revision) {
        mesh_revision_ = data.mesh_revision;
        copy(vertices_, data.vertices);
        copy(indices_, data.indices);
    }
    if (status && craft_revision_ != data.craft_revision) {
        craft_revision_ = data.craft_revision;
        copy(craft_vertices_, data.craft);
    }
    if (status && lines_revision_ != data.outlines_revision) {
        lines_revision_ = data.outlines_revision;
        copy(line_vertices_, data.outlines);
    }
    return status;
}

void ImpostorLayer::record_before(VkCommandBuffer commands, const FrameData& /*frame*/, DrawStats& /*stats*/) {
    if (copies_.empty() && !fresh_) {
        return;
    }
    const bool fresh = std::exchange(fresh_, false);
    vulkan::record_barrier(commands, atlas_->get(), VK_IMAGE_ASPECT_COLOR_BIT,
                           {fresh ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                            VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                            VK_ACCESS_SHADER_READ_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT});
    if (fresh) { // what no picture has filled is transparent
        const VkClearColorValue nothing{};
        const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(commands, atlas_->get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &nothing, 1, &whole);
        vulkan::record_barrier(commands, atlas_->get(), VK_IMAGE_ASPECT_COLOR_BIT,
                               {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                                VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT});
    }
    if (!copies_.empty()) {
        vkCmdCopyBufferToImage(commands, staging_.get(), atlas_->get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                               static_cast<std::uint32_t>(copies_.size()), copies_.data());
        copies_.clear();
    }
    vulkan::record_barrier(commands, atlas_->get(), VK_IMAGE_ASPECT_COLOR_BIT,
                           {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                            VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                            VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT});
}

void ImpostorLayer::record_opaque(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const ImpostorRenderData& data = *frame.impostors;
    if (data.craft.empty()) {
        return;
    }
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, craft_->get());
    bind_vertices(commands, 0, craft_vertices_.get());
    vkCmdDraw(commands, static_cast<std::uint32_t>(data.craft.size()), 1, 0, 0);
    ++stats.draws;
    stats.triangles += static_cast<std::uint32_t>(data.craft.size() / 3);
}

void ImpostorLayer::record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const ImpostorRenderData& data = *frame.impostors;
    if (!data.indices.empty()) {
        const VkDescriptorSet set = (*sets_)[0];
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context_.passes.scene_layout.get(), 1, 1,
                                &set, 0, nullptr);
        bind_vertices(commands, 0, vertices_.get());
        vkCmdBindIndexBuffer(commands, indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        std::optional<ImpostorRun::Kind> bound;
        for (const ImpostorRun& run : data.runs) {
            if (bound != run.kind) {
                bound = run.kind;
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pictures_[run.kind]->get());
            }
            vkCmdDrawIndexed(commands, run.index_count, 1, run.first_index, 0, 0);
            ++stats.draws;
            stats.triangles += run.index_count / 3;
        }
    }
    if (!data.outlines.empty()) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, lines_->get());
        bind_vertices(commands, 0, line_vertices_.get());
        vkCmdDraw(commands, static_cast<std::uint32_t>(data.outlines.size()), 1, 0, 0);
        ++stats.draws;
    }
}

std::vector<vulkan::ReloadablePipeline*> ImpostorLayer::pipelines() {
    if (!lines_) {
        return {};
    }
    return {&*pictures_[0], &*pictures_[1], &*pictures_[2], &*craft_, &*lines_};
}

} // namespace alpenglow::sandbox
