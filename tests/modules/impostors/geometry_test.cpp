#include <alpenglow/impostors/geometry.hpp>
#include <alpenglow/impostors/raster.hpp>

#include <cmath>
#include <random>
#include <utility>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::impostors {
namespace {

glm::dvec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

TEST(Geometry, SphereFrustumIsTight) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int n = 0; n < 1000; ++n) {
        const Sphere sphere{100.0 * random_direction(random), std::exp(8.0 * uniform(random) - 4.0)};
        const glm::dvec3 eye = sphere.centre_m + sphere.radius_m * (1.02 + std::exp(10.0 * uniform(random) - 5.0)) *
                                                     random_direction(random);
        const auto frustum = fit_frustum(sphere, eye, random_direction(random), 64);
        ASSERT_TRUE(frustum);
        EXPECT_NEAR(glm::dot(frustum->right, frustum->up), 0.0, 1e-12);
        EXPECT_NEAR(glm::length(glm::cross(frustum->right, frustum->up) + frustum->forward), 0.0, 1e-12);
        // The silhouette touches the window less its border of one texel: the cone's half angle is asin(R / d).
        const double d = glm::length(sphere.centre_m - eye);
        EXPECT_NEAR(std::atan(frustum->tan_right * 62.0 / 64.0), std::asin(sphere.radius_m / d), 1e-9);
        EXPECT_EQ(frustum->tan_left, -frustum->tan_right);
        EXPECT_EQ(frustum->tan_bottom, -frustum->tan_top);
    }
}

TEST(Geometry, NoFrustumFromInside) {
    const Sphere sphere{{1.0, 2.0, 3.0}, 2.0};
    const glm::dvec3 up(0.0, 0.0, 1.0);
    EXPECT_FALSE(fit_frustum(sphere, sphere.centre_m, up, 64));
    EXPECT_FALSE(fit_frustum(sphere, {1.0, 2.0, 5.0}, up, 64));        // on it
    EXPECT_FALSE(fit_frustum(sphere, {1.0, 2.0, 5.0 + 1e-4}, up, 64)); // 1e-4 m away: the window would be endless
    EXPECT_TRUE(fit_frustum(sphere, {1.0, 2.0, 5.0 + 0.05}, up, 64));
    EXPECT_TRUE(fit_frustum(sphere, {1.0, 2.0, 5.0 + 1e-4}, up, 64, 1e3));
    EXPECT_FALSE(fit_frustum(Box{{-1, -1, -1}, {1, 1, 1}}, {0.5, 0.5, 0.5}, up, 64));
}

TEST(Geometry, BoxFrustumHoldsTheCornersAndIsSmallerThanTheSpheres) {
    std::mt19937 random(2);
    for (int n = 0; n < 300; ++n) {
        const glm::dvec3 half = 0.2 + glm::abs(random_direction(random)) * glm::dvec3(8.0, 3.0, 0.5);
        const Box box{-half, half};
        const glm::dvec3 eye = 40.0 * random_direction(random);
        const auto frustum = fit_frustum(box, eye, {0, 0, 1}, 64);
        ASSERT_TRUE(frustum);
        ASSERT_EQ(std::max(frustum->width, frustum->height), 64);
        const double texel = 1.0 / frustum->pixels_per_tan_x();
        EXPECT_NEAR(texel, 1.0 / frustum->pixels_per_tan_y(), 1e-9);
        double touch = 1e9;
        for (int c = 0; c < 8; ++c) {
            const glm::dvec3 p =
                half * glm::dvec3((c & 1) != 0 ? 1 : -1, (c & 2) != 0 ? 1 : -1, (c & 4) != 0 ? 1 : -1) - eye;
            const double z = glm::dot(p, frustum->forward);
            const double x = glm::dot(p, frustum->right) / z;
            const double y = glm::dot(p, frustum->up) / z;
            const double inside = std::min(
                {x - frustum->tan_left, frustum->tan_right - x, y - frustum->tan_bottom, frustum->tan_top - y});
            EXPECT_GE(inside, texel * (1.0 - 1e-9));
            touch = std::min(touch, inside);
        }
        EXPECT_LE(touch, texel * (1.0 + 1e-9)); // tight on the larger side
        const auto round = fit_frustum(bounding_sphere(box), eye, {0, 0, 1}, 64);
        EXPECT_LE((frustum->tan_right - frustum->tan_left) * (frustum->tan_top - frustum->tan_bottom),
                  (round->tan_right - round->tan_left) * (round->tan_top - round->tan_bottom) * 1.0001);
    }
}

// Every point of the sphere that lands in the view lands in the rectangle, and the rectangle is no larger than it must
// be.
TEST(Geometry, VisibleRectHoldsTheSphere) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    int seen = 0;
    for (int n = 0; n < 2000; ++n) {
        const Frustum view =
            look_at({0, 0, 0}, random_direction(random), {0, 0, 1}, 1.0 + 0.9 * uniform(random), 160, 90);
        const Sphere sphere{4.0 * random_direction(random), 2.0 + 1.99 * uniform(random)};
        const PixelRect rect = visible_rect(sphere, view);
        double left = 1e9, right = -1e9;
        bool in_view = false;
        for (int k = 0; k < 400; ++k) {
            const glm::dvec3 p = sphere.centre_m + sphere.radius_m * random_direction(random);
            const double z = glm::dot(p, view.forward);
            if (z <= 0.0) {
                continue;
            }
            const double x = (glm::dot(p, view.right) / z - view.tan_left) * view.pixels_per_tan_x();
            const double y = (view.tan_top - glm::dot(p, view.up) / z) * view.pixels_per_tan_y();
            if (x < 0.0 || y < 0.0 || x >= view.width || y >= view.height) {
                continue;
            }
            in_view = true;
            left = std::min(left, x);
            right = std::max(right, x);
            ASSERT_TRUE(x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1);
        }
        seen += in_view;
    }
    EXPECT_GT(seen, 300);
    // Exactly known: a sphere of angular radius 30 degrees straight ahead in a window of 90.
    const Frustum view = look_at({0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1.5707963267948966, 1000, 1000);
    const PixelRect rect = visible_rect({{0, 2, 0}, 1.0}, view);
    EXPECT_NEAR(rect.x0, 500 - 288.7, 1.0);
    EXPECT_NEAR(rect.x1, 500 + 288.7, 1.0);
    EXPECT_TRUE(visible_rect({{0, -5, 0}, 1.0}, view).empty());
    EXPECT_TRUE(visible_rect({{9, 2, 0}, 1.0}, view).empty());
}

TEST(Geometry, ScreenAlignedIsTheViewCoarser) {
    const Frustum view = look_at({1, 2, 3}, {0, 1, 0}, {0, 0, 1}, 1.0, 961, 540);
    const Frustum coarse = screen_aligned(view, 4.0);
    EXPECT_EQ(coarse.width, 241);
    EXPECT_EQ(coarse.height, 135);
    EXPECT_EQ(coarse.tan_left, view.tan_left);
    EXPECT_EQ(coarse.tan_top, view.tan_top);
}

// What a rasterizer is given: a point's pixel and depth are those of the frustum.
TEST(Raster, ClipSpaceIsTheFrustums) {
    Frustum view = look_at({100.0, -50.0, 7.0}, {0, 0, 0}, {0.1, 0, 1}, 0.7, 320, 200);
    view.tan_left *= 0.3; // off centre
    view.tan_top *= 1.4;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (const auto& [near_m, far_m] : {std::pair{100.0, 130.0}, {1e-3, 1e4}, {1e7 - 1.0, 1e7 + 1.0}}) {
        const glm::mat4 clip = clip_from_eye(view, near_m, far_m);
        for (int n = 0; n < 200; ++n) {
            const double x = 320.0 * uniform(random);
            const double y = 200.0 * uniform(random);
            const double z = near_m + (far_m - near_m) * uniform(random);
            const glm::vec4 p = clip * glm::vec4(glm::vec3(z * view.direction(x, y)), 1.0F);
            EXPECT_NEAR((p.x / p.w + 1.0F) * 160.0F, x, 2e-3);
            EXPECT_NEAR((p.y / p.w + 1.0F) * 100.0F, y, 2e-3);
            const double depth = static_cast<double>(p.z) / static_cast<double>(p.w);
            const double exact = near_m * (far_m - z) / (z * (far_m - near_m));
            if (far_m < 1e6) {
                EXPECT_NEAR(depth, exact, 1e-5 * std::max(1.0, near_m / (far_m - near_m)));
            }
            EXPECT_NEAR(axis_depth(near_m, far_m, static_cast<float>(exact)), z, 1e-6 * z * std::max(1.0, z / near_m));
        }
    }
}

} // namespace
} // namespace alpenglow::impostors
