// shaders/alpenglow/sh.glsl against alpenglow::sh.
#include <gpu_test.hpp>

#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/rotate.hpp>
#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include <alpenglow/sh_tables.h>
#include <tables.hpp>

#include <alpenglow_shaders/sh_test.comp.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace alpenglow::vulkan {
namespace {

TEST(ShGlslTest, TablesAreThoseOfTheModule) {
    const auto& poly = sh::detail::basis_tables.poly;
    const auto same = [&](double constant, int l, int m, int k) {
        EXPECT_NEAR(constant, poly[l][m][k], 1e-15 * std::max(1.0, std::abs(constant))) << l << m << k;
        EXPECT_EQ(static_cast<float>(constant), static_cast<float>(poly[l][m][k])) << l << m << k;
    };
    same(ALPENGLOW_SH_P_0_0_0, 0, 0, 0);
    same(ALPENGLOW_SH_P_1_0_0, 1, 0, 0);
    same(ALPENGLOW_SH_P_1_1_0, 1, 1, 0);
    same(ALPENGLOW_SH_P_2_0_0, 2, 0, 0);
    same(ALPENGLOW_SH_P_2_0_1, 2, 0, 1);
    same(ALPENGLOW_SH_P_2_1_0, 2, 1, 0);
    same(ALPENGLOW_SH_P_2_2_0, 2, 2, 0);
    same(ALPENGLOW_SH_P_3_0_0, 3, 0, 0);
    same(ALPENGLOW_SH_P_3_0_1, 3, 0, 1);
    same(ALPENGLOW_SH_P_3_1_0, 3, 1, 0);
    same(ALPENGLOW_SH_P_3_1_1, 3, 1, 1);
    same(ALPENGLOW_SH_P_3_2_0, 3, 2, 0);
    same(ALPENGLOW_SH_P_3_3_0, 3, 3, 0);
    same(ALPENGLOW_SH_P_4_0_0, 4, 0, 0);
    same(ALPENGLOW_SH_P_4_0_1, 4, 0, 1);
    same(ALPENGLOW_SH_P_4_0_2, 4, 0, 2);
    same(ALPENGLOW_SH_P_4_1_0, 4, 1, 0);
    same(ALPENGLOW_SH_P_4_1_1, 4, 1, 1);
    same(ALPENGLOW_SH_P_4_2_0, 4, 2, 0);
    same(ALPENGLOW_SH_P_4_2_1, 4, 2, 1);
    same(ALPENGLOW_SH_P_4_3_0, 4, 3, 0);
    same(ALPENGLOW_SH_P_4_4_0, 4, 4, 0);
    const std::array<double, 5> factors{ALPENGLOW_SH_A_0, ALPENGLOW_SH_A_1, ALPENGLOW_SH_A_2, ALPENGLOW_SH_A_3,
                                        ALPENGLOW_SH_A_4};
    for (int l = 0; l < 5; ++l) {
        EXPECT_NEAR(factors[static_cast<std::size_t>(l)], sh::cosine_factor(l), 1e-15);
    }
}

struct Item {
    glm::vec4 direction{0.0F};
    std::array<float, 76> lines{};
    std::array<float, 28> packed_a{}, packed_b{};
};
struct Answer {
    glm::vec4 radiance, irradiance, turned;
    std::array<float, 28> basis;
};

constexpr std::size_t item_count = 1000;

std::vector<Item> make_items(int order) {
    std::mt19937 engine(static_cast<unsigned>(order));
    std::normal_distribution<float> normal;
    std::vector<Item> items(item_count);
    const int n = sh::coefficient_count(order);
    for (std::size_t k = 0; k < items.size(); ++k) {
        glm::vec3 d = glm::normalize(glm::vec3(normal(engine), normal(engine), normal(engine)));
        if (k < 6) { // the axes
            d = glm::vec3(0.0F);
            d[static_cast<int>(k / 2)] = k % 2 == 0 ? 1.0F : -1.0F;
        }
        items[k].direction = glm::vec4(d, 3.0F * normal(engine));
        std::generate_n(items[k].lines.begin(), 3 * n, [&] { return normal(engine); });
        std::generate_n(items[k].packed_a.begin(), n, [&] { return normal(engine); });
        std::generate_n(items[k].packed_b.begin(), n, [&] { return normal(engine); });
    }
    return items;
}

class ShGlslGpuTest : public GpuTest, public ::testing::WithParamInterface<int> {
protected:
    // Runs the compute shader; an empty answer is a failure that was reported.
    std::vector<Answer> run(int order, const std::vector<Item>& items) {
        std::vector<Answer> answers;
        const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
        const Result<Buffer> in = Buffer::create(*device, items.size() * sizeof(Item), usage, Placement::upload);
        const Result<Buffer> out = Buffer::create(*device, items.size() * sizeof(Answer), usage, Placement::readback);
        const std::array<VkDescriptorSetLayoutBinding, 2> bindings{
            {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
             {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}}};
        const auto set_layout = create_descriptor_set_layout(*device, bindings);
        const std::array<VkDescriptorPoolSize, 1> sizes{{{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2}}};
        const auto pool = create_descriptor_pool(*device, 1, sizes);
        if (!in || !out || !set_layout || !pool) {
            ADD_FAILURE() << "no buffers or layouts";
            return answers;
        }
        const std::array<VkDescriptorSetLayout, 1> set_layouts{set_layout->get()};
        const auto layout = create_pipeline_layout(*device, set_layouts);
        const auto set = allocate_descriptor_set(*device, pool->get(), set_layout->get());
        const Result<Pipeline> pipeline = create_pipeline(layout->get(), order);
        if (!layout || !set || !pipeline) {
            ADD_FAILURE() << "no pipeline";
            return answers;
        }
        std::memcpy(in->mapped().data(), items.data(), items.size() * sizeof(Item));
        const std::array<VkDescriptorBufferInfo, 2> infos{
            {{in->get(), 0, VK_WHOLE_SIZE}, {out->get(), 0, VK_WHOLE_SIZE}}};
        std::array<VkWriteDescriptorSet, 2> writes{};
        for (std::uint32_t i = 0; i < 2; ++i) {
            writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
            writes[i].dstSet = *set;
            writes[i].dstBinding = i;
            writes[i].descriptorCount = 1;
            writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            writes[i].pBufferInfo = &infos[i];
        }
        vkUpdateDescriptorSets(device->get(), 2, writes.data(), 0, nullptr);
        const VkDescriptorSet bound = *set;
        const Status done = submit_and_wait(*device, [&](VkCommandBuffer commands) {
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->get());
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout->get(), 0, 1, &bound, 0, nullptr);
            vkCmdDispatch(commands, static_cast<std::uint32_t>((items.size() + 63) / 64), 1, 1);
            VkMemoryBarrier barrier{};
            barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
            barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
            barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
            vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                                 &barrier, 0, nullptr, 0, nullptr);
        });
        if (!done) {
            ADD_FAILURE() << done.error().message();
            return answers;
        }
        answers.resize(items.size());
        std::memcpy(answers.data(), out->mapped().data(), items.size() * sizeof(Answer));
        return answers;
    }

    Result<Pipeline> create_pipeline(VkPipelineLayout layout, int order) {
        VkShaderModuleCreateInfo module_info{};
        module_info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
        module_info.codeSize = sizeof(sh_test_comp);
        module_info.pCode = sh_test_comp;
        VkShaderModule module = VK_NULL_HANDLE;
        if (vkCreateShaderModule(device->get(), &module_info, nullptr, &module) != VK_SUCCESS) {
            return Error{.what = "no shader module", .where = "", .expected = ""};
        }
        const ShaderModule owner(device->get(), module);
        const VkSpecializationMapEntry entry{0, 0, sizeof(int)};
        const VkSpecializationInfo specialization{1, &entry, sizeof(int), &order};
        VkComputePipelineCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
        info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
        info.stage.module = module;
        info.stage.pName = "main";
        info.stage.pSpecializationInfo = &specialization;
        info.layout = layout;
        VkPipeline pipeline = VK_NULL_HANDLE;
        if (vkCreateComputePipelines(device->get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline) != VK_SUCCESS) {
            return Error{.what = "no compute pipeline", .where = "", .expected = ""};
        }
        return Pipeline(device->get(), pipeline);
    }
};

TEST_P(ShGlslGpuTest, AgreesWithTheModule) {
    const int order = GetParam();
    const auto n = static_cast<std::size_t>(sh::coefficient_count(order));
    const std::vector<Item> items = make_items(order);
    const std::vector<Answer> answers = run(order, items);
    ASSERT_EQ(answers.size(), items.size());
    for (std::size_t k = 0; k < items.size(); ++k) {
        const glm::dvec3 d(items[k].direction);
        std::vector<glm::dvec3> light(n);
        double size = 0.0;
        double dot = 0.0;
        double dot_size = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            light[i] = {items[k].lines[3 * i], items[k].lines[3 * i + 1], items[k].lines[3 * i + 2]};
            size += glm::dot(light[i], light[i]);
            const double product =
                static_cast<double>(items[k].packed_a[i]) * static_cast<double>(items[k].packed_b[i]);
            dot += product;
            dot_size += std::abs(product);
        }
        size = std::sqrt(size);
        std::vector<double> basis(n);
        sh::evaluate_basis(order, d, basis);
        for (std::size_t i = 0; i < n; ++i) {
            ASSERT_NEAR(answers[k].basis[i], basis[i], 1.5e-6) << "coefficient " << i;
        }
        const auto near = [&](const glm::vec4& gpu, const glm::dvec3& cpu, double tolerance, const char* what) {
            EXPECT_LE(glm::distance(glm::dvec3(gpu), cpu), tolerance * size) << what << ", item " << k;
        };
        near(answers[k].radiance, sh::evaluate(order, light, d), 1e-6, "radiance");
        std::vector<glm::dvec3> e(n);
        sh::irradiance(order, light, e);
        near(answers[k].irradiance, glm::max(sh::evaluate(order, e, d), glm::dvec3(0.0)), 1e-6, "irradiance");
        // GPUs promise sin and cos to 2^-11 only.
        std::vector<glm::dvec3> turned(n);
        sh::rotate_z(order, static_cast<double>(items[k].direction.w), light, turned);
        near(answers[k].turned, sh::evaluate(order, turned, d), 2e-3, "turned");
        EXPECT_NEAR(answers[k].radiance.w, dot, 1e-6 * dot_size);
    }
}
INSTANTIATE_TEST_SUITE_P(Orders, ShGlslGpuTest, ::testing::Values(2, 3, 4, 5));

} // namespace
} // namespace alpenglow::vulkan
