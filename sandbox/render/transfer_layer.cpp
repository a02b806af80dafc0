#include "sandbox/render/transfer_layer.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <utility>

#include <glm/vec4.hpp>

#include "sandbox/render/pipelines.hpp"
#include "sandbox/render/upload.hpp"
#include "sandbox/world/transfer_render_data.hpp"

#include <alpenglow_shaders/transfer_colored.vert.hpp>
#include <alpenglow_shaders/transfer_lit.vert.hpp>
#include <alpenglow_shaders/transfer_smoke.frag.hpp>
#include <alpenglow_shaders/transfer_smoke.vert.hpp>

namespace alpenglow::sandbox {
namespace {

namespace shader {
using glm::uvec4;
using glm::vec4;
#include "shaders/passes/transfer_block.h"
} // namespace shader

constexpr std::array<VkVertexInputBindingDescription, 2> kBodyBindings{
    {{0, sizeof(BodyVertex), VK_VERTEX_INPUT_RATE_VERTEX}, {1, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 4> kBodyAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, position_m)},
     {3, 1, VK_FORMAT_R32G32B32_SFLOAT, 0},
     {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, normal)},
     {2, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, albedo)}}};
constexpr std::array<VkVertexInputBindingDescription, 1> kSmokeBindings{
    {{0, sizeof(SmokeVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 2> kSmokeAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(SmokeVertex, position_m)},
     {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(SmokeVertex, radiance)}}};

// The shader's push constants.
struct Place {
    glm::vec4 turn;
    glm::vec4 position;
};
static_assert(sizeof(Place) <= sizeof(ScenePush));

void write_storage(const vulkan::Device& device, VkDescriptorSet set, std::uint32_t binding, VkBuffer buffer) {
    const VkDescriptorBufferInfo info{buffer, 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = &info;
    vkUpdateDescriptorSets(device.get(), 1, &write, 0, nullptr);
}

shader::TransferBlock block_of(const TransferBody& body, std::uint32_t glossy_words) {
    shader::TransferBlock block{};
    const auto table = [](const ShadedTable& from, glm::uvec4& counts, glm::vec4* light) {
        if (from.blocks.empty()) {
            return;
        }
        const std::size_t lit = std::min<std::size_t>(from.light.size(), 36);
        counts = {from.rows, from.channels, from.coefficients, static_cast<std::uint32_t>(lit)};
        for (std::size_t i = 0; i < lit; ++i) {
            light[i] = glm::vec4(from.light[i], 0.0F);
        }
    };
    table(body.diffuse, block.diffuse, block.diffuse_light);
    table(body.glossy, block.glossy, block.glossy_light);
    block.words = {glossy_words, body.glossy_vertices, 0U, 0U};
    block.specular = glm::vec4(body.specular, 0.0F);
    for (std::size_t l = 0; l < body.kernel.size(); ++l) {
        block.kernel[l / 4][static_cast<glm::length_t>(l % 4)] = body.kernel[l];
    }
    return block;
}

} // namespace

// The pipelines, once.
Status TransferLayer::create() {
    if (colored_) {
        return Ok{};
    }
    const std::array<VkDescriptorSetLayoutBinding, 2> bindings{
        {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr},
         {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr}}};
    Result<vulkan::DescriptorSetLayout> set = vulkan::create_descriptor_set_layout(context_.device, bindings);
    if (!set) {
        return set.error();
    }
    set_layout_ = std::move(set).value();
    // The same push constants as the scene's layout, so that the frame's set stays bound.
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(ScenePush)};
    const std::array<VkDescriptorSetLayout, 2> sets{context_.passes.frame_set.get(), set_layout_.get()};
    Result<vulkan::PipelineLayout> layout = vulkan::create_pipeline_layout(context_.device, sets, {&push, 1});
    if (!layout) {
        return layout.error();
    }
    layout_ = std::move(layout).value();

    const bool full = context_.quality == Quality::full;
    const std::vector<std::uint32_t> hdr{full ? 1U : 0U};
    const vulkan::ShaderSource color = color_shader(context_.quality);
    vulkan::GraphicsPipelineOptions body{};
    body.bindings = kBodyBindings;
    body.attributes = std::span(kBodyAttributes).first(2);
    body.layout = layout_.get();
    body.pass = context_.passes.scene.get();
    body.cull = VK_CULL_MODE_BACK_BIT;
    body.depth_test = true;
    body.depth_write = true;
    vulkan::GraphicsPipelineOptions lit = body;
    lit.attributes = kBodyAttributes;
    vulkan::GraphicsPipelineOptions smoke = body;
    smoke.bindings = kSmokeBindings;
    smoke.attributes = kSmokeAttributes;
    smoke.cull = VK_CULL_MODE_NONE;
    smoke.depth_write = false;
    smoke.blend = vulkan::Blend::over;
    Result<vulkan::ReloadablePipeline> colored_made =
        make_pipeline(context_.device, {vertex_shader(transfer_colored_vert, "passes/transfer_colored.vert"), color},
                      hdr, body, context_.shader_directory);
    Result<vulkan::ReloadablePipeline> lit_made =
        make_pipeline(context_.device, {vertex_shader(transfer_lit_vert, "passes/transfer_lit.vert"), color}, hdr, lit,
                      context_.shader_directory);
    Result<vulkan::ReloadablePipeline> smoke_made =
        make_pipeline(context_.device,
                      {vertex_shader(transfer_smoke_vert, "passes/transfer_smoke.vert"),
                       fragment_shader(transfer_smoke_frag, "passes/transfer_smoke.frag")},
                      hdr, smoke, context_.shader_directory);
    for (const Result<vulkan::ReloadablePipeline>* made : {&colored_made, &lit_made, &smoke_made}) {
        if (!*made) {
            return made->error();
        }
    }
    colored_ = std::move(colored_made).value();
    lit_ = std::move(lit_made).value();
    smoke_ = std::move(smoke_made).value();
    smoke_vertices_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight};
    smoke_indices_ = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, context_.frames_in_flight};
    return Ok{};
}

Status TransferLayer::create_body(Body& body) {
    body.vertices = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight};
    body.indices = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, context_.frames_in_flight};
    body.light = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight};
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2 * context_.frames_in_flight};
    Result<vulkan::DescriptorPool> pool =
        vulkan::create_descriptor_pool(context_.device, context_.frames_in_flight, {&size, 1});
    if (!pool) {
        return pool.error();
    }
    body.pool = std::move(pool).value();
    body.slots.resize(context_.frames_in_flight);
    for (Slot& slot : body.slots) {
        Result<VkDescriptorSet> set =
            vulkan::allocate_descriptor_set(context_.device, body.pool.get(), set_layout_.get());
        Result<vulkan::Buffer> block =
            vulkan::Buffer::create(context_.device, sizeof(shader::TransferBlock), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                   vulkan::Placement::upload);
        if (!set || !block) {
            return !set ? set.error() : block.error();
        }
        slot.set = *set;
        slot.block = std::move(block).value();
        write_storage(context_.device, slot.set, 1, slot.block->get());
    }
    return Ok{};
}

// Blocks go to a buffer of their own, which frames in flight share; each frame's block of counts and light is its own.
Status TransferLayer::upload_tables(const TransferBody& from, Body& body, std::uint32_t slot_index, DrawStats& stats) {
    if (body.table_revision != from.table_revision || body.words == nullptr) {
        body.table_revision = from.table_revision;
        const std::size_t diffuse_bytes = (from.diffuse.blocks.size() + 3) / 4 * 4;
        std::vector<std::byte> bytes(std::max<std::size_t>(diffuse_bytes + from.glossy.blocks.size(), 16));
        const auto copy = [&](std::span<const std::byte> blocks, std::size_t at) {
            if (!blocks.empty()) {
                std::memcpy(bytes.data() + at, blocks.data(), blocks.size());
            }
        };
        copy(from.diffuse.blocks, 0);
        copy(from.glossy.blocks, diffuse_bytes);
        Result<vulkan::Buffer> words = vulkan::Buffer::create(
            context_.device, bytes.size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Placement::device);
        if (!words) {
            return words.error();
        }
        body.words = std::make_shared<vulkan::Buffer>(std::move(words).value());
        body.glossy_words = static_cast<std::uint32_t>(diffuse_bytes / 4);
        if (const Status copied = vulkan::upload_buffer(context_.device, *body.words, bytes); !copied) {
            return copied;
        }
        ++stats.uploads;
        stats.upload_bytes += bytes.size();
    }
    Slot& slot = body.slots[slot_index];
    const bool new_words = slot.words != body.words;
    if (new_words) {
        slot.words = body.words;
        write_storage(context_.device, slot.set, 0, slot.words->get());
    }
    if (new_words || slot.shade_revision != from.shade_revision) {
        slot.shade_revision = from.shade_revision;
        const shader::TransferBlock block = block_of(from, body.glossy_words);
        std::memcpy(slot.block->mapped().data(), &block, sizeof block);
        ++stats.uploads;
        stats.upload_bytes += sizeof block;
    }
    return Ok{};
}

Status TransferLayer::upload(const FrameData& frame, VkExtent2D /*extent*/, std::uint32_t slot, DrawStats& stats) {
    const TransferRenderData& data = *frame.transfer;
    slot_ = slot;
    Status status = create();
    while (status && bodies_.size() < data.bodies.size()) {
        status = create_body(bodies_.emplace_back());
    }
    const auto copy = [&](DynamicBuffer& buffer, const auto& items) {
        if (status) {
            status = buffer.replace(context_.device, items);
            ++stats.uploads;
            stats.upload_bytes += items.size_bytes();
        }
    };
    for (std::size_t i = 0; status && i < data.bodies.size(); ++i) {
        const TransferBody& from = data.bodies[i];
        Body& body = bodies_[i];
        if (body.mesh_revision != from.mesh_revision) {
            body.mesh_revision = from.mesh_revision;
            copy(body.vertices, from.vertices);
            copy(body.indices, from.indices);
        }
        if (body.light_revision != from.light_revision) {
            body.light_revision = from.light_revision;
            copy(body.light, from.light);
        }
        if (status && data.by_shader) {
            status = upload_tables(from, body, slot, stats);
        }
    }
    if (status && smoke_revision_ != data.smoke_revision) {
        smoke_revision_ = data.smoke_revision;
        copy(smoke_vertices_, data.smoke_vertices);
        copy(smoke_indices_, data.smoke_indices);
    }
    return status;
}

void TransferLayer::record_opaque(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const TransferRenderData& data = *frame.transfer;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, (data.by_shader ? lit_ : colored_)->get());
    for (std::size_t i = 0; i < data.bodies.size(); ++i) {
        const TransferBody& from = data.bodies[i];
        const Body& body = bodies_[i];
        if (from.indices.empty() || from.light.empty()) {
            continue;
        }
        if (data.by_shader) {
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 1, 1,
                                    &body.slots[slot_].set, 0, nullptr);
        }
        const glm::quat& turn = from.world_from_body;
        const Place place{{turn.x, turn.y, turn.z, turn.w}, glm::vec4(from.position_m, 0.0F)};
        vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                           sizeof place, &place);
        bind_vertices(commands, 0, body.vertices.get());
        bind_vertices(commands, 1, body.light.get());
        vkCmdBindIndexBuffer(commands, body.indices.get(), 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands, static_cast<std::uint32_t>(from.indices.size()), 1, 0, 0, 0);
        ++stats.draws;
        stats.triangles += static_cast<std::uint32_t>(from.indices.size() / 3);
    }
}

void TransferLayer::record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const TransferRenderData& data = *frame.transfer;
    if (data.smoke_indices.empty()) {
        return;
    }
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, smoke_->get());
    bind_vertices(commands, 0, smoke_vertices_.get());
    vkCmdBindIndexBuffer(commands, smoke_indices_.get(), 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexed(commands, static_cast<std::uint32_t>(data.smoke_indices.size()), 1, 0, 0, 0);
    ++stats.draws;
    stats.triangles += static_cast<std::uint32_t>(data.smoke_indices.size() / 3);
}

std::vector<vulkan::ReloadablePipeline*> TransferLayer::pipelines() {
    return colored_ ? std::vector<vulkan::ReloadablePipeline*>{&*colored_, &*lit_, &*smoke_}
                    : std::vector<vulkan::ReloadablePipeline*>{};
}

} // namespace alpenglow::sandbox
