#include "helpers.hpp"

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/light.hpp>
#include <alpenglow/prt/shapes.hpp>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtx/component_wise.hpp>

namespace alpenglow::prt {
namespace {

TEST(Light, TurningTheObjectIsTurningTheLightTheOtherWay) {
    // Unshadowed transfer of a turned normal under the scene's light equals that of the unturned under turned light.
    const glm::quat turn = glm::angleAxis(1.1F, glm::normalize(glm::vec3(1.0F, -2.0F, 0.5F)));
    const glm::vec3 normal = glm::normalize(glm::vec3(0.3F, 0.5F, -0.2F));
    const std::vector<glm::vec3> light = test::random_light(5, 2);
    std::vector<glm::vec3> turned(25);
    to_object_frame(5, turn, light, turned);
    std::array<float, 25> in_object{};
    std::array<float, 25> in_scene{};
    unshadowed(5, normal, in_object);
    unshadowed(5, turn * normal, in_scene);
    glm::vec3 a(0.0F);
    glm::vec3 b(0.0F);
    for (std::size_t i = 0; i < 25; ++i) {
        a += in_object[i] * turned[i];
        b += in_scene[i] * light[i];
    }
    EXPECT_LT(glm::length(a - b), 1e-5F);
}

TEST(Light, RotationOfRefusesWhatTransferCannotFollow) {
    const glm::mat3 turn = glm::mat3_cast(glm::angleAxis(0.7F, glm::normalize(glm::vec3(1.0F, 2.0F, 3.0F))));
    const Result<glm::quat> plain = rotation_of(turn * 3.0F);
    ASSERT_TRUE(plain);
    EXPECT_LT(glm::compMax(glm::abs(glm::mat3_cast(*plain)[0] - turn[0])), 1e-5F);
    glm::mat3 stretched = turn;
    stretched[1] *= 2.0F;
    EXPECT_FALSE(rotation_of(stretched));
    glm::mat3 mirrored = turn;
    mirrored[2] *= -1.0F;
    ASSERT_FALSE(rotation_of(mirrored));
    EXPECT_NE(rotation_of(mirrored).error().message().find("mirrored"), std::string::npos);
    glm::mat3 sheared = turn;
    sheared[0] = glm::normalize(sheared[0] + 0.3F * sheared[1]);
    EXPECT_FALSE(rotation_of(sheared));
    EXPECT_FALSE(rotation_of(glm::mat3(0.0F)));
}

TEST(Light, SamplesSpreadOverTheObjectAndBlend) {
    const Mesh mesh = box(glm::vec3(10.0F, 1.0F, 1.0F), 8);
    const LightSamples samples = light_samples(mesh.positions, 4);
    ASSERT_EQ(samples.points_m.size(), 4U);
    float low = 0.0F;
    float high = 0.0F;
    for (const glm::vec3& p : samples.points_m) {
        low = std::min(low, p.x);
        high = std::max(high, p.x);
    }
    EXPECT_LT(low, -4.0F);
    EXPECT_GT(high, 4.0F);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        float sum = 0.0F;
        for (std::size_t c = 0; c < 4; ++c) {
            sum += samples.weights[v * 4 + c];
        }
        EXPECT_NEAR(sum, 1.0F, 1e-5F);
    }
    // One light everywhere: as if there were one sample.
    TransferField field = test::random_field(4, 0, 1, mesh.positions.size(), 3);
    const Result<TransferTable> table = encode(field, Encoding::f32);
    ASSERT_TRUE(table);
    const std::vector<glm::vec3> light = test::random_light(4, 8);
    std::vector<glm::vec3> lights;
    for (int c = 0; c < 4; ++c) {
        lights.insert(lights.end(), light.begin(), light.end());
    }
    std::vector<glm::vec3> varying(field.count);
    std::vector<glm::vec3> single(field.count);
    std::vector<glm::vec3> scratch;
    evaluate_varying(*table, samples, 4, lights, varying, scratch);
    evaluate(*table, light, single);
    for (std::size_t v = 0; v < field.count; ++v) {
        EXPECT_LT(glm::length(varying[v] - single[v]), 2e-5F);
    }
    EXPECT_EQ(light_samples({}, 3).points_m.size(), 0U);
    const std::vector<glm::vec3> same(10, glm::vec3(1.0F));
    EXPECT_EQ(light_samples(same, 3).points_m.size(), 1U);
}

TEST(Light, ChangeBoundHolds) {
    const TransferField field = test::random_field(5, 0, 1, 64, 21);
    const Result<TransferTable> table = encode(field, Encoding::f32);
    ASSERT_TRUE(table);
    for (unsigned seed = 0; seed < 60; ++seed) {
        const std::vector<glm::vec3> before = test::random_light(5, seed);
        std::vector<glm::vec3> now = test::random_light(5, seed + 1000);
        const float mix = static_cast<float>(seed % 6) * 0.02F;
        for (std::size_t i = 0; i < now.size(); ++i) {
            now[i] = glm::mix(before[i], now[i], mix);
        }
        const glm::quat from = glm::angleAxis(static_cast<float>(seed), glm::normalize(glm::vec3(1.0F, 1.0F, 0.2F)));
        const glm::quat to =
            from * glm::angleAxis(static_cast<float>(seed % 5) * 0.03F, glm::normalize(glm::vec3(0.3F, 1.0F, -1.0F)));
        const float bound = change_bound(table->info, 5, before, from, now, to);
        std::vector<glm::vec3> a(25);
        std::vector<glm::vec3> b(25);
        to_object_frame(5, from, before, a);
        to_object_frame(5, to, now, b);
        std::vector<glm::vec3> out_a(64);
        std::vector<glm::vec3> out_b(64);
        evaluate(*table, a, out_a);
        evaluate(*table, b, out_b);
        for (std::size_t i = 0; i < 64; ++i) {
            EXPECT_LE(glm::compMax(glm::abs(out_a[i] - out_b[i])), bound + 1e-5F);
        }
    }
}

} // namespace
} // namespace alpenglow::prt
