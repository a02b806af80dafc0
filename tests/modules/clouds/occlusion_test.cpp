#include "clouds_test_support.hpp"

#include <alpenglow/clouds/occlusion.hpp>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

TEST(CloudOcclusion, ShadowsFallWhereAMarchSaysTheyDo) {
    SparseGrid grid = noise_cloud(91, 32);
    GridTransform transform;
    transform.voxel_m = {20.0, 20.0, 15.0};
    transform.origin_m = {0.0, 0.0, 1500.0};
    grid.set_transform(transform);
    const BrickVolume volume(grid);
    const Medium medium{0.05F, 0.99F, {}};
    for (const glm::vec3& to_sun :
         {test::unit({0.3F, 0.2F, 0.9F}), test::unit({0.9F, -0.2F, 0.3F}), glm::vec3(0, 0, 1)}) {
        CloudLighting lighting;
        lighting.reset(volume, medium, {});
        lighting.bake_light(0, {to_sun, glm::vec3(1.0F), 0.0F});
        const CloudShadow shadow(volume, lighting, 0, 1);
        const double scaled = double(lighting.eye_extinction()) * 0.05;
        double error = 0.0;
        int n = 0;
        int dark = 0;
        for (std::uint32_t i = 0; i < 800; ++i) {
            // On the ground around the cloud's shadow, inside it, and above it.
            const double z = i % 4 == 0 ? 1500.0 + 480.0 * double(test::random_at(7 * i))
                                        : (i % 4 == 1 ? 2500.0 : -100.0 * double(test::random_at(3 * i)));
            const double far = (1700.0 - z) / double(to_sun.z);
            const glm::dvec3 p = glm::dvec3(320.0, 320.0, 0.0) - glm::dvec3(to_sun) * far * (i % 4 == 1 ? 0.0 : 1.0) +
                                 glm::dvec3(900.0 * (double(test::random_at(2 * i)) - 0.5),
                                            900.0 * (double(test::random_at(2 * i + 1)) - 0.5), 0.0);
            const glm::dvec3 point(p.x, p.y, z);
            const double depth = scaled * marched_depth(volume, transform.index_from_world(point), to_sun, 0.25);
            const auto t = double(shadow.transmittance(point));
            ASSERT_GE(t, 0.0);
            ASSERT_LE(t, 1.0);
            if (i % 4 == 1) {
                ASSERT_EQ(t, 1.0);
            }
            dark += std::exp(-depth) < 0.5 ? 1 : 0;
            error += std::pow(t - std::exp(-depth), 2.0);
            ++n;
        }
        EXPECT_LT(std::sqrt(error / n), 0.02) << to_sun.x;
        EXPECT_GT(dark, 60);
    }
}

TEST(CloudOcclusion, ProbesSeeTheSkyThatCloudsLeave) {
    const SparseGrid grid = test::box_cloud({40, 40, 8});
    const BrickVolume volume(grid);
    CloudLighting lighting;
    lighting.reset(volume, {5.0F, 1.0F, {}}, {});
    lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)));
    const LitCloud cloud{&volume, &lighting, glm::dvec3(0.0)};
    // Far away nothing is hidden; close below, half the sphere; and a white cloud in a white sky is no change at all.
    const CloudEnvironment far = cloud_environment(std::vector<LitCloud>{cloud}, {0, 0, -5000});
    EXPECT_NEAR(far.transmittance[0], 3.5449F, 0.02F);
    const CloudEnvironment below = cloud_environment(std::vector<LitCloud>{cloud}, {20, 20, -2});
    EXPECT_NEAR(below.transmittance[0], 0.5F * 3.5449F, 0.25F);
    EXPECT_LT(below.transmittance[2], -1.0F); // the sky is left below
    const CloudEnvironment moved =
        cloud_environment(std::vector<LitCloud>{{&volume, &lighting, glm::dvec3(0, 0, 1000)}}, {20, 20, 998});
    EXPECT_NEAR(moved.transmittance[0], below.transmittance[0], 1e-3F);
    const SkySh white =
        sky_behind_clouds(SkySh::uniform(glm::vec3(1.0F)), std::vector<LitCloud>{cloud, cloud}, {20, 20, -2});
    EXPECT_NEAR(white.coefficients[0].x, 3.5449F, 0.02F);
    EXPECT_NEAR(white.coefficients[2].x, 0.0F, 0.02F);
}

} // namespace
