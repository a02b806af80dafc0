// Impostors of the clouds module's own clouds, against marching them.
#include <alpenglow/impostors/error.hpp>
#include <alpenglow/impostors/reproject.hpp>

#include "real_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::impostors {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

glm::dvec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

Frustum view_from(const Sphere& bounds, const glm::dvec3& eye, int pixels) {
    const double d = glm::length(bounds.centre_m - eye);
    const double tangent = bounds.radius_m / std::sqrt(d * d - bounds.radius_m * bounds.radius_m);
    return look_at(eye, bounds.centre_m, {0, 0, 1}, 2.0 * std::atan(tangent), pixels, pixels);
}

// Slabs composited front to back are the march of the whole.
TEST(RealCloud, SlabsAreTheWhole) {
    const test::RealCloud cloud(3);
    const Frustum frustum = *fit_frustum(
        cloud.bounds, cloud.bounds.centre_m + 3.0 * cloud.bounds.radius_m * glm::dvec3(0.6, -0.8, 0.0), {0, 0, 1}, 48);
    const auto exact = cloud.directly(frustum);
    for (const int layers : {1, 2, 4, 8}) {
        CaptureSettings settings{Representation::layers, layers, {}, 0.0, false, false};
        const auto picture = capture(cloud.bounds, frustum, settings, cloud.drawable());
        ASSERT_TRUE(picture);
        EXPECT_EQ(picture->rejected_texels, 0U);
        std::vector<glm::vec4> image(exact.size(), glm::vec4(0.0F));
        draw(*picture, frustum, {}, image);
        EXPECT_LT(test::relative_rmse(image, exact), 0.01) << layers;
    }
}

// The window may lie off centre, as a part of a view does.
TEST(RealCloud, OffCentreWindowsSeeTheSame) {
    const test::RealCloud cloud(4);
    const Frustum whole = view_from(cloud.bounds, cloud.bounds.centre_m + glm::dvec3(0.0, -90.0, 10.0), 64);
    Frustum part = whole;
    part.tan_left = whole.tan_left + 0.25 * (whole.tan_right - whole.tan_left);
    part.tan_top = whole.tan_top - 0.5 * (whole.tan_top - whole.tan_bottom);
    part.width = 48;
    part.height = 32;
    const auto all = cloud.directly(whole);
    const auto some = cloud.directly(part);
    for (std::size_t y = 0; y < 32; ++y) {
        for (std::size_t x = 0; x < 48; ++x) {
            ASSERT_NEAR(some[y * 48 + x].w, all[(y + 32) * 64 + x + 16].w, 1e-3F);
        }
    }
}

// predicted_error over what the picture lacks, for views of lit clouds: 2000 here, 10^5 in the benchmark.
TEST(RealCloud, PredictedErrorBoundsTheImageError) {
    constexpr int captures = 20;
    constexpr int changes = 25;
    constexpr int side = 56; // as fine as the voxels: what is finer than a pixel no metric can know
    std::mt19937 random(17);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<double> ratio;
    int beyond = 0;
    int count = 0;
    for (int n = 0; n < captures; ++n) {
        const test::RealCloud cloud(static_cast<std::uint32_t>(n) + 1U, 24, 0.0F,
                                    static_cast<float>(std::exp(3.0 * uniform(random) - 2.0)));
        const double distance = cloud.bounds.radius_m * (1.8 + std::exp(3.0 * uniform(random) - 1.0));
        const glm::dvec3 c = cloud.bounds.centre_m + distance * random_direction(random);
        // Light that is scattered more than once differs by a little for each eye; the metric is about parallax.
        const clouds::CloudLighting::ViewFields fields =
            cloud.lighting.contract(cloud.volume.transform().index_from_world(c));
        for (const Representation kind : {Representation::plane, Representation::layers, Representation::depth_warp,
                                          Representation::warped_layers}) {
            const CaptureSettings settings{kind, 4, {}, 0.0, false, true};
            const auto picture = capture(cloud.bounds, *fit_frustum(cloud.bounds, c, {0, 0, 1}, side), settings,
                                         cloud.drawable(&fields));
            ASSERT_TRUE(picture);
            std::vector<glm::vec4> drawn;
            for (int k = 0; k < changes; ++k) {
                const double b = distance * 0.0017 * std::exp(3.9 * uniform(random));
                const glm::dvec3 e = c + b * random_direction(random);
                const Frustum view = view_from(cloud.bounds, e, side);
                const auto exact = cloud.directly(view, &fields, 1);
                drawn.assign(exact.size(), glm::vec4(0.0F));
                DrawSettings one_thread;
                one_thread.threads = 1;
                draw(*picture, view, one_thread, drawn);
                const double measured = test::relative_rmse(drawn, exact);
                const double bound = predicted_error(*picture, e, 2.0);
                beyond += measured > bound;
                ++count;
                ratio.push_back(bound / measured);
            }
        }
    }
    std::nth_element(ratio.begin(), ratio.begin() + static_cast<long>(ratio.size() / 2), ratio.end());
    const double median = ratio[ratio.size() / 2];
    std::sort(ratio.begin(), ratio.end());
    EXPECT_LE(beyond, count / 1000);
    EXPECT_LE(median, 3.0);
    RecordProperty("beyond_bound", beyond);
    RecordProperty("median_bound_over_measured", std::to_string(median));
}

// The lit cumulus from 4 radii, in 96 x 96 pixels: layers hold for longer than a plane does, and at one degree of orbit
// every kind but the plane is within two hundredths.
TEST(RealCloud, LayersOutlastThePlane) {
    const test::RealCloud cloud(1, 0);
    const double distance = 4.0 * cloud.bounds.radius_m;
    const auto eye = [&](double angle) {
        return cloud.bounds.centre_m + distance * glm::dvec3(std::sin(angle), -std::cos(angle), 0.0);
    };
    const auto picture = [&](Representation kind, int layers) {
        const CaptureSettings settings{kind, layers, {}, 0.0, false, true};
        return std::move(
            capture(cloud.bounds, *fit_frustum(cloud.bounds, eye(0.0), {0, 0, 1}, 120), settings, cloud.drawable())
                .value());
    };
    const auto drawn = [&](const Capture& of, double angle, Filter filter) {
        DrawSettings settings;
        settings.filter = filter;
        std::vector<glm::vec4> image(96 * 96, glm::vec4(0.0F));
        draw(of, view_from(cloud.bounds, eye(angle), 96), settings, image);
        return image;
    };
    const auto psnr = [&](Representation kind, int layers, double angle) {
        return test::tone_mapped_psnr(drawn(picture(kind, layers), angle, Filter::bilinear),
                                      cloud.directly(view_from(cloud.bounds, eye(angle), 96)));
    };
    const auto exact = cloud.directly(view_from(cloud.bounds, eye(degree), 96));
    for (const auto& [kind, layers] :
         {std::pair{Representation::depth_warp, 1}, std::pair{Representation::layers, 8},
          std::pair{Representation::warped_layers, 4}, std::pair{Representation::warped_layers, 8}}) {
        const Capture of = picture(kind, layers);
        const double bilinear = test::relative_rmse(drawn(of, degree, Filter::bilinear), exact);
        EXPECT_LE(bilinear, 0.02);
        EXPECT_LT(test::relative_rmse(drawn(of, degree, Filter::cubic), exact), bilinear);
    }
    for (const double angle : {6.0 * degree, 12.0 * degree}) {
        const double plane = psnr(Representation::plane, 1, angle);
        EXPECT_GT(psnr(Representation::depth_warp, 1, angle), plane + 3.0);
        EXPECT_GT(psnr(Representation::warped_layers, 8, angle), plane + 3.0);
    }
}

} // namespace
} // namespace alpenglow::impostors
