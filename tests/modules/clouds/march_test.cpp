#include "clouds_test_support.hpp"

#include <alpenglow/clouds/march.hpp>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

struct Scene {
    SparseGrid grid = noise_cloud(51, 40);
    BrickVolume volume{grid};
    CloudLighting lighting;
    explicit Scene(LightingMethod method = LightingMethod::transport) {
        LightingSettings settings;
        settings.method = method;
        lighting.reset(volume, {0.5F, 0.98F, {}}, settings);
        lighting.bake_light(0, {test::unit({0.2F, 0.4F, 0.8F}), glm::vec3(10.0F, 9.0F, 8.0F), 0.0F});
        lighting.bake_light(1, {test::unit({-0.2F, -0.4F, 0.3F}), glm::vec3(0.2F, 0.3F, 0.8F), 0.0F});
        SkySh sky = SkySh::uniform(glm::vec3(0.3F, 0.5F, 1.0F));
        sky.bands = 2;
        sky.coefficients[2] = glm::vec3(0.1F, 0.3F, 0.5F);
        lighting.bake_sky(sky);
    }
};

TEST(CloudMarch, VectorsAndScalarsSeeTheSame) {
    for (const LightingMethod method : {LightingMethod::single_scattering, LightingMethod::harris,
                                        LightingMethod::octaves, LightingMethod::transport}) {
        const Scene scene(method);
        for (const glm::dvec3& eye : {glm::dvec3(-60, -20, 50), glm::dvec3(20, 20, 20), glm::dvec3(20, 20, 120)}) {
            const Camera camera = look_at(eye, {20, 21, 19}, 0.4F, 37, 23);
            const Picture a = march(scene.volume, scene.lighting, camera);
            const Picture b = march_scalar(scene.volume, scene.lighting, camera);
            for (std::size_t i = 0; i < a.radiance.size(); ++i) {
                for (int k = 0; k < 3; ++k) {
                    ASSERT_NEAR(a.radiance[i][k], b.radiance[i][k], 2e-3F * b.radiance[i][k] + 2e-4F);
                }
                ASSERT_NEAR(a.transmittance[i], b.transmittance[i], 1e-4F);
                ASSERT_NEAR(a.depth_m[i], b.depth_m[i], 1e-2F * b.depth_m[i] + 1e-2F);
                ASSERT_NEAR(a.spread_m[i], b.spread_m[i], 2e-2F * b.spread_m[i] + 2e-2F);
            }
        }
    }
}

TEST(CloudMarch, DetailIsTheSameInVectorsAndAddsNothingWhereNothingIs) {
    const Scene scene;
    const DetailTexture texture;
    MarchSettings settings;
    settings.detail = &texture;
    const Camera camera = look_at({-60, -20, 50}, {20, 21, 19}, 0.4F, 37, 23);
    const Picture plain = march(scene.volume, scene.lighting, camera);
    const Picture a = march(scene.volume, scene.lighting, camera, settings);
    const Picture b = march_scalar(scene.volume, scene.lighting, camera, settings);
    double changed = 0.0;
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        ASSERT_NEAR(a.radiance[i].g, b.radiance[i].g, 2e-3F * b.radiance[i].g + 2e-4F);
        ASSERT_NEAR(a.transmittance[i], b.transmittance[i], 1e-4F);
        if (plain.transmittance[i] == 1.0F) {
            EXPECT_EQ(a.transmittance[i], 1.0F);
        }
        changed += double(std::abs(a.transmittance[i] - plain.transmittance[i]));
    }
    EXPECT_GT(changed, 1.0);
    settings.detail_strength = 0.0F;
    EXPECT_EQ(march(scene.volume, scene.lighting, camera, settings).transmittance, plain.transmittance);
}

TEST(CloudDetail, RepeatsWithoutASeamAndHasNoMean) {
    const DetailTexture texture(3);
    double sum = 0.0;
    double largest_step = 0.0;
    for (int z = 0; z < 64; z += 3) {
        for (int y = 0; y < 64; y += 3) {
            for (int x = 0; x < 64; ++x) {
                const glm::vec3 at = glm::vec3(x, y, z) + glm::vec3(0.25F, 0.5F, 0.75F);
                const float value = texture.sample(at);
                ASSERT_GE(value, -1.0F);
                ASSERT_LE(value, 1.0F);
                ASSERT_NEAR(value, texture.sample(at + glm::vec3(64.0F, 128.0F, 192.0F)), 1e-4F);
                sum += double(value) / (22.0 * 22.0 * 64.0);
                largest_step =
                    std::max(largest_step, double(std::abs(texture.sample(at + glm::vec3(1, 0, 0)) - value)));
            }
        }
    }
    EXPECT_NEAR(sum, 0.0, 0.05);
    EXPECT_LT(largest_step, 1.0); // a seam would jump
}

TEST(CloudDetail, DriftIsAFunctionOfTimeThatStaysInTheTexture) {
    for (const double lifetime : {1e-3, 60.0, 1e6}) {
        for (const double time : {0.0, -1e-300, 1.0, -7.5, 1e4, -1e9, 1e15}) {
            const DetailOffsets a = detail_drift(time, lifetime);
            const DetailOffsets b = detail_drift(time, lifetime);
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_EQ(a.first[axis], b.first[axis]);
                ASSERT_EQ(a.second[axis], b.second[axis]);
                for (const float offset : {a.first[axis], a.second[axis]}) {
                    ASSERT_GE(offset, 0.0F);
                    ASSERT_LT(offset, static_cast<float>(DetailTexture::size));
                }
            }
        }
    }
    // A billow a lifetime: an eighth of the side.
    const DetailOffsets then = detail_drift(1000.0, 60.0);
    const DetailOffsets now = detail_drift(1060.0, 60.0);
    const auto moved = [](const glm::vec3& a, const glm::vec3& b) {
        glm::vec3 d = b - a;
        for (int axis = 0; axis < 3; ++axis) {
            d[axis] -= 64.0F * std::round(d[axis] / 64.0F);
        }
        return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    };
    EXPECT_NEAR(moved(then.first, now.first), 8.0F, 0.02F);
    EXPECT_NEAR(moved(then.second, now.second), 8.0F, 0.02F);
}

TEST(CloudDetail, DriftingDetailKeepsItsBoundMeanAndSpreadAndChangesWithoutJumps) {
    const DetailTexture texture(3);
    const auto statistics = [&](const DetailOffsets* offsets) {
        double mean = 0.0;
        double square = 0.0;
        for (std::uint32_t i = 0; i < 20000; ++i) {
            const glm::vec3 at =
                64.0F * glm::vec3(test::random_at(3 * i), test::random_at(3 * i + 1), test::random_at(3 * i + 2));
            const float v = offsets != nullptr ? texture.sample(at, *offsets) : texture.sample(at);
            EXPECT_LE(std::abs(v), 1.41422F);
            mean += double(v) / 20000.0;
            square += double(v) * double(v) / 20000.0;
        }
        return std::pair(mean, std::sqrt(square - mean * mean));
    };
    const auto [mean, spread] = statistics(nullptr);
    for (const double time : {0.0, 17.0, 1e5}) {
        const DetailOffsets offsets = detail_drift(time, 60.0);
        const auto [drifting_mean, drifting_spread] = statistics(&offsets);
        EXPECT_NEAR(drifting_mean, mean, 0.03);
        EXPECT_NEAR(drifting_spread, spread, 0.05 * spread);
    }
    // From frame to frame little, within a lifetime all: also where offsets wrap.
    const auto change = [&](double time, double later) {
        const DetailOffsets a = detail_drift(time, 60.0);
        const DetailOffsets b = detail_drift(later, 60.0);
        double sum = 0.0;
        for (std::uint32_t i = 0; i < 2000; ++i) {
            const glm::vec3 at =
                64.0F * glm::vec3(test::random_at(3 * i), test::random_at(3 * i + 1), test::random_at(3 * i + 2));
            sum += std::pow(double(texture.sample(at, a)) - double(texture.sample(at, b)), 2.0) / 2000.0;
        }
        return std::sqrt(sum);
    };
    for (double time = 0.0; time < 2000.0; time += 10.0) {
        EXPECT_LT(change(time, time + 1.0 / 30.0), 0.005) << time;
    }
    EXPECT_GT(change(100.0, 160.0), spread);
}

TEST(CloudMarch, DriftingDetailIsTheSameInVectorsAndKeepsTheLightsPicture) {
    const Scene scene;
    const DetailTexture texture;
    MarchSettings settings;
    settings.detail = &texture;
    const Camera camera = look_at({-60, -20, 50}, {20, 21, 19}, 0.4F, 37, 23);
    const Picture plain = march(scene.volume, scene.lighting, camera);
    const auto sum_of = [](const Picture& picture) {
        double sum = 0.0;
        for (const glm::vec3& c : picture.radiance) {
            sum += double(c.g);
        }
        return sum;
    };
    Picture last;
    for (const double time : {0.0, 25.0, 1e6}) {
        settings.detail_offsets = detail_drift(time, 60.0);
        const Picture a = march(scene.volume, scene.lighting, camera, settings);
        const Picture b = march_scalar(scene.volume, scene.lighting, camera, settings);
        double changed = 0.0;
        for (std::size_t i = 0; i < a.radiance.size(); ++i) {
            ASSERT_NEAR(a.radiance[i].g, b.radiance[i].g, 2e-3F * b.radiance[i].g + 2e-4F);
            ASSERT_NEAR(a.transmittance[i], b.transmittance[i], 1e-4F);
            if (plain.transmittance[i] == 1.0F) {
                EXPECT_EQ(a.transmittance[i], 1.0F); // nothing comes where nothing was
            }
            changed += last.width > 0 ? double(std::abs(a.transmittance[i] - last.transmittance[i])) : 1.0;
        }
        EXPECT_GT(changed, 1.0);
        EXPECT_NEAR(sum_of(a), sum_of(plain), 0.03 * sum_of(plain)); // light is not made by moving
        last = a;
    }
}

// Slabs of a ray one after another are the whole ray.
TEST(CloudMarch, SlabsAddUp) {
    const Scene scene;
    const Camera camera = look_at({-60, -20, 50}, {20, 21, 19}, 0.4F, 37, 23);
    MarchSettings settings;
    settings.stop_transmittance = 1e-6F;
    const Picture whole = march(scene.volume, scene.lighting, camera, settings);
    const CloudLighting::ViewFields fields =
        scene.lighting.contract(scene.volume.transform().index_from_world(camera.position_m));
    settings.fields = &fields;
    Picture sum(camera.width, camera.height);
    std::vector<float> from(sum.radiance.size(), 0.0F);
    std::vector<float> to(sum.radiance.size());
    for (const float edge : {80.0F, 90.0F, 100.0F, 1e6F}) {
        to.assign(to.size(), edge);
        settings.from_m = from;
        settings.scene_depth_m = to;
        const Picture slab = march(scene.volume, scene.lighting, camera, settings);
        const Picture plain = march_scalar(scene.volume, scene.lighting, camera, settings);
        for (std::size_t i = 0; i < sum.radiance.size(); ++i) {
            ASSERT_NEAR(slab.transmittance[i], plain.transmittance[i], 1e-4F);
            if (slab.depth_m[i] > 0.0F) {
                ASSERT_GE(slab.depth_m[i], from[i]);
                ASSERT_LE(slab.depth_m[i], to[i]);
            }
            sum.radiance[i] += sum.transmittance[i] * slab.radiance[i];
            sum.transmittance[i] *= slab.transmittance[i];
        }
        from = to;
    }
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < sum.radiance.size(); ++i) {
        error += std::pow(double(sum.radiance[i].y - whole.radiance[i].y), 2.0);
        norm += std::pow(double(whole.radiance[i].y), 2.0);
        EXPECT_NEAR(sum.transmittance[i], whole.transmittance[i], 0.02F); // steps are cut at the edges
    }
    EXPECT_LT(std::sqrt(error / norm), 0.005);
}

TEST(CloudMarch, StepsConverge) {
    const Scene scene;
    const Camera camera = look_at({-50, -40, 60}, {20, 20, 20}, 0.35F, 32, 20);
    MarchSettings settings;
    settings.step_voxels = 0.125F;
    const Picture fine = march(scene.volume, scene.lighting, camera, settings);
    double last = 1e9;
    for (const float step : {2.0F, 1.0F, 0.5F}) {
        settings.step_voxels = step;
        const Picture picture = march(scene.volume, scene.lighting, camera, settings);
        double error = 0.0;
        double norm = 0.0;
        for (std::size_t i = 0; i < fine.radiance.size(); ++i) {
            error += std::pow(double(picture.radiance[i].y - fine.radiance[i].y), 2.0);
            norm += std::pow(double(fine.radiance[i].y), 2.0);
        }
        error = std::sqrt(error / norm);
        EXPECT_LT(error, step >= 2.0F ? 0.05 : 0.02) << step;
        EXPECT_LT(error, last);
        last = error;
    }
    settings.step_voxels = 1.0F;
    settings.optical_step = 0.5F; // longer steps where little is seen any more
    const Picture longer = march(scene.volume, scene.lighting, camera, settings);
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < fine.radiance.size(); ++i) {
        error += std::pow(double(longer.radiance[i].y - fine.radiance[i].y), 2.0);
        norm += std::pow(double(fine.radiance[i].y), 2.0);
    }
    EXPECT_LT(std::sqrt(error / norm), 0.03);
}

TEST(CloudMarch, OpaqueThingsHideWhatIsBehindThem) {
    const Scene scene;
    const Camera camera = look_at({20, -100, 20}, {20, 20, 20}, 0.3F, 20, 20);
    const Picture open = march(scene.volume, scene.lighting, camera);
    std::vector<float> depth(400, 50.0F); // a wall before the cloud
    MarchSettings settings;
    settings.scene_depth_m = depth;
    const Picture hidden = march(scene.volume, scene.lighting, camera, settings);
    depth.assign(400, 120.0F); // through its middle
    const Picture half = march(scene.volume, scene.lighting, camera, settings);
    depth.assign(400, 1e6F);
    const Picture behind = march(scene.volume, scene.lighting, camera, settings);
    for (std::size_t i = 0; i < 400; ++i) {
        EXPECT_EQ(hidden.transmittance[i], 1.0F);
        EXPECT_EQ(hidden.radiance[i].x, 0.0F);
        EXPECT_GE(half.transmittance[i], open.transmittance[i] - 1e-6F);
        EXPECT_LE(half.depth_m[i], 120.0F);
        EXPECT_EQ(behind.radiance[i], open.radiance[i]);
    }
}

TEST(CloudMarch, ThreadsDoNotMatter) {
    const Scene scene;
    const Camera camera = look_at({-50, -40, 60}, {20, 20, 20}, 0.35F, 33, 17);
    MarchSettings settings;
    settings.threads = 1;
    const Picture a = march(scene.volume, scene.lighting, camera, settings);
    settings.threads = 3;
    const Picture b = march(scene.volume, scene.lighting, camera, settings);
    EXPECT_EQ(a.radiance, b.radiance);
}

} // namespace
