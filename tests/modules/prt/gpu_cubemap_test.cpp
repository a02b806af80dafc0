// Cube maps drawn by a device: as the CPU draws them, and as near to the ray-traced bake.
#include "gpu_test.hpp"
#include "helpers.hpp"

#include <alpenglow/prt/bake_cubemap_vulkan.hpp>
#include <alpenglow/prt/shapes.hpp>

namespace alpenglow::vulkan {
namespace {

using CubemapGpu = GpuTest;

TEST_F(CubemapGpu, AgreesWithTheCpuAndWithRays) {
    const prt::Mesh mesh = prt::merged(prt::plane(2.0F, 8), prt::sphere(0.5F, 4), glm::vec3(0.1F, 0.2F, 0.8F));
    prt::BakeSettings settings;
    settings.sampling = prt::Sampling::fibonacci;
    settings.rays = 16384;
    const Result<prt::Bake> rays = prt::bake(mesh, settings);
    ASSERT_TRUE(rays);
    std::vector<float> cosine(25);
    prt::unshadowed(5, glm::vec3(0.0F, 0.0F, 1.0F), cosine);
    const double one = prt::test::norm(cosine);
    double last = 1.0;
    for (const std::size_t resolution : {8U, 16U, 32U}) {
        const Result<prt::Bake> cpu = prt::bake_cubemap(mesh, settings, resolution);
        const Result<prt::Bake> gpu = prt::bake_cubemap(*device, mesh, settings, resolution);
        ASSERT_TRUE(cpu);
        ASSERT_TRUE(gpu) << gpu.error().message();
        const double error = prt::test::rms(gpu->field, rays->field, one);
        EXPECT_LT(error, 0.7 * last);
        EXPECT_NEAR(error, prt::test::rms(cpu->field, rays->field, one), 0.15 * error);
        EXPECT_LT(prt::test::rms(gpu->field, cpu->field, one), 0.5 * error);
        RecordProperty("rms_" + std::to_string(resolution), std::to_string(error));
        last = error;
    }
    EXPECT_LT(last, 0.015);
}

TEST_F(CubemapGpu, BouncesAndInvariants) {
    prt::BakeSettings settings;
    settings.gather_rays = 256;
    settings.transport = prt::Transport::interreflected;
    const Result<prt::Bake> closed = prt::bake_cubemap(*device, prt::inverted(prt::sphere(1.0F, 5)), settings, 16);
    ASSERT_TRUE(closed) << closed.error().message();
    EXPECT_EQ(prt::test::norm(closed->field.values), 0.0);
    prt::Mesh bowl = prt::bowl(1.0F, 24, 8);
    bowl.albedo.assign(bowl.positions.size(), glm::vec3(1.0F));
    settings.max_bounces = 200;
    settings.stop_energy = 1e-7;
    const Result<prt::Bake> furnace = prt::bake_cubemap(*device, bowl, settings, 32);
    ASSERT_TRUE(furnace);
    for (std::size_t i = 0; i < bowl.positions.size(); ++i) {
        EXPECT_NEAR(prt::test::white(furnace->field.point(i)), 1.0, 0.02);
    }
}

TEST_F(CubemapGpu, RefusesWhatItCannotDo) {
    EXPECT_FALSE(prt::bake_cubemap(*device, prt::plane(1.0F, 2), {}, 1));
    EXPECT_FALSE(prt::bake_cubemap(*device, prt::Mesh{}, {}));
}

} // namespace
} // namespace alpenglow::vulkan
