#include "clouds_test_support.hpp"

#include <alpenglow/clouds/compact.hpp>
#include <alpenglow/clouds/march.hpp>

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

constexpr float any_error = std::numeric_limits<float>::infinity();

// A field of 3 x 2 x 2 bricks of f(x, y, z), all held to `error`.
template <class Function>
CompactField field_of(const Function& f, float error, bool squared) {
    return {glm::vec3(0.0F), 1, {3, 2, 2}, squared, [&](const glm::ivec3& brick, float* values, float* errors) {
                for (int i = 0; i < CompactField::brick_values; ++i) {
                    const glm::ivec3 c = brick * 8 + glm::ivec3(i % 9, i / 9 % 9, i / 81);
                    values[i] = f(glm::vec3(c));
                    errors[i] = values[i] == 0.0F && squared ? 0.0F : error;
                }
                return true;
            }};
}

template <class Function>
double worst(const CompactField& field, const Function& f) {
    double out = 0.0;
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 24; ++x) {
                const glm::vec3 p(x, y, z);
                out = std::max(out, std::abs(double(field.sample(p)) - double(f(p))));
            }
        }
    }
    return out;
}

float noise_at(const glm::vec3& p) {
    return test::random_at(static_cast<std::uint32_t>(p.x + 64.0F * (p.y + 64.0F * p.z)));
}

TEST(CompactField, NoValueIsOffByMoreThanItsError) {
    for (const float error : {0.2F, 0.02F, 0.001F}) {
        for (const bool squared : {false, true}) {
            const CompactField field = field_of(noise_at, error, squared);
            EXPECT_LE(worst(field, noise_at), double(error) * 1.001) << squared;
        }
    }
    // The less is asked, the fewer bytes.
    EXPECT_LT(field_of(noise_at, 0.2F, false).memory_bytes(), field_of(noise_at, 0.001F, false).memory_bytes() / 2);
}

TEST(CompactField, WhatIsSimpleCostsNothing) {
    const auto flat = [](const glm::vec3&) { return 0.7F; };
    const auto plane = [](const glm::vec3& p) { return 3.0F + 0.5F * p.x - 0.25F * p.y + 2.0F * p.z; };
    const auto smooth = [](const glm::vec3& p) { return std::sin(0.1F * p.x) + std::cos(0.07F * (p.y + p.z)); };
    const std::size_t noisy = field_of(noise_at, 0.02F, false).data().size();
    EXPECT_LT(field_of(flat, 1e-4F, true).data().size(), 200U);
    EXPECT_LT(field_of(plane, 0.02F, false).data().size(), 200U);
    EXPECT_LT(field_of(smooth, 0.02F, false).data().size(), noisy / 8);
    EXPECT_LE(worst(field_of(flat, 1e-4F, true), flat), 1e-4);
    EXPECT_LE(worst(field_of(plane, 0.02F, false), plane), 0.02);
    // Where lines stand for values, single ones may be off by 4 errors.
    EXPECT_LE(worst(field_of(smooth, 0.02F, false), smooth), 0.08);
}

TEST(CompactField, ZerosStayZerosAndDoNotCareIsNotStored) {
    // A ball: zero outside.
    const auto ball = [](const glm::vec3& p) {
        const glm::vec3 d = p - glm::vec3(11.0F, 8.0F, 7.0F);
        return std::max(0.0F, 1.0F - (d.x * d.x + d.y * d.y + d.z * d.z) / 30.0F);
    };
    const CompactField field = field_of(ball, 0.02F, true);
    for (std::uint32_t i = 0; i < 20000; ++i) {
        const glm::vec3 p = glm::vec3(23.0F, 15.0F, 15.0F) *
                            glm::vec3(test::random_at(3 * i), test::random_at(3 * i + 1), test::random_at(3 * i + 2));
        const glm::vec3 low = glm::floor(p);
        bool empty = true;
        for (int corner = 0; corner < 8; ++corner) {
            empty = empty && ball(low + glm::vec3(corner & 1, corner >> 1 & 1, corner >> 2)) == 0.0F;
        }
        if (empty) {
            ASSERT_EQ(field.sample(p), 0.0F);
        }
    }
    EXPECT_LE(worst(field, ball), 0.08);
    // The box around the ball is all that is kept.
    EXPECT_LT(field.data().size(), 12U * 12U * 12U * 2U);
    const CompactField nothing(glm::vec3(0.0F), 1, {2, 2, 2}, false,
                               [](const glm::ivec3&, float*, float*) { return false; });
    EXPECT_EQ(nothing.sample({5.0F, 5.0F, 5.0F}), 0.0F);
    const CompactField free(glm::vec3(0.0F), 1, {2, 2, 2}, false, [](const glm::ivec3&, float* values, float* errors) {
        std::fill_n(values, CompactField::brick_values, 5.0F);
        std::fill_n(errors, CompactField::brick_values, any_error);
        return true;
    });
    EXPECT_LT(free.data().size(), 200U);
    EXPECT_TRUE(std::isfinite(free.sample({5.0F, 5.0F, 5.0F})));
}

struct Scene {
    SparseGrid grid = noise_cloud(51, 40);
    BrickVolume volume;
    CloudLighting lighting;
    glm::dvec3 centre;
    Scene(LightingMethod method, const GridTransform& transform, float extinction = 0.5F) {
        grid.set_transform(transform);
        volume = BrickVolume(grid);
        centre = transform.world_from_index(glm::dvec3(20.0));
        LightingSettings settings;
        settings.method = method;
        lighting.reset(volume, {extinction, 0.98F, {}}, settings);
        lighting.bake_light(0, {test::unit({0.2F, 0.4F, 0.8F}), glm::vec3(10.0F, 9.0F, 8.0F), 0.0F});
        lighting.bake_light(1, {test::unit({-0.2F, -0.4F, 0.3F}), glm::vec3(0.2F, 0.3F, 0.8F), 0.0F});
        lighting.bake_sky(SkySh::uniform(glm::vec3(0.3F, 0.5F, 1.0F)));
    }
};

double relative(const Picture& a, const Picture& b) {
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            error += std::pow(double(a.radiance[i][k]) - double(b.radiance[i][k]), 2.0);
            norm += std::pow(double(b.radiance[i][k]), 2.0);
        }
    }
    return std::sqrt(error / norm);
}

TEST(CompactCloud, VectorsAndScalarsSeeTheSameAndAlmostThePlainPicture) {
    GridTransform tilted;
    tilted.voxel_m = {1.0, 2.0, 1.5};
    tilted.origin_m = {100.0, -50.0, 20.0};
    tilted.axes = glm::dmat3(glm::dvec3(0.8, 0.6, 0.0), glm::dvec3(-0.6, 0.8, 0.0), glm::dvec3(0.0, 0.0, 1.0));
    const DetailTexture texture;
    for (const LightingMethod method : {LightingMethod::single_scattering, LightingMethod::harris,
                                        LightingMethod::octaves, LightingMethod::transport}) {
        for (const GridTransform& transform : {GridTransform{}, tilted}) {
            const Scene scene(method, transform);
            for (const glm::dvec3& from : {glm::dvec3(-80, -40, 30), glm::dvec3(0.0), glm::dvec3(0, 0, 100)}) {
                const Camera camera = look_at(scene.centre + from, scene.centre + glm::dvec3(0, 1, -1), 0.4F, 37, 23);
                const CompactCloud compact(scene.volume, scene.lighting, camera.position_m);
                MarchSettings settings;
                settings.detail = from.z == 30.0 ? &texture : nullptr;
                const Picture a = march(compact, camera, settings);
                const Picture b = march_scalar(compact, camera, settings);
                const Picture plain = march(scene.volume, scene.lighting, camera, settings);
                for (std::size_t i = 0; i < a.radiance.size(); ++i) {
                    for (int k = 0; k < 3; ++k) {
                        ASSERT_NEAR(a.radiance[i][k], b.radiance[i][k], 2e-3F * b.radiance[i][k] + 2e-4F);
                    }
                    ASSERT_NEAR(a.transmittance[i], b.transmittance[i], 1e-4F);
                    if (plain.transmittance[i] == 1.0F) {
                        ASSERT_EQ(a.transmittance[i], 1.0F);
                    }
                }
                EXPECT_LT(relative(a, plain), 0.015);
            }
        }
    }
}

TEST(CompactCloud, ReadsLessThanHalfAndTightensAsAsked) {
    const Scene scene(LightingMethod::transport, {});
    const Camera camera = look_at(scene.centre + glm::dvec3(-80, -40, 30), scene.centre, 0.4F, 64, 48);
    const Picture plain = march(scene.volume, scene.lighting, camera);
    std::size_t bytes = scene.volume.memory_bytes() + scene.lighting.table().values().size() * sizeof(float);
    for (const BakedLight& light : scene.lighting.lights()) {
        bytes += light.depth.memory_bytes();
    }
    for (const Field16& field :
         scene.lighting.contract(scene.volume.transform().index_from_world(camera.position_m)).fields) {
        bytes += field.memory_bytes();
    }
    const CompactCloud compact(scene.volume, scene.lighting, camera.position_m);
    EXPECT_LT(compact.memory_bytes(), bytes / 2);
    EXPECT_EQ(compact.memory_bytes(), compact.density_bytes() + compact.light_bytes());
    CompactSettings settings;
    settings.density_error /= 16.0F;
    settings.depth_error /= 16.0F;
    settings.light_error /= 16.0F;
    const CompactCloud tight(scene.volume, scene.lighting, camera.position_m, settings);
    EXPECT_GT(tight.memory_bytes(), compact.memory_bytes());
    EXPECT_LT(relative(march(tight, camera), plain), 0.2 * relative(march(compact, camera), plain));
}

TEST(CompactCloud, RelightingIsMakingAnew) {
    Scene scene(LightingMethod::transport, {});
    const Camera camera = look_at(scene.centre + glm::dvec3(90, 20, -10), scene.centre, 0.4F, 24, 16);
    CompactCloud cloud(scene.volume, scene.lighting, glm::dvec3(0.0));
    scene.lighting.bake_light(0, {test::unit({-0.7F, 0.1F, 0.3F}), glm::vec3(5.0F), 0.0F}, false);
    cloud.relight(scene.volume, scene.lighting, camera.position_m);
    const CompactCloud anew(scene.volume, scene.lighting, camera.position_m);
    const Picture a = march(cloud, camera);
    const Picture b = march(anew, camera);
    EXPECT_EQ(cloud.memory_bytes(), anew.memory_bytes());
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        ASSERT_EQ(a.radiance[i].x, b.radiance[i].x);
    }
}

} // namespace
