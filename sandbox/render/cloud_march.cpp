#include "sandbox/render/cloud_march.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include <alpenglow/vulkan/transfer.hpp>

#include "sandbox/render/gpu_data.hpp"
#include "sandbox/render/pipelines.hpp"

#include <alpenglow_shaders/clouds_air.frag.hpp>
#include <alpenglow_shaders/clouds_device.frag.hpp>
#include <alpenglow_shaders/clouds_device.vert.hpp>
#include <alpenglow_shaders/clouds_march.frag.hpp>
#include <alpenglow_shaders/resolve.vert.hpp>

namespace alpenglow::sandbox {
namespace {

// As clouds_picture.glsl.
struct PicturePlace {
    glm::vec4 eye, forward, right, up, voxel_m;
    glm::uvec4 tables;
};
struct PictureHead {
    glm::ivec4 counts;
    glm::ivec2 size;
    glm::vec2 half_angles;
    glm::vec4 forward, right, up;
};
static_assert(sizeof(PicturePlace) == 96 && sizeof(PictureHead) == 80);

constexpr std::uint32_t bindings = 5;
constexpr std::array<VkDescriptorType, bindings> binding_types{
    VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
    VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER};

void record_buffer_barrier(VkCommandBuffer commands, VkBuffer buffer, VkPipelineStageFlags after, VkAccessFlags from,
                           VkPipelineStageFlags before, VkAccessFlags to) {
    VkBufferMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER;
    barrier.srcAccessMask = from;
    barrier.dstAccessMask = to;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.buffer = buffer;
    barrier.size = VK_WHOLE_SIZE;
    vkCmdPipelineBarrier(commands, after, before, 0, 0, nullptr, 1, &barrier, 0, nullptr);
}

} // namespace

Status CloudMarcher::create() {
    if (draw_) {
        return Ok{};
    }
    const vulkan::Device& device = context_.device;
    const std::uint32_t slots = context_.frames_in_flight;
    std::array<VkDescriptorSetLayoutBinding, bindings> described{};
    std::array<VkDescriptorPoolSize, bindings> sizes{};
    for (std::uint32_t i = 0; i < bindings; ++i) {
        described[i] = {i, binding_types[i], 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
        sizes[i] = {binding_types[i], slots};
    }
    Result<vulkan::DescriptorSetLayout> set_layout = vulkan::create_descriptor_set_layout(device, described);
    if (!set_layout) {
        return set_layout.error();
    }
    set_layout_ = std::move(set_layout).value();
    const VkDescriptorSetLayout sets[] = {set_layout_.get()};
    Result<vulkan::PipelineLayout> layout = vulkan::create_pipeline_layout(device, sets);
    Result<vulkan::DescriptorPool> pool = vulkan::create_descriptor_pool(device, slots, sizes);
    const vulkan::SamplerOptions exact{.filter = VK_FILTER_NEAREST};
    Result<vulkan::Sampler> nearest = vulkan::create_sampler(device, exact);
    if (!layout || !pool || !nearest) {
        return !layout ? layout.error() : !pool ? pool.error() : nearest.error();
    }
    layout_ = std::move(layout).value();
    pool_ = std::move(pool).value();
    nearest_ = std::move(nearest).value();
    sets_.clear();
    for (std::uint32_t i = 0; i < slots; ++i) {
        Result<VkDescriptorSet> set = vulkan::allocate_descriptor_set(device, pool_.get(), set_layout_.get());
        if (!set) {
            return set.error();
        }
        sets_.push_back(*set);
    }
    Result<ImageSets> picture = ImageSets::create(device, context_.passes.image_set.get(), 1);
    Result<ImageSets> marched = ImageSets::create(device, context_.passes.image_set.get(), 1, exact);
    march_options_ = {.color = VK_FORMAT_R32G32B32A32_UINT, .color_to = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    air_options_ = {.color = kHdrFormat, .color_to = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    Result<vulkan::RenderPass> march_pass = vulkan::create_render_pass(device, march_options_);
    Result<vulkan::RenderPass> air_pass = vulkan::create_render_pass(device, air_options_);
    if (!picture || !marched || !march_pass || !air_pass) {
        return !picture      ? picture.error()
               : !marched    ? marched.error()
               : !march_pass ? march_pass.error()
                             : air_pass.error();
    }
    show_picture_ = std::move(picture).value();
    show_marched_ = std::move(marched).value();
    march_pass_ = std::move(march_pass).value();
    air_pass_ = std::move(air_pass).value();

    const auto whole = [&](vulkan::ShaderSource fragment, VkRenderPass pass) {
        vulkan::GraphicsPipelineOptions options{};
        options.layout = layout_.get();
        options.pass = pass;
        return make_pipeline(device, {vertex_shader(resolve_vert, "passes/resolve.vert"), std::move(fragment)}, {},
                             options, context_.shader_directory);
    };
    Result<vulkan::ReloadablePipeline> march =
        whole(fragment_shader(clouds_march_frag, "passes/clouds_march.frag"), march_pass_.get());
    Result<vulkan::ReloadablePipeline> air =
        whole(fragment_shader(clouds_air_frag, "passes/clouds_air.frag"), air_pass_.get());
    vulkan::GraphicsPipelineOptions options{};
    options.layout = context_.passes.scene_layout.get();
    options.pass = context_.passes.scene.get();
    options.depth_test = true;
    options.blend = vulkan::Blend::over;
    Result<vulkan::ReloadablePipeline> draw =
        make_pipeline(device,
                      {vertex_shader(clouds_device_vert, "passes/clouds_device.vert"),
                       fragment_shader(clouds_device_frag, "passes/clouds_device.frag")},
                      {}, options, context_.shader_directory);
    if (!march || !air || !draw) {
        return !march ? march.error() : !air ? air.error() : draw.error();
    }
    staging_ = {VK_BUFFER_USAGE_TRANSFER_SRC_BIT, slots};
    picture_words_ = {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, slots};
    landscape_ = {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, slots};
    block_ = {VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, slots};
    march_ = std::move(march).value();
    air_ = std::move(air).value();
    draw_ = std::move(draw).value();
    return Ok{};
}

Status CloudMarcher::fit(VkExtent2D extent) {
    if (marched_ && marched_->extent.width == extent.width && marched_->extent.height == extent.height) {
        return Ok{};
    }
    if (marched_) { // frames in flight may still read it
        if (const Status idle = context_.device.wait_idle(); !idle) {
            return idle;
        }
    }
    Result<vulkan::RenderTarget> marched = vulkan::create_render_target(
        context_.device, march_options_, march_pass_.get(), extent, VK_IMAGE_USAGE_SAMPLED_BIT);
    Result<vulkan::RenderTarget> picture = vulkan::create_render_target(context_.device, air_options_, air_pass_.get(),
                                                                        extent, VK_IMAGE_USAGE_SAMPLED_BIT);
    if (!marched || !picture) {
        return !marched ? marched.error() : picture.error();
    }
    marched_ = std::move(marched).value();
    picture_ = std::move(picture).value();
    show_marched_->show(context_.device, 0, *marched_->color);
    show_picture_->show(context_.device, 0, *picture_->color);
    return Ok{};
}

// Tables that changed are copied to their places; all get new ones where one has another size.
Status CloudMarcher::place_tables(const CloudMarch& march, DrawStats& stats) {
    bool same = tables_.has_value() && placed_.size() == march.tables.size();
    for (std::size_t i = 0; same && i < placed_.size(); ++i) {
        same = placed_[i].count == march.tables[i].words.size();
    }
    if (!same) {
        placed_.clear();
        std::size_t words = 0;
        for (const CloudTable& table : march.tables) {
            placed_.push_back({words, table.words.size(), 0});
            words += table.words.size();
        }
        if (!tables_ || tables_->size_bytes() < 4 * words) {
            if (tables_) { // frames in flight may still read it
                if (const Status idle = context_.device.wait_idle(); !idle) {
                    return idle;
                }
            }
            Result<vulkan::Buffer> made = vulkan::Buffer::create(
                context_.device, 4 * words, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Placement::device);
            if (!made) {
                return made.error();
            }
            tables_ = std::move(made).value();
        }
    }
    copies_.clear();
    std::vector<std::span<const std::uint32_t>> sources;
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < placed_.size(); ++i) {
        const CloudTable& table = march.tables[i];
        const bool changed = placed_[i].revision != table.revision;
        const std::size_t count = changed ? table.words.size() : table.header;
        if (count == 0) {
            continue;
        }
        placed_[i].revision = table.revision;
        sources.push_back(table.words.first(count));
        copies_.push_back({bytes, 4 * placed_[i].first, 4 * count});
        bytes += 4 * count;
        stats.uploads += changed ? 1U : 0U;
    }
    stats.upload_bytes += bytes;
    return staging_.replace(context_.device, bytes, [&](std::span<std::byte> to) {
        for (const std::span<const std::uint32_t> source : sources) {
            std::memcpy(to.data(), source.data(), source.size_bytes());
            to = to.subspan(source.size_bytes());
        }
    });
}

Status CloudMarcher::place_picture(const FrameData& frame) {
    const CloudRenderData& clouds = *frame.clouds;
    const glm::mat4& v = frame.view;
    PictureHead head{};
    head.counts = {static_cast<int>(clouds.march->clouds.size()), static_cast<int>(placed_[0].first), 0, 0};
    head.size = {clouds.width, clouds.height};
    head.half_angles = half_angles_;
    head.forward = -glm::vec4(v[0][2], v[1][2], v[2][2], 0.0F);
    head.right = {v[0][0], v[1][0], v[2][0], 0.0F};
    head.up = {v[0][1], v[1][1], v[2][1], 0.0F};
    std::vector<std::byte> bytes(sizeof head +
                                 std::max<std::size_t>(1, clouds.march->clouds.size()) * sizeof(PicturePlace));
    std::memcpy(bytes.data(), &head, sizeof head);
    for (std::size_t i = 0; i < clouds.march->clouds.size(); ++i) {
        const CloudPlace& c = clouds.march->clouds[i];
        const auto first = [&](std::uint32_t table) { return static_cast<std::uint32_t>(placed_[table].first); };
        const PicturePlace place{glm::vec4(c.eye, 0.0F),     glm::vec4(c.forward, 0.0F),
                                 glm::vec4(c.right, 0.0F),   glm::vec4(c.up, 0.0F),
                                 glm::vec4(c.voxel_m, 0.0F), {first(c.volume), first(c.light), first(c.view), 0}};
        std::memcpy(bytes.data() + sizeof head + i * sizeof place, &place, sizeof place);
    }
    return picture_words_.replace(context_.device, std::span<const std::byte>(bytes));
}

Status CloudMarcher::upload(const FrameData& frame, VkExtent2D extent, DrawStats& stats) {
    if (const Status created = create(); !created) {
        return created;
    }
    const CloudRenderData& clouds = *frame.clouds;
    march_due_ = clouds.revision != revision_;
    const bool exposed = std::abs(frame.exposure - exposure_) <= 0.005F * exposure_; // as CloudLayer
    air_due_ = march_due_ || frame.sky_revision != sky_revision_ || !exposed || extent.width != extent_.width ||
               extent.height != extent_.height;
    if (!air_due_) {
        return Ok{};
    }
    revision_ = clouds.revision;
    sky_revision_ = frame.sky_revision;
    exposure_ = frame.exposure;
    extent_ = extent;
    const glm::vec2 size(clouds.width, clouds.height);
    const glm::vec2 screen(extent.width, extent.height);
    half_angles_ = {clouds.march->tan_half_height * size.x / size.y, clouds.march->tan_half_height};
    image_ = glm::vec4(0.5F * screen / (size * clouds.scale), 0.5F, 0.5F);
    Status status = fit({static_cast<std::uint32_t>(clouds.width), static_cast<std::uint32_t>(clouds.height)});
    if (status && march_due_) {
        status = place_tables(*clouds.march, stats);
        if (status) {
            status = place_picture(frame);
        }
        if (status) {
            status = landscape_.replace(context_.device, clouds.landscape_m);
        }
        stats.upload_bytes += clouds.landscape_m.size_bytes();
        stats.uploads += 2;
    }
    if (status) {
        const gpu::FrameBlock block = make_frame_block(frame, extract_sky(frame), extent.height);
        status = block_.replace(context_.device, std::as_bytes(std::span(&block, 1)));
        stats.upload_bytes += sizeof block;
        ++stats.uploads;
    }
    if (!status) {
        return status;
    }
    current_ = (current_ + 1) % sets_.size();
    const VkDescriptorSet set = sets_[current_];
    vulkan::write_buffer_descriptor(context_.device, set, 0, block_.get(), sizeof(gpu::FrameBlock));
    const std::array<VkDescriptorBufferInfo, 3> storage{{{tables_->get(), 0, VK_WHOLE_SIZE},
                                                         {picture_words_.get(), 0, VK_WHOLE_SIZE},
                                                         {landscape_.get(), 0, VK_WHOLE_SIZE}}};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstBinding = 1;
    write.descriptorCount = static_cast<std::uint32_t>(storage.size());
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = storage.data();
    vkUpdateDescriptorSets(context_.device.get(), 1, &write, 0, nullptr);
    vulkan::write_image_descriptor(context_.device, set, 4, marched_->color->view(), nearest_.get());
    return Ok{};
}

void CloudMarcher::record_before(VkCommandBuffer commands) {
    if (!copies_.empty()) {
        record_buffer_barrier(commands, tables_->get(), VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, 0,
                              VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
        vkCmdCopyBuffer(commands, staging_.get(), tables_->get(), static_cast<std::uint32_t>(copies_.size()),
                        copies_.data());
        record_buffer_barrier(commands, tables_->get(), VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                              VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
        copies_.clear();
    }
    const auto pass = [&](VkRenderPass render_pass, const vulkan::RenderTarget& target, VkPipeline pipeline) {
        vulkan::begin_render_pass(commands, render_pass, target);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 0, 1, &sets_[current_], 0,
                                nullptr);
        vkCmdDraw(commands, 3, 1, 0, 0);
        vkCmdEndRenderPass(commands);
    };
    if (std::exchange(march_due_, false)) {
        pass(march_pass_.get(), *marched_, march_->get());
    }
    if (std::exchange(air_due_, false)) {
        pass(air_pass_.get(), *picture_, air_->get());
    }
}

void CloudMarcher::record_blended(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const VkPipelineLayout layout = context_.passes.scene_layout.get();
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, draw_->get());
    const std::array<VkDescriptorSet, 2> images{(*show_picture_)[0], (*show_marched_)[0]};
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 1, 2, images.data(), 0, nullptr);
    const glm::mat4 projection = reversed_depth(frame.projection);
    ScenePush push;
    push.grid = image_;
    push.tiles = {projection[3][2], projection[2][2]};
    push.levels = half_angles_;
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push,
                       &push);
    vkCmdDraw(commands, 3, 1, 0, 0);
    ++stats.draws;
    ++stats.triangles;
}

std::vector<vulkan::ReloadablePipeline*> CloudMarcher::pipelines() {
    return draw_ ? std::vector<vulkan::ReloadablePipeline*>{&*march_, &*air_, &*draw_}
                 : std::vector<vulkan::ReloadablePipeline*>{};
}

} // namespace alpenglow::sandbox
