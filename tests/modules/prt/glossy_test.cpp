#include "helpers.hpp"

#include <alpenglow/prt/bake_glossy.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/lobe.hpp>
#include <alpenglow/prt/shapes.hpp>
#include <alpenglow/sh/irradiance.hpp>

#include <gtest/gtest.h>

namespace alpenglow::prt {
namespace {

GlossySettings quick() {
    GlossySettings settings;
    settings.rays = 2048;
    settings.gather_rays = 256;
    return settings;
}

TEST(Lobe, KernelsMatchQuadratureAndLimits) {
    std::array<float, 6> kernel{};
    phong_kernel(1.0, kernel); // the clamped cosine
    for (int l = 0; l < 6; ++l) {
        EXPECT_NEAR(kernel[static_cast<std::size_t>(l)], sh::cosine_factor(l) / 3.14159265358979, 1e-6);
    }
    phong_kernel(1e9, kernel); // a mirror passes every band
    for (const float k : kernel) {
        EXPECT_NEAR(k, 1.0F, 1e-6F);
    }
    for (const double exponent : {0.0, 0.5, 3.0, 50.0}) {
        phong_kernel(exponent, kernel);
        std::array<double, 6> integral{};
        constexpr int steps = 20000;
        for (int i = 0; i < steps; ++i) {
            const double z = (i + 0.5) / steps;
            for (unsigned l = 0; l < 6; ++l) {
                integral[l] += std::pow(z, exponent) * std::legendre(l, z);
            }
        }
        for (std::size_t l = 0; l < 6; ++l) {
            EXPECT_NEAR(kernel[l], integral[l] / integral[0], 2e-4) << exponent;
        }
    }
    ggx_kernel(0.01, kernel);
    EXPECT_GT(kernel[5], 0.95F);
    float last = 1.0F;
    for (const double alpha : {0.01, 0.05, 0.2, 0.5, 1.0}) {
        ggx_kernel(alpha, kernel);
        EXPECT_EQ(kernel[0], 1.0F);
        EXPECT_LT(kernel[2], last); // rougher blurs more
        last = kernel[2];
    }
}

TEST(BakeGlossy, ShadowedMatricesAreSymmetric) { // the remark under the paper's rules, section 5
    const Mesh mesh = merged(plane(1.0F, 4), sphere(0.4F, 3), glm::vec3(0.0F, 0.0F, 0.6F));
    const Result<Bake> baked = bake_glossy(mesh, quick());
    ASSERT_TRUE(baked) << baked.error().message();
    for (std::size_t p = 0; p < baked->field.count; ++p) {
        const std::span<const float> m = baked->field.point(p);
        for (std::size_t i = 0; i < 25; ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                ASSERT_NEAR(m[i * 25 + j], m[j * 25 + i], 1e-6F);
            }
        }
    }
}

TEST(BakeGlossy, CosineOfTheMatrixIsTheDiffuseVector) {
    const Mesh mesh = merged(plane(1.0F, 4), sphere(0.4F, 3), glm::vec3(0.0F, 0.0F, 0.6F));
    GlossySettings settings = quick();
    settings.order = 3;
    settings.out_order = 6; // rectangular, and little of the cosine is cut off
    settings.rays = 8192;
    const Result<Bake> glossy = bake_glossy(mesh, settings);
    ASSERT_TRUE(glossy);
    BakeSettings diffuse;
    diffuse.order = 3;
    diffuse.max_error = 0.0;
    const Result<Bake> vectors = bake(mesh, diffuse);
    ASSERT_TRUE(vectors);
    std::array<float, 36> y{};
    double sum = 0.0;
    for (std::size_t p = 0; p < mesh.positions.size(); ++p) {
        sh::evaluate_basis(6, mesh.normals[p], y);
        std::vector<float> m(9, 0.0F);
        for (int l = 0; l < 6; ++l) {
            for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                const float w =
                    static_cast<float>(sh::cosine_factor(l) / 3.14159265358979) * y[static_cast<std::size_t>(i)];
                for (std::size_t j = 0; j < 9; ++j) {
                    m[j] += w * glossy->field.point(p)[static_cast<std::size_t>(i) * 9 + j];
                }
            }
        }
        const double d = test::distance(m, vectors->field.point(p));
        sum += d * d;
    }
    // What bands 6 and up of the cosine would add: its tail is 1.6 % of its norm, times the sharp horizon.
    EXPECT_LT(std::sqrt(sum / static_cast<double>(mesh.positions.size())), 0.02);
}

TEST(BakeGlossy, ClosedBoxIsDarkAndBouncesAddLight) {
    const Mesh closed = inverted(box(glm::vec3(1.0F), 2));
    const Result<Bake> dark = bake_glossy(closed, quick());
    ASSERT_TRUE(dark);
    EXPECT_EQ(test::norm(dark->field.values), 0.0);
    EXPECT_EQ(dark->report.dark_points, closed.positions.size());

    const Mesh mesh = bowl(1.0F, 24, 8);
    GlossySettings settings = quick();
    const Result<Bake> direct = bake_glossy(mesh, settings);
    settings.transport = Transport::interreflected;
    settings.specular = 0.3F;
    settings.default_albedo = 0.5F;
    const Result<Bake> bounced = bake_glossy(mesh, settings);
    ASSERT_TRUE(direct);
    ASSERT_TRUE(bounced);
    EXPECT_GT(bounced->field.point(0)[0], direct->field.point(0)[0]);
    ASSERT_GE(bounced->report.bounce_energy.size(), 2U);
    EXPECT_LT(bounced->report.bounce_energy[1], bounced->report.bounce_energy[0]);
    EXPECT_LT(bounced->report.bounce_energy[0], 0.8); // the most that it reflects
}

TEST(BakeGlossy, WhiteLightOnAFlatFloorIsTheHorizonThroughTheLobe) {
    // The upper hemisphere, cut to six bands and blurred: sum_l k_l (2l + 1) / 2 int_0^1 P_l, with integrals
    // 1, 1/2, 0, -1/8, 0, 1/16.
    const Mesh mesh = plane(1.0F, 2);
    GlossySettings settings = quick();
    settings.out_order = 6;
    settings.order = 2;
    settings.rays = 16384;
    const Result<TransferTable> table = encode(bake_glossy(mesh, settings)->field, Encoding::f32);
    ASSERT_TRUE(table);
    std::vector<glm::vec3> light(4, glm::vec3(0.0F));
    light[0] = glm::vec3(std::sqrt(4.0F * 3.14159265F));
    std::array<float, 6> kernel{};
    phong_kernel(30.0, kernel);
    const std::vector<glm::vec3> up(mesh.positions.size(), glm::vec3(0.0F, 0.0F, 1.0F));
    std::vector<glm::vec3> out(mesh.positions.size());
    evaluate_glossy(*table, light, kernel, up, out);
    const float expected = 0.5F + 0.75F * kernel[1] - 3.5F / 8.0F * kernel[3] + 5.5F / 16.0F * kernel[5];
    for (const glm::vec3& v : out) {
        EXPECT_NEAR(v.x, expected, 2e-3F);
    }
}

TEST(BakeGlossy, RefusesNonsense) {
    GlossySettings settings = quick();
    settings.out_order = 9;
    EXPECT_FALSE(bake_glossy(plane(1.0F, 1), settings));
    settings = quick();
    settings.specular = 0.8F;
    settings.default_albedo = 0.5F; // more than all light
    EXPECT_FALSE(bake_glossy(plane(1.0F, 1), settings));
    EXPECT_FALSE(bake_glossy(Mesh{}, quick()));
}

} // namespace
} // namespace alpenglow::prt
