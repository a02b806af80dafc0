#include "clouds_test_support.hpp"

#include <fp_traps.hpp>

#include <alpenglow/clouds/compact.hpp>
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
                    const Camera camera = look_at({-30, 9, 9}, {9, 9, 9}, 0.3F, 12, 8);
                    const Picture picture = march(volume, lighting, camera);
                    expect_sound(picture);
                    expect_sound(march(CompactCloud(volume, lighting, camera.position_m), camera));
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
    const SparseGrid tile = test::box_cloud({8, 8, 8}, 0.25F);
    for (const SparseGrid* grid :
         {static_cast<const SparseGrid*>(&one), static_cast<const SparseGrid*>(&wide), &empty, &tile}) {
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
            const Camera camera = look_at({-40, 6, 7}, {5, 6, 7}, 0.1F, 16, 12);
            expect_sound(march(volume, lighting, camera));
            expect_sound(march(CompactCloud(volume, lighting, camera.position_m), camera));
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
            expect_sound(march(CompactCloud(volume, lighting, eye), look_at(eye, target, 0.3F, 16, 9)));
        }
    }
}

TEST_F(CloudStress, DensitiesOfAGridToTheirEnds) {
    // Neighbours of 1e-12 and 1e6, and grids of one of them alone.
    for (const float low : {0.0F, 1e-12F, 1e6F}) {
        SparseGrid grid = test::box_cloud({12, 12, 12}, 1e-12F);
        for (int i = 0; i < 1728; ++i) {
            const int x = i % 12;
            const int y = i / 12 % 12;
            const int z = i / 144;
            const float v = low == 0.0F ? (test::random_at(static_cast<std::uint32_t>(i)) < 0.5F ? 1e-12F : 1e6F) : low;
            grid.brick(x >> 3, y >> 3, z >> 3)[((z & 7) * 8 + (y & 7)) * 8 + (x & 7)] = v;
        }
        const BrickVolume volume(grid);
        for (const LightingMethod method : methods) {
            LightingSettings settings;
            settings.method = method;
            CloudLighting lighting;
            lighting.reset(volume, {1.0F, 0.99F, {}}, settings);
            lighting.bake_light(0, {test::unit({0.3F, 0.2F, 0.9F}), glm::vec3(1.0F), 0.0F});
            lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)));
            for (const glm::dvec3& eye : {glm::dvec3(-30, 5, 6), glm::dvec3(6, 6, 6)}) {
                const Camera camera = look_at(eye, eye + glm::dvec3(1, 0.1, 0), 0.3F, 12, 8);
                expect_sound(march(volume, lighting, camera));
                expect_sound(march(CompactCloud(volume, lighting, eye), camera));
            }
        }
    }
}

TEST_F(CloudStress, SunsInTheEyeAndBehindIt) {
    // Exactly along the view and exactly against it, at every peak; a turned and mirrored grid.
    SparseGrid grid = noise_cloud(64, 20);
    GridTransform transform;
    transform.voxel_m = {1.0, 2.0, 0.5};
    transform.axes = glm::dmat3(glm::dvec3(0.6, 0.8, 0.0), glm::dvec3(0.8, -0.6, 0.0), glm::dvec3(0.0, 0.0, -1.0));
    transform.origin_m = {-300.0, 1e5, 2.0};
    grid.set_transform(transform);
    const BrickVolume volume(grid);
    const glm::dvec3 centre = transform.world_from_index({10, 10, 10});
    const glm::vec3 view = test::unit({0.36F, 0.48F, 0.8F});
    for (const float g : {-0.9999F, -0.5F, 0.0F, 0.85F, 0.9999F}) {
        for (const LightingMethod method : methods) {
            LightingSettings settings;
            settings.method = method;
            CloudLighting lighting;
            lighting.reset(volume, {0.2F, 1.0F, {PhaseKind::henyey_greenstein, g, 0, 0}}, settings);
            lighting.bake_light(0, {view, glm::vec3(1.0F), 0.0F});
            lighting.bake_light(1, {-view, glm::vec3(1.0F), 0.0F});
            Camera camera = look_at(centre - 60.0 * glm::dvec3(view), centre, 0.3F, 15, 9);
            expect_sound(march(volume, lighting, camera));
            expect_sound(march(CompactCloud(volume, lighting, camera.position_m), camera));
        }
    }
}

TEST_F(CloudStress, TwoHundredCloudsInOnePicture) {
    const BrickVolume volume(noise_cloud(65, 16));
    CloudLighting lighting;
    lighting.reset(volume, {0.3F, 0.99F, {}}, {});
    lighting.bake_light(0, {test::unit({0.3F, 0.2F, 0.9F}), glm::vec3(1.0F), 0.0F});
    std::vector<LitCloud> clouds;
    for (std::uint32_t i = 0; i < 200; ++i) {
        const glm::dvec3 at(test::random_at(3 * i), test::random_at(3 * i + 1), test::random_at(3 * i + 2));
        clouds.push_back({&volume, &lighting, (at - 0.5) * 400.0});
    }
    for (const glm::dvec3& eye : {glm::dvec3(0.0), glm::dvec3(-900.0, 10.0, 40.0)}) {
        const Picture picture = march(clouds, look_at(eye, {8, 8, 8}, 0.4F, 24, 16));
        expect_sound(picture);
        EXPECT_LT(*std::min_element(picture.transmittance.begin(), picture.transmittance.end()), 0.9F);
    }
}

TEST_F(CloudStress, EnergyIsNeverMade) {
    // Sky of radiance 1 and no absorption: whatever the cell's optical thickness, nothing is brighter or darker than 1.
    const SparseGrid box = test::box_cloud({20, 20, 20}, 1.0F);
    const BrickVolume volume(box);
    for (float extinction = 1e-8F; extinction < 2e4F; extinction *= 10.0F) {
        for (const float g : {-0.9F, 0.0F, 0.95F, 0.9999F}) {
            for (const int factor : {3, 2, 1}) { // of large clouds, small ones, and the slower level
                LightingSettings settings;
                settings.transport_factor = factor;
                CloudLighting lighting;
                lighting.reset(volume, {extinction, 1.0F, {PhaseKind::henyey_greenstein, g, 0, 0}}, settings);
                lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)));
                const Camera camera = look_at({-40, 30, 20}, {10, 10, 10}, 0.3F, 16, 12);
                const Picture plain = march(volume, lighting, camera);
                const Picture compact = march(CompactCloud(volume, lighting, camera.position_m), camera);
                for (const Picture* picture : {&plain, &compact}) {
                    for (std::size_t i = 0; i < picture->radiance.size(); ++i) {
                        ASSERT_NEAR(picture->radiance[i].x + picture->transmittance[i], 1.0F, 1e-3F)
                            << extinction << " " << g << " " << factor << (picture == &compact ? " compact" : "");
                    }
                }
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
