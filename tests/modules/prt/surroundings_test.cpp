// Volumes, neighbourhoods, texels, bent normals.
#include "helpers.hpp"

#include <alpenglow/prt/bake_neighbourhood.hpp>
#include <alpenglow/prt/bake_volume.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/neighbourhood.hpp>
#include <alpenglow/prt/shapes.hpp>
#include <alpenglow/prt/texels.hpp>

#include <gtest/gtest.h>

#include <limits>

#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {

VolumeDensity ball(unsigned size, float radius_m, float extinction) {
    VolumeDensity density;
    const float step = 2.2F * radius_m / static_cast<float>(size - 1);
    density.grid = {glm::uvec3(size), glm::vec3(-1.1F * radius_m), glm::vec3(step)};
    for (unsigned z = 0; z < size; ++z) {
        for (unsigned y = 0; y < size; ++y) {
            for (unsigned x = 0; x < size; ++x) {
                const glm::vec3 p = density.grid.origin_m + step * glm::vec3(x, y, z);
                density.extinction_per_m.push_back(glm::length(p) <= radius_m ? extinction : 0.0F);
            }
        }
    }
    return density;
}

TEST(BakeVolume, CentreOfABallIsAttenuatedByItsRadius) {
    const VolumeDensity density = ball(21, 1.0F, 1.5F);
    VolumeSettings settings;
    settings.max_bounces = 0;
    settings.order = 3;
    const Result<Bake> baked = bake_volume(density, settings);
    ASSERT_TRUE(baked) << baked.error().message();
    const std::size_t centre = 10 + 21 * (10 + 21 * 10);
    // The staircase of the voxels moves the surface by a part of a cell, 0.11 m.
    EXPECT_NEAR(test::white(baked->field.point(centre)), std::exp(-1.5), 0.02);
    for (std::size_t k = 1; k < 9; ++k) {
        EXPECT_NEAR(baked->field.point(centre)[k], 0.0F, 0.005F); // the same from everywhere
    }
    // On the +x side light comes from +x: Y_1^1 is negative there.
    const std::size_t side = 17 + 21 * (10 + 21 * 10);
    EXPECT_LT(baked->field.point(side)[3], -0.02F);
}

TEST(BakeVolume, WhiteFurnace) { // albedo 1: nothing is lost, every point is as bright as the light
    const VolumeDensity density = ball(9, 1.0F, 2.0F);
    VolumeSettings settings;
    settings.order = 1;
    settings.albedo = 1.0F;
    settings.max_bounces = 400;
    settings.stop_energy = 1e-7;
    const Result<Bake> baked = bake_volume(density, settings);
    ASSERT_TRUE(baked);
    for (std::size_t i = 0; i < baked->field.count; ++i) {
        if (density.extinction_per_m[i] > 0.0F) {
            EXPECT_NEAR(test::white(baked->field.point(i)), 1.0, 2e-3);
        }
    }
}

TEST(BakeVolume, ThinAirChangesNothingAndThickSmokeIsDark) {
    VolumeDensity density = ball(9, 1.0F, 1e-7F);
    VolumeSettings settings;
    settings.order = 2;
    const Result<Bake> thin = bake_volume(density, settings);
    ASSERT_TRUE(thin);
    const std::size_t centre = 4 + 9 * (4 + 9 * 4);
    EXPECT_NEAR(test::white(thin->field.point(centre)), 1.0, 1e-4);
    density = ball(9, 1.0F, 1e6F);
    settings.albedo = 0.5F;
    const Result<Bake> thick = bake_volume(density, settings);
    ASSERT_TRUE(thick);
    EXPECT_LT(test::white(thick->field.point(centre)), 1e-3);
}

TEST(BakeVolume, RefusesNonsense) {
    VolumeDensity density = ball(5, 1.0F, 1.0F);
    density.extinction_per_m[7] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(bake_volume(density, {}));
    density.extinction_per_m[7] = -1.0F;
    EXPECT_FALSE(bake_volume(density, {}));
    density = ball(5, 1.0F, 0.0F);
    EXPECT_FALSE(bake_volume(density, {}));
    density = ball(5, 1.0F, 1.0F);
    density.extinction_per_m.pop_back();
    EXPECT_FALSE(bake_volume(density, {}));
}

TEST(BakeNeighbourhood, FarAwayAndFreeIsTheIdentity) {
    const Mesh mesh = sphere(1.0F, 6);
    Grid grid{glm::uvec3(2, 2, 2), glm::vec3(500.0F), glm::vec3(1.0F)};
    NeighbourhoodSettings settings;
    const Result<Bake> baked = bake_neighbourhood(mesh, grid, settings);
    ASSERT_TRUE(baked) << baked.error().message();
    for (std::size_t i = 0; i < 9; ++i) {
        for (std::size_t j = 0; j < 25; ++j) {
            EXPECT_NEAR(baked->field.point(0)[i * 25 + j], i == j ? 1.0F : 0.0F, 2e-3F);
        }
    }
}

TEST(BakeNeighbourhood, ShadowOfABallBelowIt) {
    // White light at distance h below a ball of radius 1: the ball hides (1 - sqrt(1 - 1/h^2)) / 2 of the sphere, and
    // 1/h^2 of the cosine-weighted hemisphere facing it.
    const Mesh mesh = sphere(1.0F, 16);
    const Grid grid{glm::uvec3(9, 9, 9), glm::vec3(-4.0F, -4.0F, -6.0F), glm::vec3(1.0F)};
    NeighbourhoodSettings settings;
    settings.rays = 8192;
    settings.out_order = 5;
    const Result<Bake> baked = bake_neighbourhood(mesh, grid, settings);
    ASSERT_TRUE(baked);
    EXPECT_GT(baked->report.inside_points, 0U);
    const std::size_t below = 4 + 9 * (4 + 9 * 3); // (0, 0, -3)
    const double hidden = 0.5 * (1.0 - std::sqrt(1.0 - 1.0 / 9.0));
    EXPECT_NEAR(baked->field.point(below)[0], 1.0 - hidden, 2e-3);

    const Result<TransferTable> table = encode(baked->field, Encoding::f16);
    ASSERT_TRUE(table);
    std::vector<glm::vec3> light(25, glm::vec3(0.0F));
    light[0] = glm::vec3(std::sqrt(4.0F * 3.14159265F));
    std::vector<glm::vec3> planes(table->info.rows * table->info.count);
    evaluate_matrix(*table, light, planes);
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    const glm::vec3 shadow = sample_neighbourhood(table->info, planes, light, {0.0F, 0.0F, -3.0F}, up);
    EXPECT_NEAR(shadow.x, 1.0F - 1.0F / 9.0F, 0.01F);
    EXPECT_NEAR(sample_neighbourhood(table->info, planes, light, {0.0F, 0.0F, -3.0F}, -up).x, 1.0F, 0.01F);
    // Outside, and at the border, the light is free.
    EXPECT_NEAR(sample_neighbourhood(table->info, planes, light, {0.0F, 0.0F, -60.0F}, up).x, 1.0F, 1e-4F);
    EXPECT_NEAR(sample_neighbourhood(table->info, planes, light, {-4.0F, 0.0F, 0.0F}, up).x, 1.0F, 1e-4F);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NEAR(sample_neighbourhood(table->info, planes, light, {nan, 0.0F, 0.0F}, up).x, 1.0F, 1e-4F);
}

TEST(BakeNeighbourhood, ObjectsSendLightOn) {
    const Mesh mesh = sphere(1.0F, 6);
    const Grid grid{glm::uvec3(2, 2, 2), glm::vec3(1.5F), glm::vec3(0.5F)};
    NeighbourhoodSettings settings;
    const Result<Bake> black = bake_neighbourhood(mesh, grid, settings);
    settings.bounce = true;
    settings.default_albedo = 1.0F;
    const Result<Bake> white = bake_neighbourhood(mesh, grid, settings);
    ASSERT_TRUE(black);
    ASSERT_TRUE(white);
    EXPECT_LT(black->field.point(0)[0], 0.99F);
    EXPECT_NEAR(white->field.point(0)[0], 1.0F, 0.01F); // a white ball in white light cannot be seen
}

TEST(BakeNeighbourhood, RefusesNonsense) {
    NeighbourhoodSettings settings;
    EXPECT_FALSE(bake_neighbourhood(sphere(1.0F, 2), Grid{}, settings));
    const Grid inside{glm::uvec3(2), glm::vec3(-0.1F), glm::vec3(0.1F)};
    const Result<Bake> baked = bake_neighbourhood(sphere(1.0F, 4), inside, settings);
    ASSERT_FALSE(baked);
    EXPECT_NE(baked.error().message().find("inside"), std::string::npos);
}

TEST(Texels, CoverTheChartsAndDilate) {
    Mesh mesh = heightfield(1.0F, 4, [](float x, float y) { return 0.2F * x * y; });
    for (glm::vec2& uv : mesh.texcoords) {
        uv = 0.25F + 0.5F * uv; // the middle of the map
    }
    const Result<BakePoints> points = lightmap_points(mesh, 16, 16);
    ASSERT_TRUE(points);
    std::size_t covered = 0;
    for (std::size_t i = 0; i < 256; ++i) {
        const bool inside = i % 16 >= 4 && i % 16 < 12 && i / 16 >= 4 && i / 16 < 12;
        EXPECT_EQ(points->normals[i] != glm::vec3(0.0F), inside) << i;
        covered += inside ? 1 : 0;
        if (inside) {
            const float x = (static_cast<float>(i % 16) + 0.5F - 8.0F) / 4.0F;
            EXPECT_NEAR(points->positions_m[i].x, x, 1e-5F);
        }
    }
    EXPECT_EQ(covered, 64U);
    BakeSettings settings;
    settings.rays = 256;
    Result<Bake> baked = bake_points(mesh, *points, settings);
    ASSERT_TRUE(baked);
    EXPECT_EQ(test::norm(baked->field.point(0)), 0.0);
    EXPECT_EQ(test::norm(baked->field.point(3 + 16 * 8)), 0.0);
    dilate(baked->field, *points, 16, 1);
    EXPECT_GT(test::norm(baked->field.point(3 + 16 * 8)), 0.3);
    EXPECT_EQ(test::norm(baked->field.point(2 + 16 * 8)), 0.0);
    mesh.texcoords.clear();
    EXPECT_FALSE(lightmap_points(mesh, 16, 16));
}

TEST(BentNormals, PointAwayFromWhatOccludes) {
    // A floor beside a tall wall at +x.
    Mesh mesh = merged(plane(1.0F, 2), box(glm::vec3(0.5F, 20.0F, 20.0F), 1), glm::vec3(1.7F, 0.0F, 0.0F));
    BakeSettings settings;
    settings.order = 2;
    const Result<Bake> baked = bake(mesh, settings);
    ASSERT_TRUE(baked);
    const std::vector<glm::vec4> bent = bent_normals(baked->field);
    EXPECT_LT(bent[4].x, -0.2F); // the middle of the floor leans away
    EXPECT_GT(bent[4].z, 0.5F);
    EXPECT_NEAR(glm::length(glm::vec3(bent[4])), 1.0F, 1e-5F);
    // A wall to the zenith at distance a hides a cosine-weighted part (1 - sin(elevation of its top)...) / 2: here the
    // top stands at atan(20 / 1.2), and the hidden part is sin^2 of half ... = (1 - cos(elevation)) / 2.
    EXPECT_NEAR(bent[4].w, 1.0 - 0.5 * (1.0 - std::cos(std::atan(20.0 / 1.2))), 0.01);
    const Result<Bake> open = bake(plane(1.0F, 2), settings);
    ASSERT_TRUE(open);
    EXPECT_NEAR(bent_normals(open->field)[0].w, 1.0F, 1e-5F);
    EXPECT_NEAR(bent_normals(open->field)[0].z, 1.0F, 1e-5F);
}

} // namespace
} // namespace alpenglow::prt
