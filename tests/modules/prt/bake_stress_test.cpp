#include "helpers.hpp"

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/shapes.hpp>

#include <fp_traps.hpp>

#include <limits>

namespace alpenglow::prt {
namespace {

using BakeStress = alpenglow::test::StressTest;

BakeSettings quick() {
    BakeSettings settings;
    settings.rays = 256;
    settings.gather_rays = 32;
    settings.transport = Transport::interreflected;
    return settings;
}

void expect_sound(const Result<Bake>& baked) {
    ASSERT_TRUE(baked) << baked.error().message();
    for (const float x : baked->field.values) {
        ASSERT_TRUE(std::isfinite(x));
        ASSERT_LT(std::abs(x), 3.0F);
    }
}

TEST_F(BakeStress, EveryOrderAndSampling) {
    const Mesh mesh = merged(plane(2.0F, 4), sphere(0.5F, 2), glm::vec3(0.0F, 0.0F, 0.7F));
    for (int order = 1; order <= 6; ++order) {
        for (const Sampling sampling :
             {Sampling::random, Sampling::stratified, Sampling::fibonacci, Sampling::adaptive}) {
            BakeSettings settings = quick();
            settings.order = order;
            settings.sampling = sampling;
            expect_sound(bake(mesh, settings));
        }
    }
}

TEST_F(BakeStress, CoincidentFaces) {
    Mesh mesh = merged(plane(1.0F, 6), inverted(plane(1.0F, 6)));
    mesh = merged(mesh, plane(1.0F, 6));
    const Result<Bake> baked = bake(mesh, quick());
    expect_sound(baked);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_NEAR(test::white(baked->field.point(i)), 1.0, 1e-6);
    }
}

TEST_F(BakeStress, NeedlesAndSlivers) {
    Mesh mesh;
    for (int i = 0; i < 50; ++i) {
        const auto first = static_cast<unsigned>(mesh.positions.size());
        const float x = static_cast<float>(i);
        const float thin = std::pow(10.0F, -static_cast<float>(i) / 4.0F); // down to 1e-12
        mesh.positions.emplace_back(x, 0.0F, 0.0F);
        mesh.positions.emplace_back(x + 100.0F, thin, 0.0F);
        mesh.positions.emplace_back(x, 2.0F * thin, 0.01F);
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    expect_sound(bake(mesh, quick()));
}

TEST_F(BakeStress, TinyHugeAndFarAway) {
    for (const float scale : {1e-9F, 1e-3F, 1e6F, 1e12F}) {
        Mesh mesh = merged(plane(2.0F, 4), sphere(0.5F, 3), glm::vec3(0.0F, 0.0F, 0.7F));
        for (glm::vec3& p : mesh.positions) {
            p *= scale;
        }
        const Result<Bake> baked = bake(mesh, quick());
        expect_sound(baked);
        // Scale does not matter: under the ball it is dark by a third or more.
        EXPECT_LT(test::white(baked->field.point(12)), 0.7) << scale;
        EXPECT_GT(test::white(baked->field.point(0)), 0.9) << scale;
    }
    Mesh far = plane(1.0F, 4);
    for (glm::vec3& p : far.positions) {
        p += glm::vec3(1e6F, -1e6F, 1e5F);
    }
    expect_sound(bake(far, quick()));
}

TEST_F(BakeStress, AHugeDeltaOfLight) {
    const Mesh mesh = merged(plane(2.0F, 4), sphere(0.5F, 3), glm::vec3(0.0F, 0.0F, 0.7F));
    const Result<Bake> baked = bake(mesh, quick());
    expect_sound(baked);
    std::array<float, 25> y{};
    sh::evaluate_basis(5, glm::vec3(0.6F, 0.0F, 0.8F), y);
    std::vector<glm::vec3> light(25);
    for (std::size_t i = 0; i < 25; ++i) {
        light[i] = glm::vec3(1.6e9F * y[i]); // the sun's radiance in one coefficient vector
    }
    for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
        const Result<TransferTable> table = encode(baked->field, encoding);
        ASSERT_TRUE(table);
        std::vector<glm::vec3> out(mesh.positions.size());
        evaluate(*table, light, out);
        for (const glm::vec3& v : out) {
            ASSERT_TRUE(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z));
        }
    }
}

TEST_F(BakeStress, FieldsOfExtremeValues) {
    TransferField field = test::random_field(5, 0, 3, 33, 1);
    for (const float scale : {0.0F, 1e-38F, 1e-20F, 1e-6F, 1e4F}) {
        TransferField scaled = field;
        for (float& x : scaled.values) {
            x *= scale;
        }
        for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
            const Result<TransferTable> table = encode(scaled, encoding);
            ASSERT_TRUE(table);
            std::vector<glm::vec3> out(33);
            evaluate(*table, test::random_light(5, 1), out);
            for (const glm::vec3& v : out) {
                ASSERT_TRUE(std::isfinite(v.x));
            }
        }
    }
}

} // namespace
} // namespace alpenglow::prt
