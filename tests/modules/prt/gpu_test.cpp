// The vertex shader's path on a device: same table, same result as the CPU's.
#include "gpu_test.hpp"
#include "helpers.hpp"

#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/shader_tables.hpp>
#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include <alpenglow_shaders/transfer_points.frag.hpp>
#include <alpenglow_shaders/transfer_points.vert.hpp>

#include <cstring>

#include <glm/geometric.hpp>

namespace alpenglow::vulkan {
namespace {

using TransferGpu = GpuTest;

TEST_F(TransferGpu, VertexShaderAgreesWithTheCpu) {
    constexpr std::uint32_t side = 16;
    constexpr std::size_t count = std::size_t{side} * side;
    const prt::TransferField field = prt::test::random_field(5, 0, 3, count, 3);
    const Result<prt::TransferTable> table = prt::encode(field, prt::Encoding::f16);
    ASSERT_TRUE(table);
    const std::vector<glm::vec3> light = prt::test::random_light(5, 2);
    std::vector<glm::vec3> cpu(count);
    prt::evaluate(*table, light, cpu);

    const VkDeviceSize light_bytes = 25 * 16;
    Result<Buffer> words =
        Buffer::create(*device, table->blocks.size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Placement::upload);
    Result<Buffer> lights = Buffer::create(*device, light_bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Placement::upload);
    ASSERT_TRUE(words);
    ASSERT_TRUE(lights);
    std::memcpy(words->mapped().data(), table->blocks.data(), table->blocks.size());
    std::vector<glm::vec3> packed(25);
    ASSERT_EQ(prt::shader_light(*table, light, packed), 25U);
    for (std::size_t i = 0; i < 25; ++i) {
        const float rgba[4] = {packed[i].x, packed[i].y, packed[i].z, 0.0F};
        std::memcpy(lights->mapped().data() + 16 * i, rgba, 16);
    }
    const RenderPassOptions options{.color = VK_FORMAT_R32G32B32A32_SFLOAT};
    Result<RenderPass> pass = create_render_pass(*device, options);
    ASSERT_TRUE(pass);
    Result<RenderTarget> target =
        create_render_target(*device, options, pass->get(), {side, side}, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    ASSERT_TRUE(target) << target.error().message();
    const std::array<VkDescriptorSetLayoutBinding, 2> bindings{
        {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr},
         {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr}}};
    Result<DescriptorSetLayout> set_layout = create_descriptor_set_layout(*device, bindings);
    ASSERT_TRUE(set_layout);
    const VkDescriptorSetLayout sets[] = {set_layout->get()};
    Result<PipelineLayout> layout = create_pipeline_layout(*device, sets);
    ASSERT_TRUE(layout);
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2}};
    Result<DescriptorPool> pool = create_descriptor_pool(*device, 1, sizes);
    ASSERT_TRUE(pool);
    Result<VkDescriptorSet> set = allocate_descriptor_set(*device, pool->get(), set_layout->get());
    ASSERT_TRUE(set);
    const VkDescriptorBufferInfo infos[] = {{words->get(), 0, VK_WHOLE_SIZE}, {lights->get(), 0, VK_WHOLE_SIZE}};
    for (std::uint32_t binding = 0; binding < 2; ++binding) {
        VkWriteDescriptorSet write{};
        write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write.dstSet = *set;
        write.dstBinding = binding;
        write.descriptorCount = 1;
        write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        write.pBufferInfo = &infos[binding];
        vkUpdateDescriptorSets(device->get(), 1, &write, 0, nullptr);
    }
    const std::array<ShaderStage, 2> stages{
        {{VK_SHADER_STAGE_VERTEX_BIT, transfer_points_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, transfer_points_frag}}};
    const std::array<std::uint32_t, 1> constants{side};
    Result<Pipeline> pipeline = create_graphics_pipeline(*device, {.stages = stages,
                                                                   .constants = constants,
                                                                   .layout = layout->get(),
                                                                   .pass = pass->get(),
                                                                   .topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST});
    ASSERT_TRUE(pipeline) << pipeline.error().message();
    ASSERT_TRUE(submit_and_wait(*device, [&](VkCommandBuffer commands) {
        begin_render_pass(commands, pass->get(), *target, {});
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline->get());
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout->get(), 0, 1, &*set, 0, nullptr);
        vkCmdDraw(commands, count, 1, 0, 0);
        vkCmdEndRenderPass(commands);
    }));
    Result<std::vector<std::byte>> read = read_image(*device, *target->color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    ASSERT_TRUE(read);
    for (std::size_t p = 0; p < count; ++p) {
        glm::vec3 gpu(0.0F);
        std::memcpy(&gpu.x, read->data() + 16 * p, 12);
        EXPECT_LT(glm::length(gpu - cpu[p]), 1e-4F) << p;
    }
}

} // namespace
} // namespace alpenglow::vulkan
