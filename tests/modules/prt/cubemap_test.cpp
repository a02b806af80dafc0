#include "helpers.hpp"

#include <alpenglow/prt/bake_cubemap.hpp>
#include <alpenglow/prt/shapes.hpp>

#include <gtest/gtest.h>

namespace alpenglow::prt {
namespace {

TEST(Cubemap, AgreesWithRaysAndConverges) {
    const Mesh mesh = merged(plane(2.0F, 8), sphere(0.5F, 4), glm::vec3(0.1F, 0.2F, 0.8F));
    BakeSettings settings;
    settings.sampling = Sampling::fibonacci;
    settings.rays = 16384;
    const Result<Bake> rays = bake(mesh, settings);
    ASSERT_TRUE(rays);
    std::vector<float> cosine(25);
    unshadowed(5, glm::vec3(0.0F, 0.0F, 1.0F), cosine);
    double last = 1.0;
    for (const std::size_t resolution : {8U, 16U, 32U}) {
        const Result<Bake> cubes = bake_cubemap(mesh, settings, resolution);
        ASSERT_TRUE(cubes) << cubes.error().message();
        const double error = test::rms(cubes->field, rays->field, test::norm(cosine));
        EXPECT_LT(error, 0.7 * last);
        last = error;
    }
    EXPECT_LT(last, 0.015);
}

TEST(Cubemap, KeepsTheInvariants) {
    BakeSettings settings;
    settings.gather_rays = 256;
    settings.transport = Transport::interreflected;
    const Mesh convex = sphere(1.0F, 4);
    const Result<Bake> open = bake_cubemap(convex, settings, 16);
    ASSERT_TRUE(open);
    std::vector<float> cosine(25);
    for (std::size_t i = 0; i < convex.positions.size(); ++i) {
        unshadowed(5, convex.normals[i], cosine);
        EXPECT_LT(test::distance(open->field.point(i), cosine), 1e-6);
    }
    const Result<Bake> closed = bake_cubemap(inverted(sphere(1.0F, 5)), settings, 16);
    ASSERT_TRUE(closed);
    EXPECT_EQ(test::norm(closed->field.values), 0.0);

    Mesh mesh = bowl(1.0F, 32, 12);
    mesh.albedo.assign(mesh.positions.size(), glm::vec3(1.0F));
    settings.max_bounces = 200;
    settings.stop_energy = 1e-7;
    const Result<Bake> furnace = bake_cubemap(mesh, settings, 32);
    ASSERT_TRUE(furnace);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        // The closed form of the unblocked part and the cube's texels differ by a little: visible light is the rest.
        EXPECT_NEAR(test::white(furnace->field.point(i)), 1.0, 0.02);
    }
}

TEST(Cubemap, RefusesWhatItCannotDo) {
    Mesh mesh = plane(1.0F, 2);
    EXPECT_FALSE(bake_cubemap(mesh, {}, 1));
    EXPECT_FALSE(bake_cubemap(Mesh{}, {}));
    mesh.mirror.assign(mesh.triangles.size(), 1);
    EXPECT_FALSE(bake_cubemap(mesh, {}));
}

} // namespace
} // namespace alpenglow::prt
