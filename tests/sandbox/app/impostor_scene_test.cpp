// Scene `squadron`: clouds by their pictures, and aircraft among them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <set>
#include <string_view>
#include <vector>

#include <glm/geometric.hpp>

#include "one_game.hpp"
#include "sandbox/app/camera_flight.hpp"
#include "sandbox/app/impostor_scene.hpp"
#include "sandbox/app/picture_difference.hpp"
#include "sandbox/world/impostor_render_data.hpp"

namespace alpenglow::sandbox {
namespace {

class ImpostorSceneTest : public OneGame {
protected:
    static void enter(bool moving, int clouds = 30) {
        Scene scene = *load_scene("squadron");
        scene.time_rate = moving ? 1.0 : 0.0;
        scene.impostors->clouds = clouds;
        scene.impostors->craft = moving ? 5 : 0;
        scene.impostors->follow = moving;
        game_->enter(scene);
    }
    static void update(int frames = 1) {
        for (int i = 0; i < frames; ++i) {
            game_->update(1.0 / 60.0, 480, 270);
        }
    }
    static const ImpostorRenderData& drawn() { return *game_->frame().impostors; }
    static ImpostorScene& part() { return *game_->part<ImpostorScene>(); }
};

TEST_F(ImpostorSceneTest, StillnessTakesNoPicturesAndUploadsNothing) {
    enter(false);
    update(120);
    EXPECT_GT(part().schedule().seen, 3U);
    EXPECT_EQ(part().schedule().unserved, 0U);
    const std::uint32_t mesh = drawn().mesh_revision;
    for (int i = 0; i < 20; ++i) {
        update();
        EXPECT_EQ(report("captures")->updated, 0U);
        EXPECT_EQ(report("clouds")->updated, 0U);
        EXPECT_TRUE(drawn().tiles.empty());
        EXPECT_EQ(drawn().mesh_revision, mesh);
    }
}

TEST_F(ImpostorSceneTest, AFlightUsesPicturesAgainWithinItsBudget) {
    enter(true, 100);
    update(60);
    const Scene scene = *load_scene("squadron");
    double seen = 0.0;
    double reused = 0.0;
    bool divided = false;
    for (int i = 0; i < 150; ++i) {
        update();
        const impostors::ScheduleReport& schedule = part().schedule();
        seen += schedule.seen;
        reused += schedule.reused;
        EXPECT_LE(schedule.texels, 1.5 * scene.impostors->budget_texels);
        for (const ImpostorTile& tile : drawn().tiles) {
            EXPECT_GE(tile.x, 0);
            EXPECT_GE(tile.y, 0);
            EXPECT_LE(tile.x + tile.width, drawn().atlas_width);
            EXPECT_LE(tile.y + tile.height, drawn().atlas_height);
            EXPECT_EQ(tile.texels.size(), static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height));
        }
        for (const ImpostorVertex& v : drawn().vertices) {
            ASSERT_LT(glm::length(v.position_m), 1e6F);
            ASSERT_NEAR(v.weights.x + v.weights.y, 1.0F, 1.0F);
        }
        for (const ImpostorRun& run : drawn().runs) {
            ASSERT_LE(run.first_index + run.index_count, drawn().indices.size());
            divided = divided || run.kind == ImpostorRun::divided;
        }
    }
    EXPECT_GE(reused / seen, 0.95);
    EXPECT_TRUE(divided) << "no craft flew through a cloud";
}

TEST_F(ImpostorSceneTest, KeysOutlineAndMarchDirectly) {
    enter(false, 12);
    update(40);
    EXPECT_TRUE(drawn().outlines.empty());
    EXPECT_TRUE(part().press('O'));
    update();
    EXPECT_FALSE(drawn().outlines.empty());
    EXPECT_EQ(drawn().outlines.size() % 8, 0U); // four sides a picture
    EXPECT_TRUE(part().press('B'));
    update();
    EXPECT_GT(report("direct_march")->updated, 0U);
    EXPECT_EQ(drawn().tiles.back().width, 480);
    EXPECT_TRUE(part().press('B'));
    update();
    EXPECT_FALSE(drawn().indices.empty());
    EXPECT_FALSE(part().press('?'));
}

TEST(FlyThroughTest, GoesThroughTwoCloudsInTenSeconds) {
    const Scene scene = *load_scene("fly-through");
    ASSERT_TRUE(scene.impostors && scene.flight);
    const std::vector<glm::dvec3> places =
        cloud_places(scene.impostors->clouds, static_cast<double>(scene.impostors->field_m),
                     static_cast<double>(scene.impostors->base_m));
    const double size = static_cast<double>(scene.impostors->size_m);
    std::set<std::size_t> entered;
    std::set<std::size_t> near;
    glm::dvec3 before(flight_at(*scene.flight, 0.0).position_m);
    for (int frame = 1; frame < 600; ++frame) {
        const glm::dvec3 here(flight_at(*scene.flight, frame / 60.0).position_m);
        const double speed = glm::length(here - before) * 60.0;
        EXPECT_GE(speed, 80.0) << frame;
        EXPECT_LE(speed, 200.0) << frame;
        before = here;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const glm::dvec3 from = here - places[i]; // from the middle of its base; clouds are 0.54 sizes high
            if (std::hypot(from.x, from.y) < 0.25 * size && from.z > 0.0 && from.z < 0.5 * size) {
                entered.insert(i);
            }
            if (glm::length(from) < 2.0 * size) {
                near.insert(i);
            }
        }
    }
    EXPECT_GE(entered.size(), 2U);
    EXPECT_GE(near.size(), 8U);
}

TEST(SquadronTest, FliesAClosedPathWithoutJumps) {
    const std::vector<glm::dvec3> places = cloud_places(60, 11000.0, 2300.0);
    const FlightPath path(places, 11000.0, 2300.0);
    EXPECT_LT(glm::length(path.at(0.0) - path.at(path.length_m())), 1e-6);
    std::vector<Craft> before = squadron_at(path, 5, 0.0);
    for (int i = 1; i < 2000; ++i) {
        const std::vector<Craft> now = squadron_at(path, 5, i / 60.0);
        for (std::size_t k = 0; k < now.size(); ++k) {
            EXPECT_LT(glm::length(now[k].position_m - before[k].position_m), 6.0); // 110 m/s and what the spline adds
            EXPECT_NEAR(glm::length(now[k].axes[0]), 1.0F, 1e-4F);
            EXPECT_NEAR(glm::dot(now[k].axes[0], now[k].axes[1]), 0.0F, 1e-4F);
        }
        before = now;
    }
}

TEST(PictureDifferenceTest, KnowsEqualAndOpposite) {
    const std::vector<std::byte> black(64, std::byte{0});
    const std::vector<std::byte> white(64, std::byte{255});
    EXPECT_EQ(picture_difference(black, black).psnr_db, 99.0);
    EXPECT_NEAR(picture_difference(black, white).psnr_db, 0.0, 1e-9);
    std::vector<std::byte> near = black;
    near[0] = std::byte{1};
    EXPECT_NEAR(picture_difference(black, near).psnr_db, 10.0 * std::log10(255.0 * 255.0 * 48.0), 1e-6);
    EXPECT_EQ(picture_difference(black, near).amplified[0], std::byte{16});
    EXPECT_EQ(picture_difference(black, near).amplified[3], std::byte{255});
}

} // namespace
} // namespace alpenglow::sandbox
