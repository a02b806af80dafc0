#include <alpenglow/prt/bake_cubemap_vulkan.hpp>

#include <alpenglow/core/timing.hpp>
#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include <alpenglow_shaders/transfer_cube.frag.hpp>
#include <alpenglow_shaders/transfer_cube.vert.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/vec4.hpp>

namespace alpenglow::prt {
namespace {

constexpr std::size_t faces = 6;
constexpr std::size_t target_side = 2048; // texels, about: how many eyes go into one picture

struct Eye {
    glm::vec4 position;
    std::array<std::int32_t, 4> face;
};

// The mesh on the device, and a picture with a row of faces for each eye of a batch.
class Rasteriser {
public:
    static Result<Rasteriser> create(const vulkan::Device& device, const Mesh& mesh, std::size_t resolution) {
        Rasteriser r(device);
        r.resolution_ = resolution;
        r.batch_ = std::max<std::size_t>(1, target_side / resolution);
        std::vector<glm::vec3> corners;
        corners.reserve(3 * mesh.triangles.size());
        for (const glm::uvec3& t : mesh.triangles) {
            corners.insert(corners.end(), {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
        }
        r.vertices_ = static_cast<std::uint32_t>(corners.size());
        const Bounds box = bounds(mesh);
        const glm::vec3 size = box.high - box.low;
        r.near_m_ = 1e-6F * std::max({size.x, size.y, size.z});
        Result<vulkan::Buffer> buffer = vulkan::Buffer::create(
            device, corners.size() * sizeof(glm::vec3), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, vulkan::Placement::device);
        if (!buffer) {
            return buffer.error();
        }
        r.corners_ = std::move(buffer).value();
        if (const Status copied = vulkan::upload_buffer(device, *r.corners_, std::as_bytes(std::span(corners)));
            !copied) {
            return copied.error();
        }
        const vulkan::RenderPassOptions options{.color = VK_FORMAT_R32_SFLOAT, .depth = VK_FORMAT_D32_SFLOAT};
        Result<vulkan::RenderPass> pass = vulkan::create_render_pass(device, options);
        if (!pass) {
            return pass.error();
        }
        r.pass_ = std::move(pass).value();
        const VkExtent2D extent{static_cast<std::uint32_t>(faces * resolution),
                                static_cast<std::uint32_t>(r.batch_ * resolution)};
        Result<vulkan::RenderTarget> target =
            vulkan::create_render_target(device, options, r.pass_.get(), extent, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
        if (!target) {
            return target.error();
        }
        r.target_ = std::move(target).value();
        const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Eye)};
        Result<vulkan::PipelineLayout> layout = vulkan::create_pipeline_layout(device, {}, {&push, 1});
        if (!layout) {
            return layout.error();
        }
        r.layout_ = std::move(layout).value();
        const std::array<vulkan::ShaderStage, 2> stages{
            {{VK_SHADER_STAGE_VERTEX_BIT, transfer_cube_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, transfer_cube_frag}}};
        const VkVertexInputBindingDescription binding{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX};
        const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
        Result<vulkan::Pipeline> pipeline = vulkan::create_graphics_pipeline(device, {.stages = stages,
                                                                                      .bindings = {&binding, 1},
                                                                                      .attributes = {&attribute, 1},
                                                                                      .layout = r.layout_.get(),
                                                                                      .pass = r.pass_.get(),
                                                                                      .depth_test = true,
                                                                                      .depth_write = true});
        if (!pipeline) {
            return pipeline.error();
        }
        r.pipeline_ = std::move(pipeline).value();
        return r;
    }

    [[nodiscard]] std::size_t batch() const { return batch_; }

    Status draw(std::span<const glm::vec3> eyes_m, std::span<std::uint32_t> triangles) const {
        const auto side = static_cast<std::uint32_t>(resolution_);
        const Status drawn = vulkan::submit_and_wait(device_, [&](VkCommandBuffer commands) {
            vulkan::begin_render_pass(commands, pass_.get(), *target_, {});
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_.get());
            const VkBuffer buffer = corners_->get();
            const VkDeviceSize offset = 0;
            vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
            for (std::uint32_t i = 0; i < eyes_m.size(); ++i) {
                for (std::uint32_t face = 0; face < faces; ++face) {
                    const VkRect2D place{{static_cast<std::int32_t>(face * side), static_cast<std::int32_t>(i * side)},
                                         {side, side}};
                    const VkViewport viewport{static_cast<float>(place.offset.x),
                                              static_cast<float>(place.offset.y),
                                              static_cast<float>(side),
                                              static_cast<float>(side),
                                              0.0F,
                                              1.0F};
                    vkCmdSetViewport(commands, 0, 1, &viewport);
                    vkCmdSetScissor(commands, 0, 1, &place);
                    const Eye eye{glm::vec4(eyes_m[i], near_m_),
                                  {static_cast<std::int32_t>(face / 2), face % 2 == 0 ? 1 : -1, 0, 0}};
                    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof eye, &eye);
                    vkCmdDraw(commands, vertices_, 1, 0, 0);
                }
            }
            vkCmdEndRenderPass(commands);
        });
        if (!drawn) {
            return drawn;
        }
        Result<std::vector<std::byte>> read =
            vulkan::read_image(device_, *target_->color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        if (!read) {
            return read.error();
        }
        const std::size_t row = faces * resolution_;
        for (std::size_t i = 0; i < eyes_m.size(); ++i) {
            for (std::size_t face = 0; face < faces; ++face) {
                for (std::size_t y = 0; y < resolution_; ++y) {
                    const std::size_t from = (i * resolution_ + y) * row + face * resolution_;
                    const std::size_t to = ((i * faces + face) * resolution_ + y) * resolution_;
                    for (std::size_t x = 0; x < resolution_; ++x) {
                        float number = 0.0F;
                        std::memcpy(&number, read->data() + 4 * (from + x), 4);
                        triangles[to + x] = number > 0.0F ? static_cast<std::uint32_t>(number) - 1 : no_triangle;
                    }
                }
            }
        }
        return Ok{};
    }

private:
    explicit Rasteriser(const vulkan::Device& device) : device_(device) {}

    const vulkan::Device& device_;
    std::size_t resolution_ = 0;
    std::size_t batch_ = 0;
    std::uint32_t vertices_ = 0;
    float near_m_ = 0.0F;
    std::optional<vulkan::Buffer> corners_;
    vulkan::RenderPass pass_;
    std::optional<vulkan::RenderTarget> target_;
    vulkan::PipelineLayout layout_;
    vulkan::Pipeline pipeline_;
};

} // namespace

Result<BakePart> bake_part_cubemap(const vulkan::Device& device, const Mesh& mesh, const BakeSettings& settings,
                                   std::size_t resolution, std::size_t first, std::size_t count) {
    if (mesh.triangles.size() >= (std::size_t{1} << 24U)) {
        return Error{std::to_string(mesh.triangles.size()) + " triangles", "cube map bake on a device",
                     "fewer than 2^24"};
    }
    if (const Result<MeshReport> valid = validate(mesh); !valid) {
        return valid.error();
    }
    if (resolution < 4 || resolution > 128) {
        return Error{std::to_string(resolution), "cube map resolution", "4 .. 128"};
    }
    Result<Rasteriser> rasteriser = Rasteriser::create(device, mesh, resolution);
    if (!rasteriser) {
        return rasteriser.error();
    }
    return bake_part_cubemap(
        mesh, settings, resolution, first, count,
        [&](std::span<const glm::vec3> eyes, std::span<std::uint32_t> triangles) {
            return rasteriser->draw(eyes, triangles);
        },
        rasteriser->batch());
}

Result<Bake> bake_cubemap(const vulkan::Device& device, const Mesh& mesh, const BakeSettings& settings,
                          std::size_t resolution) {
    const double start = wall_seconds();
    Result<BakePart> part = bake_part_cubemap(device, mesh, settings, resolution, 0, mesh.positions.size());
    if (!part) {
        return part.error();
    }
    std::vector<BakePart> parts;
    parts.push_back(std::move(part).value());
    Result<Bake> baked = finish(mesh, settings, std::move(parts));
    if (baked) {
        baked->report.wall_s = wall_seconds() - start;
    }
    return baked;
}

} // namespace alpenglow::prt
