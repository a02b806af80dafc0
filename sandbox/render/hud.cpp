#include "sandbox/render/hud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <imgui.h>
#include <imgui_impl_vulkan.h>

#include <alpenglow/vulkan/transfer.hpp>

namespace alpenglow::sandbox {
namespace {

// FNV-1a over words: quick, and good enough to tell pictures apart.
class Hash {
public:
    void add(const void* data, std::size_t size) {
        const auto* bytes = static_cast<const unsigned char*>(data);
        while (size > 0) {
            const std::size_t count = std::min<std::size_t>(size, 8);
            std::uint64_t word = 0;
            std::memcpy(&word, bytes, count);
            value_ = (value_ ^ word) * 0x100000001B3U;
            value_ ^= value_ >> 29U;
            bytes += count;
            size -= count;
        }
    }
    [[nodiscard]] std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 0xCBF29CE484222325U;
};

bool overlap(const HudRectangle& a, const HudRectangle& b) {
    return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

HudRectangle around(const HudRectangle& a, const HudRectangle& b) {
    return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right), std::max(a.bottom, b.bottom)};
}

} // namespace

std::uint64_t hud_hash(const ImDrawData& data) {
    Hash hash;
    hash.add(&data.DisplayPos, sizeof data.DisplayPos);
    hash.add(&data.DisplaySize, sizeof data.DisplaySize);
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        hash.add(list.VtxBuffer.Data, static_cast<std::size_t>(list.VtxBuffer.size_in_bytes()));
        hash.add(list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()));
        for (const ImDrawCmd& command : list.CmdBuffer) {
            hash.add(&command.ClipRect, sizeof command.ClipRect);
            hash.add(&command.ElemCount, sizeof command.ElemCount);
        }
    }
    return hash.value();
}

std::vector<HudRectangle> hud_rectangles(const ImDrawData& data, VkExtent2D extent) {
    std::vector<HudRectangle> rectangles;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        if (list.VtxBuffer.empty()) {
            continue;
        }
        ImVec2 low = list.VtxBuffer[0].pos;
        ImVec2 high = low;
        for (const ImDrawVert& vertex : list.VtxBuffer) {
            low = {std::min(low.x, vertex.pos.x), std::min(low.y, vertex.pos.y)};
            high = {std::max(high.x, vertex.pos.x), std::max(high.y, vertex.pos.y)};
        }
        const auto pixel = [](float at, float origin, float scale, std::uint32_t end) {
            return static_cast<std::int32_t>(std::clamp((at - origin) * scale, 0.0F, static_cast<float>(end)));
        };
        HudRectangle rectangle{
            pixel(std::floor(low.x) - 1.0F, data.DisplayPos.x, data.FramebufferScale.x, extent.width),
            pixel(std::floor(low.y) - 1.0F, data.DisplayPos.y, data.FramebufferScale.y, extent.height),
            pixel(std::ceil(high.x) + 1.0F, data.DisplayPos.x, data.FramebufferScale.x, extent.width),
            pixel(std::ceil(high.y) + 1.0F, data.DisplayPos.y, data.FramebufferScale.y, extent.height)};
        if (rectangle.left >= rectangle.right || rectangle.top >= rectangle.bottom) {
            continue;
        }
        // Overlapping rectangles become one, so that no pixel is laid over the frame twice.
        for (std::size_t k = 0; k < rectangles.size();) {
            if (overlap(rectangles[k], rectangle)) {
                rectangle = around(rectangles[k], rectangle);
                rectangles.erase(rectangles.begin() + static_cast<std::ptrdiff_t>(k));
                k = 0;
            } else {
                ++k;
            }
        }
        rectangles.push_back(rectangle);
    }
    return rectangles;
}

Result<std::unique_ptr<Hud>> Hud::create(const vulkan::Instance& instance, const vulkan::Device& device,
                                         const Passes& passes, VkDescriptorSet set, VkExtent2D extent,
                                         std::uint32_t frames_in_flight) {
    std::unique_ptr<Hud> hud(new Hud(device, passes, set));
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4};
    Result<vulkan::DescriptorPool> descriptors = vulkan::create_descriptor_pool(device, 4, {&size, 1});
    if (!descriptors) {
        return descriptors.error();
    }
    hud->descriptors_ = std::move(descriptors).value();
    Result<vulkan::Sampler> sampler = vulkan::create_sampler(device, {.filter = VK_FILTER_NEAREST});
    if (!sampler) {
        return sampler.error();
    }
    hud->sampler_ = std::move(sampler).value();
    if (const Status resized = hud->resize(extent); !resized) {
        return resized.error();
    }

    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = instance.get();
    info.PhysicalDevice = device.physical();
    info.Device = device.get();
    info.QueueFamily = device.queue_family();
    info.Queue = device.queue();
    info.DescriptorPool = hud->descriptors_.get();
    info.MinImageCount = std::max(frames_in_flight, 2U);
    info.ImageCount = info.MinImageCount;
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    if (!ImGui_ImplVulkan_Init(&info, passes.hud.get())) {
        return Error{"the HUD's drawing cannot be set up", "hud", "an ImGui context"};
    }
    hud->backend_ = true;
    bool fonts = false;
    if (const Status done = vulkan::submit_and_wait(
            device, [&](VkCommandBuffer commands) { fonts = ImGui_ImplVulkan_CreateFontsTexture(commands); });
        !done) {
        return done.error();
    }
    if (!fonts) {
        return Error{"the HUD's fonts cannot be uploaded", "hud", ""};
    }
    ImGui_ImplVulkan_DestroyFontUploadObjects();
    return hud;
}

Hud::~Hud() {
    if (backend_) {
        ImGui_ImplVulkan_Shutdown();
    }
}

Status Hud::resize(VkExtent2D extent) {
    Result<vulkan::RenderTarget> target = vulkan::create_render_target(device_, passes_.hud_options, passes_.hud.get(),
                                                                       extent, VK_IMAGE_USAGE_SAMPLED_BIT);
    if (!target) {
        return target.error();
    }
    target_ = std::move(target).value();
    vulkan::write_image_descriptor(device_, set_, 0, target_.color->view(), sampler_.get());
    drawn_ = false;
    rectangles_.clear();
    return Ok{};
}

bool Hud::record_picture(VkCommandBuffer commands, ImDrawData& data) {
    const std::uint64_t hash = hud_hash(data);
    if (drawn_ && hash == hash_) {
        return false;
    }
    drawn_ = true;
    hash_ = hash;
    rectangles_ = hud_rectangles(data, target_.extent);
    vulkan::begin_render_pass(commands, passes_.hud.get(), target_);
    ImGui_ImplVulkan_RenderDrawData(&data, commands);
    vkCmdEndRenderPass(commands);
    return true;
}

void Hud::record_overlay(VkCommandBuffer commands, VkPipeline pipeline, VkPipelineLayout layout) const {
    if (rectangles_.empty()) {
        return;
    }
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set_, 0, nullptr);
    for (const HudRectangle& r : rectangles_) {
        const auto clip = [](std::int32_t at, std::uint32_t size) {
            return 2.0F * static_cast<float>(at) / static_cast<float>(size) - 1.0F;
        };
        const std::array<float, 4> corners{clip(r.left, target_.extent.width), clip(r.top, target_.extent.height),
                                           clip(r.right, target_.extent.width), clip(r.bottom, target_.extent.height)};
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof corners, corners.data());
        vkCmdDraw(commands, 4, 1, 0, 0);
    }
}

} // namespace alpenglow::sandbox
