#include "clouds_test_support.hpp"

#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/reference.hpp>
#include <alpenglow/core/constants.hpp>

#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

Camera camera_at(const SparseGrid& grid, const glm::dvec3& direction, int width = 24, int height = 16) {
    const BrickVolume volume(grid);
    const glm::dvec3 centre =
        grid.transform().world_from_index(glm::dvec3(volume.active_low() + volume.active_high()) * 0.5);
    const glm::dvec3 size = glm::dvec3(volume.active_high() - volume.active_low()) * grid.transform().voxel_m;
    return look_at(centre + direction * (2.2 * std::max({size.x, size.y, size.z})), centre, 0.32F, width, height);
}

TEST(CloudReference, TransmittanceThroughASlabIsExponential) {
    // Trilinear interpolation rises and falls over one voxel outside the box: a ray through the middle sees 16 voxels'
    // worth.
    GridTransform transform;
    transform.voxel_m = {2.0, 3.0, 0.5};
    const SparseGrid grid = test::box_cloud({16, 16, 16}, 0.4F, transform);
    ReferenceScene scene;
    scene.grid = &grid;
    scene.medium.extinction_per_m = 0.3F;
    const PathTracer tracer(std::move(scene));
    const double tau = 0.3 * 0.4 * 16 * 0.5;
    EXPECT_NEAR(tracer.transmittance({15.0, 22.0, -10.0}, {0, 0, 1}, 40000), std::exp(-tau), 4e-3);
    const double across = 0.3 * 0.4 * 16 * 2.0;
    EXPECT_NEAR(tracer.transmittance({-10.0, 22.0, 4.0}, {1, 0, 0}, 40000), std::exp(-across), 6e-3);
}

TEST(CloudReference, SingleScatteringAgreesWithTheDeterministicMarch) {
    const SparseGrid grid = noise_cloud(21, 20);
    for (const PhaseKind kind :
         {PhaseKind::henyey_greenstein, PhaseKind::double_henyey_greenstein, PhaseKind::cornette_shanks}) {
        const Medium medium{0.4F, 0.9F, {kind, 0.5F, -0.2F, 0.7F}};
        const DirectionalLight light{test::unit({0.3F, 0.5F, 0.7F}), glm::vec3(2.0F, 1.0F, 0.5F), 0.0F};
        ReferenceScene scene;
        scene.grid = &grid;
        scene.medium = medium;
        scene.lights = {light};
        scene.max_scatterings = 1;
        const Camera camera = camera_at(grid, {-0.6, -0.8, 0.1});
        ReferenceImage truth(camera.width, camera.height);
        PathTracer(std::move(scene)).render(camera, truth, 0, 2048);
        const BrickVolume volume(grid);
        CloudLighting lighting;
        LightingSettings settings;
        settings.method = LightingMethod::single_scattering;
        lighting.reset(volume, medium, settings);
        lighting.bake_light(0, light);
        Camera fine = camera;
        fine.width *= 4;
        fine.height *= 4;
        MarchSettings march_settings;
        march_settings.step_voxels = 0.25F;
        const Picture picture = march(volume, lighting, fine, march_settings);
        glm::dvec3 sum(0.0);
        glm::dvec3 expected(0.0);
        for (const glm::vec3& c : picture.radiance) {
            sum += glm::dvec3(c) / 16.0;
        }
        for (std::size_t i = 0; i < truth.squares.size(); ++i) {
            expected += truth.mean(i);
        }
        // Light columns blur the density by up to a voxel, and this cloud is all detail.
        EXPECT_NEAR(sum.x / expected.x, 1.0, 0.02);
        EXPECT_NEAR(sum.z / expected.z, 1.0, 0.02);
    }
}

TEST(CloudReference, AWhiteFurnaceStaysWhite) {
    const SparseGrid grid = noise_cloud(22, 24);
    for (const float g : {0.0F, 0.85F, -0.5F}) {
        ReferenceScene scene;
        scene.grid = &grid;
        scene.medium = {2.0F, 1.0F, {PhaseKind::henyey_greenstein, g, 0, 0}};
        scene.sky = [](const glm::vec3&) { return glm::vec3(3.0F); };
        const Camera camera = camera_at(grid, {0.0, -1.0, 0.0}, 8, 6);
        ReferenceImage image(8, 6);
        PathTracer(std::move(scene)).render(camera, image, 0, 16);
        for (std::size_t i = 0; i < image.squares.size(); ++i) {
            EXPECT_NEAR(image.mean(i).y, 3.0, 1e-4); // every single path carries exactly the sky's radiance
        }
    }
}

TEST(CloudReference, LightAndEyeCanBeSwapped) {
    // Power scattered towards -b out of a beam from a equals that towards -a out of one from b: mean radiance over a
    // window across the ray that contains the whole cloud.
    const SparseGrid grid = noise_cloud(23, 20);
    const glm::vec3 a = test::unit({0.2F, 0.9F, 0.4F});
    const glm::vec3 b = test::unit({-0.7F, 0.1F, -0.6F});
    const auto power = [&](const glm::vec3& eye, const glm::vec3& light) {
        ReferenceScene scene;
        scene.grid = &grid;
        scene.medium = {0.5F, 0.95F, {PhaseKind::henyey_greenstein, 0.5F, 0, 0}};
        scene.lights = {{light, glm::vec3(1.0F), 0.0F}};
        const PathTracer tracer(std::move(scene));
        const Camera frame = look_at({0, 0, 0}, -glm::dvec3(eye), 1.0F, 1, 1);
        double sum = 0.0;
        double squares = 0.0;
        const int n = 40000;
        for (int i = 0; i < n; ++i) {
            const double u = 40.0 * (double(test::random_at(2 * std::uint32_t(i))) - 0.5);
            const double v = 40.0 * (double(test::random_at(2 * std::uint32_t(i) + 1)) - 0.5);
            const glm::dvec3 origin =
                glm::dvec3(9.5) + glm::dvec3(eye) * 60.0 + glm::dvec3(frame.right) * u + glm::dvec3(frame.up) * v;
            const double l = tracer.radiance(origin, -eye, 1, std::uint64_t(i) + 7).x;
            sum += l;
            squares += l * l;
        }
        return std::pair(sum / n, std::sqrt(squares) / n);
    };
    const auto [forth, error1] = power(a, b);
    const auto [back, error2] = power(b, a);
    EXPECT_NEAR(forth, back, 4.0 * std::hypot(error1, error2));
    EXPECT_LT(error1, 0.03 * forth);
}

TEST(CloudReference, ADiscOfSunAveragesOverItsDirections) {
    // Irradiance is kept whatever the radius; a wide sun softens the picture but not its sum for isotropic scattering.
    const SparseGrid grid = noise_cloud(24, 16);
    double sums[2];
    for (int i = 0; i < 2; ++i) {
        ReferenceScene scene;
        scene.grid = &grid;
        scene.medium = {0.05F, 0.9F, {PhaseKind::henyey_greenstein, 0.0F, 0, 0}};
        scene.lights = {{test::unit({0.2F, -0.4F, 0.9F}), glm::vec3(1.0F), i == 0 ? 0.0F : 0.1F}};
        const Camera camera = camera_at(grid, {1.0, 0.0, 0.0});
        ReferenceImage image(camera.width, camera.height);
        PathTracer(std::move(scene)).render(camera, image, 0, 512);
        sums[i] = 0.0;
        for (std::size_t p = 0; p < image.squares.size(); ++p) {
            sums[i] += image.mean(p).x;
        }
    }
    EXPECT_NEAR(sums[1] / sums[0], 1.0, 0.02);
}

TEST(CloudReference, GroundSendsLightUp) {
    // Without matter, a ray to a sunlit white plane sees albedo E cos / pi.
    const SparseGrid grid = test::box_cloud({8, 8, 8}, 1e-6F);
    ReferenceScene scene;
    scene.grid = &grid;
    scene.medium.extinction_per_m = 1e-6F;
    scene.lights = {{test::unit({0.0F, 0.6F, 0.8F}), glm::vec3(5.0F), 0.0F}};
    scene.ground = {true, -20.0, glm::vec3(0.5F)};
    const PathTracer tracer(std::move(scene));
    EXPECT_NEAR(tracer.radiance({3.0, 3.0, 30.0}, {0, 0, -1}, 16).x, 0.5 * 5.0 * 0.8 / pi, 1e-4);
}

TEST(CloudReference, SamplesDoNotDependOnThreadsShardsOrStops) {
    const SparseGrid grid = noise_cloud(25, 16);
    ReferenceScene scene;
    scene.grid = &grid;
    scene.medium = {0.5F, 0.99F, {}};
    scene.lights = {{{0, 0, 1}, glm::vec3(1.0F), 0.0F}};
    const PathTracer tracer(std::move(scene));
    const Camera camera = camera_at(grid, {0.0, 1.0, 0.2}, 12, 8);
    ReferenceImage one(12, 8);
    ReferenceImage three(12, 8);
    ReferenceImage parts(12, 8);
    tracer.render(camera, one, 0, 8, 1, 1, 1);
    tracer.render(camera, three, 0, 8, 1, 1, 3);
    tracer.render(camera, parts, 0, 4);
    tracer.render(camera, parts, 4, 4);
    ReferenceImage even(12, 8);
    ReferenceImage odd(12, 8);
    tracer.render(camera, even, 0, 4, 2);
    tracer.render(camera, odd, 1, 4, 2);
    const auto merged = merge(even, odd, "odd");
    ASSERT_TRUE(merged);
    EXPECT_EQ(merged->samples(), 8U);
    for (std::size_t i = 0; i < one.squares.size(); ++i) {
        ASSERT_EQ(one.mean(i), three.mean(i));
        ASSERT_NEAR(one.mean(i).x, parts.mean(i).x, 1e-12);
        ASSERT_NEAR(one.mean(i).x, merged->mean(i).x, 1e-12);
    }
    EXPECT_FALSE(merge(one, ReferenceImage(4, 4), "small.ref"));

    const std::string path = ::testing::TempDir() + "/alpenglow_clouds_reference.ref";
    ASSERT_TRUE(save_reference(path, {one, "a note", 8}));
    const auto loaded = load_reference(path);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->note, "a note");
    EXPECT_EQ(loaded->next_sample, 8U);
    EXPECT_EQ(loaded->image.mean(50), one.mean(50));
    std::ofstream(path, std::ios::binary) << "short";
    EXPECT_NE(load_reference(path).error().message().find("no reference picture"), std::string::npos);
    EXPECT_NE(load_reference(path + "x").error().message().find("no such file"), std::string::npos);
}

TEST(CloudReference, ErrorAgainstItselfIsItsNoiseOnly) {
    // Exact pictures measured against noisy references: the halves' product keeps the noise out.
    ReferenceImage reference(40, 40);
    std::vector<glm::vec3> exact;
    for (std::size_t i = 0; i < 1600; ++i) {
        exact.emplace_back(1.0F + test::random_at(std::uint32_t(i)));
        for (int half = 0; half < 2; ++half) {
            const float noise = test::random_at(std::uint32_t(7000 + 2 * i) + std::uint32_t(half)) - 0.5F;
            reference.sum[half][i] = glm::dvec3(exact.back() + noise);
        }
    }
    reference.samples_of[0] = reference.samples_of[1] = 1;
    const std::vector<bool> mask(1600, true);
    EXPECT_LT(image_error(exact, reference, mask).relative_rmse, 0.06); // naive: 0.13
    std::vector<glm::vec3> off = exact;
    for (glm::vec3& c : off) {
        c *= 1.3F;
    }
    EXPECT_NEAR(image_error(off, reference, mask).relative_rmse, 0.3, 0.01);
    EXPECT_NEAR(image_error(off, reference, mask).bias, 0.3, 0.01);
}

} // namespace
