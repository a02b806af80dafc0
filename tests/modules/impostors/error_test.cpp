// The metrics against what they bound.
#include <alpenglow/impostors/error.hpp>
#include <alpenglow/impostors/reproject.hpp>

#include "blob_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::impostors {
namespace {

glm::dvec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

// Angle at `eye` between a point and where a plane through the centre shows it.
double shown_off(const Sphere& bounds, const glm::dvec3& c, const glm::dvec3& eye, const glm::dvec3& p) {
    const glm::dvec3 n = glm::normalize(bounds.centre_m - c);
    const glm::dvec3 q = c + (p - c) * glm::dot(bounds.centre_m - c, n) / glm::dot(p - c, n);
    return angle_between(p - eye, q - eye);
}

TEST(Angle, StableAtTinyAndHugeAngles) {
    for (const double angle : {1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-6}) {
        const glm::dvec3 a(1e7, 0.0, 0.0);
        const glm::dvec3 b = 1e-4 * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
        EXPECT_NEAR(angle_between(a, b) / angle, 1.0, 1e-9) << angle;
    }
    EXPECT_EQ(angle_between({0, 0, 0}, {1, 0, 0}), 0.0);
}

// 10^5 random changes of view, of matter spread through the ball: no point is off by more than the bound, and the bound
// is close to the worst point.
TEST(TranslationAngle, BoundsEveryPointAndIsTight) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<glm::dvec3> points;
    for (int k = 0; k < 150; ++k) { // on the surface, where the worst points are, and within
        points.push_back((k % 3 != 0 ? 1.0 : std::cbrt(uniform(random))) * random_direction(random));
    }
    std::vector<double> tightness;
    int beyond = 0;
    constexpr int changes = 100000;
    for (int n = 0; n < changes; ++n) {
        const Sphere bounds{10.0 * random_direction(random), std::exp(4.0 * uniform(random) - 2.0)};
        const double far = 1.05 + std::exp(6.0 * uniform(random) - 2.0);
        const glm::dvec3 c = bounds.centre_m + bounds.radius_m * far * random_direction(random);
        const double step = bounds.radius_m * (far - 1.0) * std::exp(-12.0 * uniform(random));
        const glm::dvec3 e = c + step * random_direction(random);
        if (glm::length(e - bounds.centre_m) <= bounds.radius_m * 1.01) {
            continue;
        }
        const double bound = translation_angle(bounds, c, e);
        double worst = 0.0;
        for (const glm::dvec3& p : points) {
            worst = std::max(worst, shown_off(bounds, c, e, bounds.centre_m + bounds.radius_m * p));
        }
        beyond += worst > bound * (1.0 + 1e-3);
        tightness.push_back(bound / worst);
    }
    EXPECT_LE(beyond, changes / 1000);
    std::nth_element(tightness.begin(), tightness.begin() + static_cast<long>(tightness.size() / 2), tightness.end());
    EXPECT_LE(tightness[tightness.size() / 2], 3.0);
    RecordProperty("beyond_bound", beyond);
    RecordProperty("median_bound_over_measured", std::to_string(tightness[tightness.size() / 2]));
}

TEST(TranslationAngle, TheQuickBoundIsNoLess) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int n = 0; n < 20000; ++n) {
        const Sphere bounds{{0, 0, 0}, 1.0};
        const double far = 1.0 + std::exp(8.0 * uniform(random) - 4.0);
        const glm::dvec3 c = far * random_direction(random);
        const glm::dvec3 e = c + (far - 1.0) * std::exp(-6.0 * uniform(random)) * random_direction(random);
        for (const int planes : {1, 2, 8, 16}) {
            ASSERT_GE(translation_angle_quick(bounds, c, e, planes) * (1.0 + 1e-12),
                      translation_angle(bounds, c, e, planes));
        }
    }
    // And close to it for a small step across.
    EXPECT_NEAR(translation_angle_quick({{0, 0, 0}, 1.0}, {0, -4, 0}, {1e-4, -4, 0}) /
                    translation_angle({{0, 0, 0}, 1.0}, {0, -4, 0}, {1e-4, -4, 0}),
                1.0, 0.01);
}

TEST(TranslationAngle, SmallMotionIsLinear) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const glm::dvec3 c(0, -4, 0);
    // On the axis R / (d (d - R)) a metre of sideways motion.
    for (const double b : {1e-3, 1e-6, 1e-9}) {
        EXPECT_NEAR(translation_angle(bounds, c, c + glm::dvec3(b, 0, 0)) / (b / 12.0), 1.0, 2e-3) << b;
    }
    EXPECT_EQ(translation_angle(bounds, c, c), 0.0);
    EXPECT_EQ(translation_angle({{0, 0, 0}, 0.0}, c, {1, 1, 1}), 0.0);
}

TEST(TranslationAngle, LayersDivideIt) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const glm::dvec3 c(0, -4, 0);
    const glm::dvec3 e(0.01, -4, 0);
    double before = translation_angle(bounds, c, e);
    for (const int planes : {2, 4, 8, 16}) {
        const double now = translation_angle(bounds, c, e, planes);
        EXPECT_LT(now, 0.62 * before) << planes;
        before = now;
    }
}

TEST(TranslationAngle, HoldsNothingFromInside) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    EXPECT_EQ(translation_angle(bounds, {0, -4, 0}, {0, 0, 0}), std::numbers::pi);
    EXPECT_EQ(translation_angle(bounds, {0, -4, 0}, {0, -1, 0}), std::numbers::pi);
    EXPECT_EQ(translation_angle(bounds, {0, -0.5, 0}, {0, -4, 0}), std::numbers::pi);
}

TEST(ZoomAngle, GrowsWithForwardMotion) {
    double before = 0.0;
    for (const double d : {3.99, 3.9, 3.5, 3.0, 2.0}) {
        const double now = zoom_angle(1.0, 4.0, d);
        EXPECT_GT(now, before);
        before = now;
    }
    EXPECT_EQ(zoom_angle(1.0, 4.0, 4.0), 0.0);
    // Small steps: b times the largest of |1/p - 1/q| sin(theta) over the ball, 0.01523 for d = 4 (by a fine grid).
    double largest = 0.0;
    for (int k = 1; k < 20000; ++k) {
        const double theta = std::asin(0.25) * k / 20000.0;
        const double p = 4.0 * std::cos(theta) - std::sqrt(1.0 - 16.0 * std::sin(theta) * std::sin(theta));
        largest = std::max(largest, (1.0 / p - std::cos(theta) / 4.0) * std::sin(theta));
    }
    EXPECT_NEAR(zoom_angle(1.0, 4.0, 4.0 - 1e-6) / (1e-6 * largest), 1.0, 2e-3);
}

TEST(Pixels, AZoomedViewCountsMore) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const Frustum wide = look_at({0, -10, 0}, {0, 0, 0}, {0, 0, 1}, 1.0, 960, 540);
    const Frustum zoomed = look_at({0, -10, 0}, {0, 0, 0}, {0, 0, 1}, 0.1, 960, 540);
    EXPECT_NEAR(pixels_per_radian(zoomed, bounds) / pixels_per_radian(wide, bounds), std::tan(0.5) / std::tan(0.05),
                0.2);
    // A turn of the eye by a small angle moves nothing by more pixels than that.
    const double per_radian = pixels_per_radian(wide, bounds);
    for (const double x : {-0.1, 0.0, 0.1}) {
        const double moved = (std::tan(std::atan(x) + 1e-4) - x) * wide.pixels_per_tan_x();
        EXPECT_LE(moved, per_radian * 1e-4 * (1.0 + 1e-3));
    }
}

TEST(Resolution, EquationEleven) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const Frustum view = look_at({0, -20, 0}, {0, 0, 0}, {0, 0, 1}, 0.8, 960, 540);
    const int texels = required_texels(view, bounds, view.eye_m);
    const double screen = 540.0 / (2.0 * std::tan(0.4)); // pixels for a tangent of 1
    EXPECT_NEAR(texels - 2, screen * 2.0 / 20.0, 1.1);   // resolution x size / distance
    const auto frustum = fit_frustum(bounds, view.eye_m, {0, 0, 1}, texels);
    EXPECT_GE(frustum->pixels_per_tan_x(), screen * (1.0 - 1e-9));
}

TEST(Light, ColourIsMadeGoodAndTurnsAreNot) {
    const Lights before{{0, 0, 1}, {2.0F, 1.0F, 0.5F}, {1.0F, 1.0F, 1.0F}};
    Lights now = before;
    now.key *= 7.0F;
    now.fill = glm::vec3(0.1F, 0.2F, 0.3F);
    EXPECT_EQ(light_error(before, now, 0.85), 0.0);
    now.to_key = glm::vec3(std::sin(0.001F), 0.0F, std::cos(0.001F));
    EXPECT_NEAR(light_error(before, now, 0.0), 1e-3, 1e-6);
    EXPECT_NEAR(light_error(before, now, 0.85), 1e-3 * (1.0 + 2.55 / 0.2775), 1e-5);
    Lights dark = before;
    dark.key.x = 0.0F;
    EXPECT_TRUE(std::isinf(light_error(dark, before, 0.0)));
    EXPECT_EQ(light_error(before, dark, 0.0), 0.0); // going out is a factor
}

// The slope in light_error is the steepest of Henyey and Greenstein's phase function.
TEST(Light, PhaseSlopeIsTheSteepest) {
    for (const double g : {0.1, 0.5, 0.85, 0.95}) {
        double steepest = 0.0;
        for (int k = 1; k < 100000; ++k) {
            const double theta = std::numbers::pi * k / 100000.0;
            const double s = std::sin(0.5 * theta);
            steepest = std::max(steepest, 3.0 * g * std::sin(theta) / ((1.0 - g) * (1.0 - g) + 4.0 * g * s * s));
        }
        EXPECT_NEAR(steepest / (3.0 * g / (1.0 - g * g)), 1.0, 1e-4) << g;
    }
}

// What predicted_error says against the image error, for captures of many clouds and 10^5 changes of view in all. The
// exact image of a cloud with one source radiance is 1 - exp(-optical depth): closed form.
class PredictedError : public ::testing::TestWithParam<Representation> {};

std::vector<glm::vec4> exact_image(const test::BlobCloud& cloud, const Frustum& view) {
    std::vector<glm::vec4> image(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
    std::vector<double> depth(image.size(), 0.0);
    for (const test::Blob& blob : cloud.blobs) {
        const glm::dvec3 p = blob.centre_m - view.eye_m;
        const double inverse = 0.5 / (blob.sigma_m * blob.sigma_m);
        const PixelRect rect = visible_rect({blob.centre_m, 4.0 * blob.sigma_m}, view);
        for (int y = rect.y0; y < rect.y1; ++y) {
            for (int x = rect.x0; x < rect.x1; ++x) {
                const glm::dvec3 v = view.direction(x + 0.5, y + 0.5);
                const double t = glm::dot(p, v);
                const double d2 = (glm::dot(p, p) - t * t / glm::dot(v, v)) * inverse;
                if (d2 < 8.0) {
                    depth[static_cast<std::size_t>(y * view.width + x)] +=
                        blob.extinction_per_m * blob.sigma_m * 2.5066282746310002 * (std::exp(-d2) - std::exp(-8.0));
                }
            }
        }
    }
    for (std::size_t i = 0; i < image.size(); ++i) {
        image[i] = glm::vec4(static_cast<float>(-std::expm1(-depth[i])));
    }
    return image;
}

TEST_P(PredictedError, BoundsTheImageError) {
    constexpr int captures = 50;
    constexpr int changes = 500; // of view, for each: 10^5 over the four representations
    constexpr int side = 18;
    std::mt19937 random(static_cast<unsigned>(GetParam()) + 11U);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<double> ratio;
    int beyond = 0;
    for (int n = 0; n < captures; ++n) {
        test::BlobCloud cloud =
            test::make_blob_cloud(10 + static_cast<int>(30.0 * uniform(random)), static_cast<std::uint32_t>(random()),
                                  {0, 0, 1}, std::exp(3.0 * uniform(random) - 1.0));
        for (test::Blob& blob : cloud.blobs) {
            blob.key = 1.0F;
            blob.fill = 0.0F;
        }
        cloud.steps = 16;
        const double distance = 1.8 + std::exp(3.0 * uniform(random) - 1.0);
        const glm::dvec3 c = distance * random_direction(random);
        const auto frustum = fit_frustum(cloud.bounds, c, {0, 0, 1}, side);
        ASSERT_TRUE(frustum);
        CaptureSettings settings;
        settings.representation = GetParam();
        settings.layers = 4;
        const auto picture = capture(cloud.bounds, *frustum, settings, test::drawable(cloud));
        ASSERT_TRUE(picture);
        const double fov = 2.0 * std::atan(frustum->tan_top) * 1.05;
        std::vector<glm::vec4> drawn;
        DrawSettings one_thread;
        one_thread.threads = 1;
        for (int k = 0; k < changes; ++k) {
            // 0.1 to 5 degrees about the object in any direction, or towards it by as much.
            const double b = distance * 0.0017 * std::exp(3.9 * uniform(random));
            const glm::dvec3 e = c + b * random_direction(random);
            const Frustum view = look_at(e, cloud.bounds.centre_m, {0, 0, 1}, fov, side, side);
            const std::vector<glm::vec4> exact = exact_image(cloud, view);
            drawn.assign(exact.size(), glm::vec4(0.0F));
            draw(*picture, view, one_thread, drawn);
            const double measured = test::relative_rmse(drawn, exact);
            const double bound = predicted_error(*picture, e, 2.0);
            beyond += measured > bound;
            ratio.push_back(bound / measured);
        }
    }
    std::sort(ratio.begin(), ratio.end());
    const double median = ratio[ratio.size() / 2];
    EXPECT_LE(beyond, captures * changes / 1000);
    EXPECT_LE(median, 3.0);
    RecordProperty("beyond_bound", beyond);
    RecordProperty("median_bound_over_measured", std::to_string(median));
}
INSTANTIATE_TEST_SUITE_P(All, PredictedError,
                         ::testing::Values(Representation::plane, Representation::layers, Representation::depth_warp,
                                           Representation::warped_layers));

} // namespace
} // namespace alpenglow::impostors
