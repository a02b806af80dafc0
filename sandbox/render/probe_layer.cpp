#include "sandbox/render/probe_layer.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "sandbox/render/pipelines.hpp"
#include "sandbox/render/upload.hpp"
#include "sandbox/world/probe_render_data.hpp"

#include <alpenglow_shaders/colored.vert.hpp>
#include <alpenglow_shaders/lit_sphere.vert.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr std::array<VkVertexInputBindingDescription, 1> kMeshBindings{
    {{0, sizeof(ColorVertex), VK_VERTEX_INPUT_RATE_VERTEX}}};
constexpr std::array<VkVertexInputAttributeDescription, 2> kMeshAttributes{
    {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ColorVertex, position_m)},
     {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(ColorVertex, light)}}};
constexpr std::array<VkVertexInputBindingDescription, 2> kSphereBindings{
    {{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX}, {1, sizeof(LitSphere), VK_VERTEX_INPUT_RATE_INSTANCE}}};
static_assert(sizeof(LitSphere) == 32 * sizeof(float)); // centre and radius, 27 coefficients, padding
constexpr VkVertexInputAttributeDescription sphere_line(std::uint32_t i) {
    return {1 + i, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 16 * i};
}
constexpr std::array<VkVertexInputAttributeDescription, 9> kSphereAttributes{{{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                                              sphere_line(0),
                                                                              sphere_line(1),
                                                                              sphere_line(2),
                                                                              sphere_line(3),
                                                                              sphere_line(4),
                                                                              sphere_line(5),
                                                                              sphere_line(6),
                                                                              sphere_line(7)}};

// The unit sphere by rings and meridians, counter-clockwise from outside.
void make_sphere(std::vector<glm::vec3>& vertices, std::vector<std::uint32_t>& indices) {
    constexpr std::uint32_t rings = 20;
    constexpr std::uint32_t meridians = 40;
    constexpr float pi = std::numbers::pi_v<float>;
    for (std::uint32_t r = 0; r <= rings; ++r) {
        const float polar = pi * static_cast<float>(r) / static_cast<float>(rings);
        for (std::uint32_t m = 0; m <= meridians; ++m) {
            const float azimuth = 2.0F * pi * static_cast<float>(m) / static_cast<float>(meridians);
            vertices.emplace_back(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                  std::cos(polar));
        }
    }
    for (std::uint32_t r = 0; r < rings; ++r) {
        for (std::uint32_t m = 0; m < meridians; ++m) {
            const std::uint32_t v = r * (meridians + 1) + m;
            const std::uint32_t below = v + meridians + 1;
            indices.insert(indices.end(), {v, below, v + 1, v + 1, below, below + 1});
        }
    }
}

} // namespace

// The pipelines and the sphere, once.
Status ProbeLayer::create() {
    if (sphere_vertices_) {
        return Ok{};
    }
    const bool full = context_.quality == Quality::full;
    vulkan::GraphicsPipelineOptions mesh{};
    mesh.bindings = kMeshBindings;
    mesh.attributes = kMeshAttributes;
    mesh.layout = context_.passes.scene_layout.get();
    mesh.pass = context_.passes.scene.get();
    mesh.cull = VK_CULL_MODE_BACK_BIT;
    mesh.depth_test = true;
    mesh.depth_write = true;
    vulkan::GraphicsPipelineOptions spheres = mesh;
    spheres.bindings = kSphereBindings;
    spheres.attributes = kSphereAttributes;
    const vulkan::ShaderSource color = color_shader(context_.quality);
    const std::vector<std::uint32_t> hdr{full ? 1U : 0U};
    Result<vulkan::ReloadablePipeline> colored =
        make_pipeline(context_.device, {vertex_shader(colored_vert, "passes/colored.vert"), color}, hdr, mesh,
                      context_.shader_directory);
    Result<vulkan::ReloadablePipeline> lit =
        make_pipeline(context_.device, {vertex_shader(lit_sphere_vert, "passes/lit_sphere.vert"), color}, hdr, spheres,
                      context_.shader_directory);
    if (!colored || !lit) {
        return !colored ? colored.error() : lit.error();
    }
    colored_ = std::move(colored).value();
    spheres_ = std::move(lit).value();
    for (Mesh* own : {&yard_, &display_}) {
        own->vertices = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight};
        own->indices = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, context_.frames_in_flight};
    }
    sphere_instances_ = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, context_.frames_in_flight};
    std::vector<glm::vec3> vertices;
    std::vector<std::uint32_t> indices;
    make_sphere(vertices, indices);
    sphere_index_count_ = static_cast<std::uint32_t>(indices.size());
    if (const Status uploaded =
            upload_once(context_.device, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, sphere_indices_);
        !uploaded) {
        return uploaded;
    }
    return upload_once(context_.device, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, sphere_vertices_);
}

Status ProbeLayer::upload(const FrameData& frame, VkExtent2D /*extent*/, std::uint32_t /*slot*/, DrawStats& stats) {
    const ProbeRenderData& probes = *frame.probes;
    Status status = create();
    const auto copy = [&](DynamicBuffer& buffer, const auto& items) {
        if (status) {
            status = buffer.replace(context_.device, items);
            ++stats.uploads;
            stats.upload_bytes += items.size_bytes();
        }
    };
    const auto copy_mesh = [&](Mesh& own, const ColorMesh& mesh) {
        if (own.revision != mesh.revision) {
            own.revision = mesh.revision;
            copy(own.vertices, mesh.vertices);
            copy(own.indices, mesh.indices);
        }
    };
    copy_mesh(yard_, probes.yard);
    if (frame.capturing) {
        return status;
    }
    copy_mesh(display_, probes.display);
    if (status && spheres_revision_ != probes.spheres_revision) {
        spheres_revision_ = probes.spheres_revision;
        copy(sphere_instances_, probes.spheres);
    }
    return status;
}

void ProbeLayer::record_opaque(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats) {
    const ProbeRenderData& probes = *frame.probes;
    const auto draw = [&](VkPipeline pipeline, VkBuffer vertices, VkBuffer indices, std::size_t count,
                          std::size_t instances) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
        bind_vertices(commands, 0, vertices);
        vkCmdBindIndexBuffer(commands, indices, 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands, static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(instances), 0, 0, 0);
        ++stats.draws;
        stats.triangles += static_cast<std::uint32_t>(count / 3 * instances);
    };
    const auto draw_mesh = [&](const Mesh& own, const ColorMesh& mesh) {
        if (!mesh.indices.empty()) {
            draw(colored_->get(), own.vertices.get(), own.indices.get(), mesh.indices.size(), 1);
        }
    };
    draw_mesh(yard_, probes.yard);
    if (frame.capturing) {
        return;
    }
    draw_mesh(display_, probes.display);
    if (!probes.spheres.empty()) {
        bind_vertices(commands, 1, sphere_instances_.get());
        draw(spheres_->get(), sphere_vertices_->get(), sphere_indices_->get(), sphere_index_count_,
             probes.spheres.size());
    }
}

std::vector<vulkan::ReloadablePipeline*> ProbeLayer::pipelines() {
    return colored_ ? std::vector<vulkan::ReloadablePipeline*>{&*colored_, &*spheres_}
                    : std::vector<vulkan::ReloadablePipeline*>{};
}

} // namespace alpenglow::sandbox
