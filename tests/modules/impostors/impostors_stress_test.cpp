// Degenerate views, bounds and scenes, with floating-point traps on.
#include <alpenglow/impostors/error.hpp>
#include <alpenglow/impostors/reproject.hpp>
#include <alpenglow/impostors/store.hpp>

#include "blob_cloud.hpp"
#include "fp_traps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::impostors {
namespace {

using ImpostorsStress = test::StressTest;

glm::dvec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

TEST_F(ImpostorsStress, MetricsOverAllScales) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int n = 0; n < 20000; ++n) {
        const double radius = n % 50 == 0 ? 0.0 : std::pow(10.0, 14.0 * uniform(random) - 6.0);
        const Sphere bounds{std::pow(10.0, 8.0 * uniform(random) - 2.0) * random_direction(random), radius};
        const glm::dvec3 c = bounds.centre_m + std::pow(10.0, 12.0 * uniform(random) - 4.0) * random_direction(random);
        const glm::dvec3 e =
            n % 3 == 0 ? c + std::pow(10.0, -9.0 + 6.0 * uniform(random)) * random_direction(random)
                       : bounds.centre_m + std::pow(10.0, 12.0 * uniform(random) - 4.0) * random_direction(random);
        for (const int planes : {1, 4, 16}) {
            const double angle = translation_angle(bounds, c, e, planes);
            ASSERT_TRUE(angle >= 0.0 && angle <= std::numbers::pi) << angle;
        }
        const double fov = (1.0 + 149.0 * uniform(random)) * std::numbers::pi / 180.0;
        const Frustum view = look_at(e, bounds.centre_m, {0, 0, 1}, fov, 960, 540);
        ASSERT_GT(pixels_per_radian(view, bounds), 0.0);
        ASSERT_GE(required_texels(view, bounds, e), 2);
        (void)visible_rect(bounds, view);
        (void)fit_frustum(bounds, c, random_direction(random), 16);
    }
}

// On the sphere, at the centre, 1e-4 m and 1e7 m away.
TEST_F(ImpostorsStress, PicturesFromAnywhere) {
    const test::BlobCloud cloud = test::make_blob_cloud(20, 3);
    for (const Representation r :
         {Representation::plane, Representation::layers, Representation::depth_warp, Representation::warped_layers}) {
        for (const double away : {1e-4, 0.01, 1.0, 1e3, 1e7}) {
            const glm::dvec3 c(0.0, -(1.0 + away), 0.0);
            const auto frustum = fit_frustum(cloud.bounds, c, {0, 0, 1}, 24, 1e4);
            ASSERT_TRUE(frustum);
            CaptureSettings settings;
            settings.representation = r;
            settings.sharpen = false; // texels are hit
            const auto picture = capture(cloud.bounds, *frustum, settings, test::drawable(cloud));
            ASSERT_TRUE(picture);
            if (away >= 1e3) { // as good as anywhere else: no digits are lost
                const Frustum view = look_at(c, {0, 0, 0}, {0, 0, 1}, 2.0 * std::atan(frustum->tan_top), 24, 24);
                std::vector<glm::vec4> image(24 * 24, glm::vec4(0.0F));
                draw(*picture, view, {}, image);
                EXPECT_LT(test::relative_rmse(image, test::draw_directly(cloud, view)), 0.01) << away;
            }
            for (const glm::dvec3 e : {glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 0), glm::dvec3(0, -1.0001, 0), c,
                                       glm::dvec3(0, 3, 0), glm::dvec3(1e7, 0, 0), glm::dvec3(0, 0.3, -0.2)}) {
                for (const double fov : {1.0, 60.0, 150.0}) {
                    const Frustum view = look_at(e, {0.1, 0.2, 0.3}, {0, 0, 1}, fov * std::numbers::pi / 180.0, 20, 12);
                    std::vector<glm::vec4> image(20 * 12, glm::vec4(0.0F));
                    draw(*picture, view, {}, image);
                    for (const glm::vec4& t : image) {
                        ASSERT_TRUE(t.w >= 0.0F && t.w <= 1.0001F && t.x >= 0.0F && t.x < 100.0F);
                    }
                    (void)predicted_error(*picture, e);
                }
            }
        }
        // The viewer inside: the view itself, coarser.
        const Frustum view = look_at({0.1, -0.2, 0.05}, {1, 1, 0}, {0, 0, 1}, 1.2, 40, 24);
        CaptureSettings settings;
        settings.representation = r;
        settings.open_edges = true;
        const auto picture = capture(cloud.bounds, screen_aligned(view, 2.0), settings, test::drawable(cloud));
        ASSERT_TRUE(picture);
        std::vector<glm::vec4> image(40 * 24, glm::vec4(0.0F));
        draw(*picture, view, {}, image);
        EXPECT_LT(test::relative_rmse(image, test::draw_directly(cloud, view)), 0.05);
    }
}

TEST_F(ImpostorsStress, HugeRadianceAndEmptyPictures) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const auto frustum = *fit_frustum(bounds, {0, -4, 0}, {0, 0, 1}, 16);
    for (const float value : {0.0F, 1e-38F, 1e30F}) {
        const Drawable flat = [value](const CaptureRequest&, std::span<SlabImage> slabs) -> Status {
            for (SlabImage& slab : slabs) {
                std::fill(slab.colour.begin(), slab.colour.end(), glm::vec4(value, value, value, 0.5F));
                std::fill(slab.depth.begin(), slab.depth.end(), glm::vec2(0.1F, 0.05F));
            }
            return Ok{};
        };
        const auto picture = capture(bounds, frustum, CaptureSettings{}, flat);
        ASSERT_TRUE(picture);
        EXPECT_TRUE(std::isfinite(predicted_error(*picture, {0.1, -4, 0})));
    }
}

TEST_F(ImpostorsStress, TenThousandImpostorsInASmallAtlas) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<SceneObject> objects(10000);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        objects[i].id = i + 1;
        objects[i].bounds = {{5000.0 * uniform(random), 6000.0 + 5000.0 * uniform(random), 500.0 * uniform(random)},
                             60.0};
    }
    SchedulerSettings settings;
    settings.atlas_side = 512; // 1024 smallest tiles
    settings.budget_texels = 60000.0;
    Scheduler scheduler = std::move(Scheduler::create(settings).value());
    std::vector<SceneView> views{{1, look_at({0, 0, 0}, {0, 5000, 0}, {0, 0, 1}, 1.0, 960, 540)}};
    Plan plan;
    for (int frame = 0; frame < 25; ++frame) {
        views[0].frustum.eye_m.y += 3.0;
        scheduler.plan(objects, views, {}, frame / 60.0, plan);
        ASSERT_LE(plan.report.texels, 1.5 * settings.budget_texels);
    }
    EXPECT_GT(plan.report.degrade_level, 0); // and says so
    EXPECT_GT(plan.report.unserved, 0U);
    EXPECT_GT(plan.report.seen, 2000U);
    // Those with a picture matter more than those without.
    double with = 0.0;
    double without = 0.0;
    std::size_t served = 0;
    for (const DrawItem& item : plan.draws) {
        (item.slot != no_slot ? with : without) += 60.0 / item.distance_m;
        served += item.slot != no_slot;
    }
    ASSERT_GT(served, 200U);
    EXPECT_GT(with / static_cast<double>(served), without / static_cast<double>(plan.draws.size() - served));
}

TEST_F(ImpostorsStress, TeleportResizeRollAndZoom) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<SceneObject> objects(60);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        objects[i].id = i + 1;
        objects[i].bounds = {{800.0 * uniform(random), 800.0 * uniform(random), 100.0 * uniform(random)},
                             100.0 * (1.01 + uniform(random))};
    }
    Scheduler scheduler = std::move(Scheduler::create({}).value());
    Plan plan;
    for (int frame = 0; frame < 400; ++frame) {
        const glm::dvec3 eye = frame % 7 == 0 ? objects[static_cast<std::size_t>(frame) % 60].bounds.centre_m
                                              : glm::dvec3(1500.0 * uniform(random), 1500.0 * uniform(random), 0.0);
        const double fov = (75.5 + 74.5 * uniform(random)) * std::numbers::pi / 180.0;
        const int width = 1 + static_cast<int>(600.0 * std::abs(uniform(random)));
        const std::vector<SceneView> views{
            {1, look_at(eye, eye + random_direction(random), random_direction(random), fov, width, 1 + width / 2)}};
        // Clocks that stand still or run back are no reason to fall.
        scheduler.plan(objects, views, {}, frame % 11 == 0 ? 0.0 : frame / 60.0, plan);
        ASSERT_LE(plan.report.texels, 1.5 * scheduler.settings().budget_texels);
        for (const DrawItem& item : plan.draws) {
            ASSERT_TRUE(item.weight >= 0.0F && item.weight <= 1.0F);
            ASSERT_TRUE(item.impostor_weight >= 0.0F && item.impostor_weight <= 1.0F);
        }
    }
}

// Plan, capture and draw, the whole way: viewers on the bounding sphere, at the centre, 1e-4 m and 1e7 m away,
// teleporting from one to the next; fields of view of 1 to 150 degrees; windows of any size, rolled; objects of no size
// and of 1e15 m; no tolerance; no budget; a Drawable that leaves what is no number.
TEST_F(ImpostorsStress, TheWholeWayFromAnywhere) {
    const test::BlobCloud cloud = test::make_blob_cloud(8, 3);
    const Drawable blobs = test::drawable(cloud);
    const Drawable broken = [&](const CaptureRequest&, std::span<SlabImage> slabs) -> Status {
        for (SlabImage& slab : slabs) {
            std::fill(slab.colour.begin(), slab.colour.end(), glm::vec4(0.5F));
            slab.colour[slab.colour.size() / 2].y = std::numeric_limits<float>::quiet_NaN();
            slab.depth[slab.depth.size() / 2].x = std::numeric_limits<float>::infinity();
        }
        return Ok{};
    };
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (const double budget : {0.0, 4000.0}) {
        std::vector<SceneObject> objects(4);
        for (std::size_t i = 0; i < objects.size(); ++i) {
            objects[i].id = i + 1;
            objects[i].bounds = cloud.bounds;
            objects[i].layers = 4;
            objects[i].representation = static_cast<Representation>(i);
        }
        objects[1].bounds = {{0.0, 3.0, 0.0}, 0.0};
        objects[2].bounds = {{0.0, 3.0, 0.0}, 1e15};
        objects[3].bounds = {{0.5, 2.0, 0.0}, 0.5};
        objects[3].tolerance = {0.0, -1.0, 0.0, -1.0, 0.0};
        SchedulerSettings settings;
        settings.budget_texels = budget;
        settings.most_tile = 64;
        settings.atlas_side = 256;
        Scheduler scheduler = std::move(Scheduler::create(settings).value());
        CaptureStore store;
        Plan plan;
        int shown = 0;
        int frame = 0;
        const glm::dvec3 eyes[] = {{0, -1, 0}, {0, 0, 0}, {0, -1.0001, 0}, {0, -1e7, 0}, {0, -5, 0}, {0.3, -0.9999, 0}};
        for (int round = 0; round < 4; ++round) {
            for (const glm::dvec3& eye : eyes) {
                for (const double fov : {1.0, 60.0, 150.0}) {
                    const int width = 1 + static_cast<int>(40.0 * uniform(random));
                    const int height = 1 + static_cast<int>(40.0 * uniform(random));
                    const glm::dvec3 target = eye == glm::dvec3(0.0) ? glm::dvec3(0, 1, 0) : glm::dvec3(0.0);
                    const std::vector<SceneView> views{{1, look_at(eye, target, random_direction(random),
                                                                   fov * std::numbers::pi / 180.0, width, height)}};
                    for (int still = 0; still < 3; ++still) {
                        scheduler.plan(objects, views, {}, ++frame / 60.0, plan);
                        ASSERT_TRUE(store.carry_out(plan, objects, views, {}, scheduler,
                                                    [&](std::uint64_t id) { return id == 1 ? &blobs : &broken; }));
                    }
                    std::vector<glm::vec4> image(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
                    store.draw_view(plan, 0, objects, views, {}, {}, image);
                    float most = 0.0F;
                    for (const glm::vec4& t : image) {
                        ASSERT_TRUE(t.x >= 0.0F && t.x < 100.0F && t.w >= 0.0F && t.w <= 1.0001F);
                        most = std::max(most, t.w);
                    }
                    shown += most > 0.0F;
                    // From nearby something is always to be seen, also without a budget.
                    EXPECT_TRUE(most > 0.0F || eye.y < -100.0) << eye.y << " " << fov << " " << width << " " << height;
                }
            }
        }
        EXPECT_GT(shown, 50);
    }
}

TEST_F(ImpostorsStress, BadObjectsAndViews) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double inf = std::numeric_limits<double>::infinity();
    std::vector<SceneObject> objects(9);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        objects[i].id = i + 1;
        objects[i].bounds = {{0, 100, 0}, 10.0};
    }
    objects[0].bounds.radius_m = nan;
    objects[1].bounds.radius_m = -1.0;
    objects[2].bounds.radius_m = inf;
    objects[3].bounds.centre_m.x = nan;
    objects[4].bounds.radius_m = 0.0;
    objects[5].bounds.radius_m = 1e15; // the viewer is inside
    objects[6].tolerance = {0.0, 0.0, 0.0, 0.0, 0.0};
    objects[7].tolerance = {-1.0, nan, -1.0, nan, -1.0};
    Scheduler scheduler = std::move(Scheduler::create({}).value());
    Plan plan;
    std::vector<SceneView> views{{1, look_at({0, 0, 0}, {0, 100, 0}, {0, 0, 1}, 1.0, 320, 180)}};
    scheduler.plan(objects, views, {}, 0.0, plan);
    EXPECT_EQ(plan.report.rejected, 4U);
    EXPECT_EQ(plan.report.seen, 4U); // 5 .. 8
    EXPECT_EQ(plan.report.captured, 3U);
    scheduler.plan(objects, views, {}, 1.0, plan);
    EXPECT_EQ(plan.report.captured, 0U); // nothing moved: even a tolerance of 0 holds
    views[0].frustum.eye_m.x += 1e-3;
    scheduler.plan(objects, views, {}, 2.0, plan);
    EXPECT_EQ(plan.report.captured, 2U); // the two without tolerance
    views[0].frustum.eye_m.x = nan;
    scheduler.plan(objects, views, {}, 3.0, plan);
    EXPECT_EQ(plan.report.rejected, 9U);
    EXPECT_TRUE(plan.draws.empty());
    views[0].frustum.width = 0;
    scheduler.plan(objects, views, {}, 4.0, plan);
    EXPECT_TRUE(plan.draws.empty());
}

} // namespace
} // namespace alpenglow::impostors
