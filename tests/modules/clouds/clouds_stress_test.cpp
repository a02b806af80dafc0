#include "clouds_test_support.hpp"

#include <fp_traps.hpp>

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/reference.hpp>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

class CloudStress : public test::StressTest {};

void expect_sound(const Picture& picture) {
    for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            ASSERT_TRUE(std::isfinite(picture.radiance[i][k]));
            ASSERT_GE(picture.radiance[i][k], 0.0F);
        }
        ASSERT_GE(picture.transmittance[i], 0.0F);
        ASSERT_LE(picture.transmittance[i], 1.0F);
        ASSERT_TRUE(std::isfinite(picture.depth_m[i]));
    }
}

constexpr LightingMethod methods[] = {LightingMethod::single_scattering, LightingMethod::harris,
                                      LightingMethod::octaves, LightingMethod::transport};

TEST_F(CloudStress, DensitiesAlbedosAndPhasesToTheirEnds) {
    const SparseGrid grid = noise_cloud(61, 18);
    const BrickVolume volume(grid);
    for (const LightingMethod method : methods) {
        LightingSettings settings;
        settings.method = method;
        for (const float extinction : {1e-12F, 1e-8F, 1.0F, 1e2F, 1e6F}) {
            for (const float albedo : {0.0F, 0.5F, 1.0F}) {
                for (const float g : {-0.9999F, 0.0F, 0.95F, 0.9999F}) {
                    CloudLighting lighting;
                    lighting.reset(volume, {extinction, albedo, {PhaseKind::henyey_greenstein, g, 0, 0}}, settings);
                    lighting.bake_light(0, {test::unit({0.1F, 0.2F, 0.9F}), glm::vec3(1.0F), 0.0F});
                    lighting.bake_sky(SkySh::uniform(glm::vec3(0.5F)));
                    const Picture picture = march(volume, lighting, look_at({-30, 9, 9}, {9, 9, 9}, 0.3F, 12, 8));
                    expect_sound(picture);
                    if (albedo == 0.0F) {
                        for (const glm::vec3& c : picture.radiance) {
                            ASSERT_LT(c.x, 1e-5F);
                        }
                    }
                }
            }
        }
    }
}

TEST_F(CloudStress, EmptyOneVoxelAndSparseClouds) {
    SparseGrid one({5, 6, 7}, {1, 1, 1}, {});
    one.brick(0, 0, 0)[(7 * 8 + 6) * 8 + 5] = 1.0F;
    SparseGrid wide({-1000, -1000, -1000}, {2000, 2000, 2000}, {});
    wide.brick(0, 0, 0)[0] = 1.0F;
    wide.brick(249, 249, 249)[511] = 1.0F;
    wide.brick(125, 125, 125)[9] = 1.0F;
    const SparseGrid empty({0, 0, 0}, {0, 0, 0}, {});
    for (const SparseGrid* grid :
         {static_cast<const SparseGrid*>(&one), static_cast<const SparseGrid*>(&wide), &empty}) {
        const BrickVolume volume(*grid);
        for (const LightingMethod method : methods) {
            LightingSettings settings;
            settings.method = method;
            settings.max_depth_cells = 1 << 16;
            settings.max_transport_cells = 1 << 14;
            CloudLighting lighting;
            lighting.reset(volume, {1.0F, 0.99F, {}}, settings);
            lighting.bake_light(0, {{0, 0, 1}, glm::vec3(1.0F), 0.0F});
            lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)));
            expect_sound(march(volume, lighting, look_at({-40, 6, 7}, {5, 6, 7}, 0.1F, 16, 12)));
        }
        ReferenceScene scene;
        scene.grid = grid;
        scene.lights = {{{0, 0, 1}, glm::vec3(1.0F), 0.0F}};
        ReferenceImage image(8, 6);
        PathTracer(std::move(scene)).render(look_at({-40, 6, 7}, {5, 6, 7}, 0.1F, 8, 6), image, 0, 2);
        for (std::size_t i = 0; i < image.squares.size(); ++i) {
            ASSERT_TRUE(std::isfinite(image.mean(i).x));
        }
    }
}

TEST_F(CloudStress, AwkwardEyesAndSuns) {
    SparseGrid grid = noise_cloud(62, 24);
    GridTransform transform;
    transform.voxel_m = {0.5, 40.0, 3.0};
    grid.set_transform(transform);
    const BrickVolume volume(grid);
    const glm::dvec3 centre = transform.world_from_index({12, 12, 12});
    for (const LightingMethod method : methods) {
        LightingSettings settings;
        settings.method = method;
        CloudLighting lighting;
        lighting.reset(volume, {0.05F, 0.999F, {}}, settings);
        const glm::vec3 suns[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.70710678F, 0.70710678F, 0.0F}};
        for (std::size_t i = 0; i < 5; ++i) {
            lighting.bake_light(i, {suns[i], glm::vec3(1.0F), 0.0F});
        }
        // Inside, far away, along an axis, at a corner, straight down.
        const glm::dvec3 eyes[] = {centre,
                                   centre + glm::dvec3(1e7, 0, 0),
                                   centre + glm::dvec3(0, 0, 300),
                                   {0, 0, 0},
                                   centre + glm::dvec3(0, 2000, 0)};
        for (const glm::dvec3& eye : eyes) {
            const glm::dvec3 target = eye == centre ? centre + glm::dvec3(1, 0, 0) : centre;
            expect_sound(march(volume, lighting, look_at(eye, target, 0.3F, 16, 9)));
        }
    }
}

TEST_F(CloudStress, EnergyIsNeverMade) {
    // Sky of radiance 1 and no absorption: whatever the cell's optical thickness, nothing is brighter or darker than 1.
    const SparseGrid box = test::box_cloud({20, 20, 20}, 1.0F);
    const BrickVolume volume(box);
    for (float extinction = 1e-8F; extinction < 2e4F; extinction *= 10.0F) {
        for (const float g : {-0.9F, 0.0F, 0.95F, 0.9999F}) {
            CloudLighting lighting;
            lighting.reset(volume, {extinction, 1.0F, {PhaseKind::henyey_greenstein, g, 0, 0}}, {});
            lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)));
            const Picture picture = march(volume, lighting, look_at({-40, 30, 20}, {10, 10, 10}, 0.3F, 16, 12));
            for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
                ASSERT_NEAR(picture.radiance[i].x + picture.transmittance[i], 1.0F, 1e-3F) << extinction << " " << g;
            }
        }
    }
}

TEST_F(CloudStress, TheTracerTakesEveryMedium) {
    const SparseGrid grid = noise_cloud(63, 16);
    for (const float extinction : {1e-12F, 1e-3F, 1.0F, 1e3F}) {
        for (const float albedo : {0.0F, 0.9F}) {
            for (const float g : {-0.9999F, 0.0F, 0.9999F}) {
                ReferenceScene scene;
                scene.grid = &grid;
                scene.medium = {extinction, albedo, {PhaseKind::henyey_greenstein, g, 0, 0}};
                scene.lights = {{{0, 0, 1}, glm::vec3(1.0F), 0.004F}};
                scene.sky = [](const glm::vec3&) { return glm::vec3(1.0F); };
                ReferenceImage image(8, 6);
                PathTracer(std::move(scene)).render(look_at({-20, 8, 8}, {8, 8, 8}, 0.4F, 8, 6), image, 0, 4);
                for (std::size_t i = 0; i < image.squares.size(); ++i) {
                    ASSERT_TRUE(std::isfinite(image.mean(i).x));
                }
            }
        }
    }
}

} // namespace
