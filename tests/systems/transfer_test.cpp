#include <registries.hpp>

#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/systems/transfer.hpp>

#include <gtest/gtest.h>

#include <random>

#include <glm/geometric.hpp>
#include <glm/gtx/component_wise.hpp>

namespace alpenglow {
namespace {

std::shared_ptr<const prt::TransferTable> random_table(int out_order, std::size_t count, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<float> value(0.0F, 0.05F);
    prt::TransferField field;
    field.order = 5;
    field.out_order = out_order;
    field.count = count;
    field.values.resize(count * field.width());
    for (float& x : field.values) {
        x = value(generator);
    }
    for (std::size_t p = 0; p < count; ++p) {
        field.point(p)[0] = 0.28F;
    }
    return std::make_shared<prt::TransferTable>(*prt::encode(field, prt::Encoding::f32));
}

// Light from around `direction` (any length above 0), order 5.
ObjectLight lamp(const glm::vec3& direction) {
    ObjectLight light;
    light.bands = 5;
    std::array<float, 25> y{};
    sh::evaluate_basis(5, glm::normalize(direction), y);
    for (int l = 0; l < 5; ++l) {
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            const float fall = 3.0F / static_cast<float>((1 + l) * (1 + l));
            light.coefficients.emplace_back(y[static_cast<std::size_t>(i)] * fall * glm::vec3(1.0F, 0.9F, 0.7F));
        }
    }
    light.revision = 1;
    return light;
}

template <class R>
class TransferSystem : public ::testing::Test {
protected:
    R registry;
    Frame frame;

    auto object(const std::shared_ptr<const prt::TransferTable>& table) {
        const auto entity = registry.create();
        TransferMesh mesh;
        mesh.table = table;
        registry.template emplace<TransferMesh>(entity, mesh);
        registry.template emplace<ObjectLight>(entity, lamp({0.0F, 0.0F, 1.0F}));
        return entity;
    }
};
TYPED_TEST_SUITE(TransferSystem, test::TestRegistries, test::RegistryNames);

TYPED_TEST(TransferSystem, StaticLightAndObjectsAreNoWork) {
    const auto table = random_table(0, 100, 1);
    const auto entity = this->object(table);
    EXPECT_EQ(update_transfer(this->registry, this->frame).updated, 1U);
    const TransferResult& result = this->registry.template get<TransferResult>(entity);
    std::vector<glm::vec3> expected(100);
    prt::evaluate(*table, lamp({0.0F, 0.0F, 1.0F}).coefficients, expected);
    for (std::size_t i = 0; i < 100; ++i) {
        EXPECT_LT(glm::length(result.radiance[i] - expected[i]), 1e-5F);
    }
    for (int i = 0; i < 3; ++i) {
        const SystemReport again = update_transfer(this->registry, this->frame);
        EXPECT_EQ(again.considered, 1U);
        EXPECT_EQ(again.updated, 0U);
        EXPECT_EQ(again.skipped, 1U);
        EXPECT_EQ(again.error_bound, 0.0);
    }
}

TYPED_TEST(TransferSystem, NothingToDoWithoutTableLightOrEyes) {
    const auto entity = this->object(random_table(0, 20, 1));
    this->registry.template get<TransferMesh>(entity).visible = false;
    const auto bare = this->object(nullptr);
    const auto dark = this->object(random_table(0, 20, 1));
    this->registry.template get<ObjectLight>(dark) = ObjectLight{};
    const SystemReport report = update_transfer(this->registry, this->frame);
    EXPECT_EQ(report.considered, 3U);
    EXPECT_EQ(report.updated, 0U);
    EXPECT_EQ(this->registry.template try_get<TransferResult>(bare), nullptr);
    this->registry.template get<TransferMesh>(entity).visible = true;
    EXPECT_EQ(update_transfer(this->registry, this->frame).updated, 1U);
}

TYPED_TEST(TransferSystem, ErrorOfSkippedResultsStaysWithinTheirBudget) {
    const auto table = random_table(0, 64, 3);
    const auto entity = this->object(table);
    auto& mesh = this->registry.template get<TransferMesh>(entity);
    mesh.max_error = 0.02F;
    std::size_t updates = 0;
    for (int step = 0; step < 400; ++step) {
        const float a = 0.0005F * static_cast<float>(step);
        ObjectLight& light = this->registry.template get<ObjectLight>(entity);
        const std::uint32_t revision = light.revision;
        light = lamp({std::sin(a), 0.0F, std::cos(a)});
        light.revision = revision + 1;
        mesh.scene_from_object = glm::angleAxis(0.3F * a, glm::vec3(0.0F, 0.6F, 0.8F));
        const SystemReport report = update_transfer(this->registry, this->frame);
        updates += report.updated;
        EXPECT_LE(report.error_bound, 0.02 + 1e-9);
        // In secret: what it would be if it were computed now.
        std::vector<glm::vec3> turned(25);
        prt::to_object_frame(5, mesh.scene_from_object, light.coefficients, turned);
        std::vector<glm::vec3> truth(64);
        prt::evaluate(*table, turned, truth);
        const TransferResult& result = this->registry.template get<TransferResult>(entity);
        const float response = table->info.band_norm[0] * glm::compMax(light.coefficients[0]);
        for (std::size_t i = 0; i < 64; ++i) {
            EXPECT_LE(glm::compMax(glm::abs(truth[i] - result.radiance[i])), 0.02F * response + 1e-6F);
        }
    }
    EXPECT_GT(updates, 3U);
    EXPECT_LT(updates, 200U); // it does skip
}

TYPED_TEST(TransferSystem, ManyObjectsAreSpreadOverFrames) {
    const auto table = random_table(0, 1000, 3);
    std::vector<typename TypeParam::entity_type> objects;
    for (int i = 0; i < 40; ++i) {
        objects.push_back(this->object(table));
    }
    this->registry.ctx().template emplace<TransferBudget>(TransferBudget{4000});
    update_transfer(this->registry, this->frame);
    std::uint32_t most = 0;
    for (int step = 1; step < 300; ++step) {
        const float a = 0.0001F * static_cast<float>(step);
        for (const auto entity : objects) {
            ObjectLight& light = this->registry.template get<ObjectLight>(entity);
            const std::uint32_t revision = light.revision;
            light = lamp({std::sin(a), 0.0F, std::cos(a)});
            light.revision = revision + 1;
        }
        const SystemReport report = update_transfer(this->registry, this->frame);
        most = std::max(most, report.updated);
        EXPECT_LE(report.error_bound, 0.01 + 1e-9);
    }
    EXPECT_GT(most, 0U);
    EXPECT_LE(most, 4U); // the budget, not all forty at once
}

TYPED_TEST(TransferSystem, GpuObjectsGetTheirLightOnly) {
    const auto entity = this->object(random_table(0, 64, 3));
    auto& mesh = this->registry.template get<TransferMesh>(entity);
    mesh.on_gpu = true;
    mesh.scene_from_object = glm::angleAxis(1.0F, glm::vec3(0.0F, 1.0F, 0.0F));
    update_transfer(this->registry, this->frame);
    const TransferResult& result = this->registry.template get<TransferResult>(entity);
    EXPECT_TRUE(result.radiance.empty());
    ASSERT_EQ(result.object_light.size(), 25U);
    std::vector<glm::vec3> turned(25);
    prt::to_object_frame(5, mesh.scene_from_object, lamp({0.0F, 0.0F, 1.0F}).coefficients, turned);
    EXPECT_EQ(result.object_light, turned);
    EXPECT_EQ(update_transfer(this->registry, this->frame).updated, 0U);
}

TYPED_TEST(TransferSystem, MatricesVolumesAndNeighbourhoods) {
    const auto matrices = random_table(3, 30, 5);
    const auto around = this->registry.create();
    NeighbourhoodTransfer neighbourhood;
    neighbourhood.table = matrices;
    this->registry.template emplace<NeighbourhoodTransfer>(around, neighbourhood);
    this->registry.template emplace<ObjectLight>(around, lamp({0.0F, 0.0F, 1.0F}));
    const auto smoke = this->registry.create();
    TransferVolume volume;
    volume.table = random_table(0, 30, 6);
    this->registry.template emplace<TransferVolume>(smoke, volume);
    this->registry.template emplace<ObjectLight>(smoke, lamp({0.0F, 1.0F, 1.0F}));
    EXPECT_EQ(update_transfer(this->registry, this->frame).updated, 2U);
    const TransferResult& result = this->registry.template get<TransferResult>(around);
    ASSERT_EQ(result.radiance.size(), 30U * 9U);
    std::vector<glm::vec3> expected(270);
    prt::evaluate_matrix(*matrices, lamp({0.0F, 0.0F, 1.0F}).coefficients, expected);
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_LT(glm::length(expected[i] - result.radiance[i]), 1e-5F);
    }
    EXPECT_EQ(this->registry.template get<TransferResult>(smoke).radiance.size(), 30U);
}

} // namespace
} // namespace alpenglow
