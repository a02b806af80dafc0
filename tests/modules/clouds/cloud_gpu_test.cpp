// shaders/alpenglow/cloud.glsl in a fragment shader: the device's picture is the CPU's.
#include "gpu_test.hpp"

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/shader_tables.hpp>
#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include <alpenglow_shaders/cloud_march.frag.hpp>
#include <alpenglow_shaders/resolve.vert.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include <glm/vec4.hpp>

namespace alpenglow::vulkan {
namespace {

using namespace alpenglow::clouds;

constexpr int width = 48;
constexpr int height = 27;

class CloudGpu : public GpuTest {
protected:
    // The picture that the device draws.
    std::vector<glm::vec4> draw(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                                const MarchSettings& settings) {
        const GridTransform& transform = volume.transform();
        const auto local = [&](const glm::vec3& world) {
            return glm::vec4(glm::vec3(transform.local_direction(glm::dvec3(world))), 0.0F);
        };
        const std::array<glm::vec4, 6> pinhole{
            glm::vec4(shader_eye(volume, camera.position_m), 0.5F * height / camera.tan_half_height),
            local(camera.forward),
            local(camera.right),
            local(camera.up),
            glm::vec4(glm::vec3(transform.voxel_m), 0.0F),
            glm::vec4(width, height, 0.0F, 0.0F)};
        const std::vector<std::uint32_t> bricks = pack_volume(volume);
        const std::vector<std::uint32_t> light = pack_light(volume, lighting);
        const std::vector<std::uint32_t> view =
            pack_view(volume, lighting, lighting.contract(transform.index_from_world(camera.position_m)), settings);
        const std::vector<std::uint32_t> detail = pack_detail(texture);
        constexpr std::uint32_t count = 5;
        const std::array<std::span<const std::byte>, count> contents{
            std::as_bytes(std::span(bricks)), std::as_bytes(std::span(light)), std::as_bytes(std::span(pinhole)),
            std::as_bytes(std::span(view)), std::as_bytes(std::span(detail))};
        std::array<VkDescriptorSetLayoutBinding, count> bindings{};
        for (std::uint32_t i = 0; i < count; ++i) {
            bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
        }
        const RenderPassOptions options{.color = VK_FORMAT_R32G32B32A32_SFLOAT};
        Result<RenderPass> pass = create_render_pass(*device, options);
        Result<RenderTarget> target =
            create_render_target(*device, options, pass->get(), {width, height}, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
        Result<DescriptorSetLayout> set_layout = create_descriptor_set_layout(*device, bindings);
        const VkDescriptorSetLayout sets[] = {set_layout->get()};
        Result<PipelineLayout> layout = create_pipeline_layout(*device, sets);
        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, count}};
        Result<DescriptorPool> pool = create_descriptor_pool(*device, 1, sizes);
        Result<VkDescriptorSet> set = allocate_descriptor_set(*device, pool->get(), set_layout->get());
        std::array<std::optional<Buffer>, count> buffers;
        for (std::uint32_t i = 0; i < count; ++i) {
            Result<Buffer> made =
                Buffer::create(*device, contents[i].size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Placement::upload);
            EXPECT_TRUE(made);
            std::memcpy(made->mapped().data(), contents[i].data(), contents[i].size());
            buffers[i] = std::move(made).value();
            const VkDescriptorBufferInfo info{buffers[i]->get(), 0, VK_WHOLE_SIZE};
            VkWriteDescriptorSet write{};
            write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
            write.dstSet = *set;
            write.dstBinding = i;
            write.descriptorCount = 1;
            write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            write.pBufferInfo = &info;
            vkUpdateDescriptorSets(device->get(), 1, &write, 0, nullptr);
        }
        const std::array<ShaderStage, 2> stages{
            {{VK_SHADER_STAGE_VERTEX_BIT, resolve_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, cloud_march_frag}}};
        Result<Pipeline> pipeline =
            create_graphics_pipeline(*device, {.stages = stages, .layout = layout->get(), .pass = pass->get()});
        EXPECT_TRUE(pipeline) << pipeline.error().message();
        EXPECT_TRUE(submit_and_wait(*device, [&](VkCommandBuffer commands) {
            begin_render_pass(commands, pass->get(), *target, {});
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline->get());
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout->get(), 0, 1, &*set, 0, nullptr);
            vkCmdDraw(commands, 3, 1, 0, 0);
            vkCmdEndRenderPass(commands);
        }));
        Result<std::vector<std::byte>> read = read_image(*device, *target->color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        EXPECT_TRUE(read);
        std::vector<glm::vec4> pixels(std::size_t(width) * height);
        std::memcpy(pixels.data(), read->data(), pixels.size() * sizeof(glm::vec4));
        return pixels;
    }
    const DetailTexture texture;
};

TEST_F(CloudGpu, DrawsTheCpusPicture) {
    SparseGrid grid = noise_cloud(81, 40);
    GridTransform transform;
    transform.voxel_m = {2.0, 1.5, 1.0};
    transform.origin_m = {100.0, -50.0, 20.0};
    grid.set_transform(transform);
    const BrickVolume volume(grid);
    CloudLighting lighting;
    lighting.reset(volume, {0.3F, 0.98F, {}}, {});
    lighting.bake_light(0, {glm::vec3(0.2182F, 0.4364F, 0.8729F), glm::vec3(10.0F, 9.0F, 8.0F), 0.0F});
    lighting.bake_sky(SkySh::uniform(glm::vec3(0.3F, 0.5F, 1.0F)));
    const glm::dvec3 centre = transform.world_from_index({20, 20, 20});
    MarchSettings detailed;
    detailed.detail = &texture;
    detailed.detail_strength = 2.0F;
    detailed.detail_cells = 2.0F;
    detailed.detail_offsets = detail_drift(37.0, 100.0);
    detailed.optical_step = 0.25F;
    for (const MarchSettings& settings : {MarchSettings{}, detailed}) {
        for (const glm::dvec3& eye : {centre + glm::dvec3(-120, -40, 50), centre}) { // from outside, from inside
            const Camera camera = look_at(eye, centre + glm::dvec3(1.0, 0.5, 0.0), 0.4F, width, height);
            const Picture cpu = march(volume, lighting, camera, settings);
            const std::vector<glm::vec4> gpu = draw(volume, lighting, camera, settings);
            double difference = 0.0;
            double energy = 0.0;
            for (std::size_t i = 0; i < gpu.size(); ++i) {
                for (int k = 0; k < 3; ++k) {
                    ASSERT_TRUE(std::isfinite(gpu[i][k]));
                    const double d = double(gpu[i][k]) - double(cpu.radiance[i][k]);
                    difference += d * d;
                    energy += double(cpu.radiance[i][k]) * double(cpu.radiance[i][k]);
                }
                ASSERT_NEAR(gpu[i].w, cpu.transmittance[i], 2e-3F) << i;
            }
            ASSERT_GT(energy, 0.0);
            EXPECT_LT(std::sqrt(difference / energy), 1e-3);
        }
    }
}

} // namespace
} // namespace alpenglow::vulkan
