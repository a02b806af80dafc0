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
#include "sandbox/app/impostor_inside.hpp"
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
    const Scene scene = *load_scene("squadron");
    for (int i = 0; i < 60; ++i) { // from the first frame on
        update();
        EXPECT_LE(part().capture_units(), 1.5 * scene.impostors->budget_texels) << i;
    }
    EXPECT_EQ(part().schedule().unserved, 0U);
    double seen = 0.0;
    double reused = 0.0;
    bool divided = false;
    for (int i = 0; i < 150; ++i) {
        update();
        const impostors::ScheduleReport& schedule = part().schedule();
        seen += schedule.seen;
        reused += schedule.reused;
        EXPECT_LE(part().capture_units(), 1.5 * scene.impostors->budget_texels);
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

// Through clouds: their screen-aligned pictures are used again too.
TEST_F(ImpostorSceneTest, AFlightThroughCloudsUsesPicturesAgainWithinItsBudget) {
    Scene scene = *load_scene("fly-through");
    game_->enter(scene);
    update(40);
    double seen = 0.0;
    double reused = 0.0;
    int inside = 0;
    for (int i = 0; i < 110; ++i) { // by then it is on its way out of the first
        update();
        seen += part().schedule().seen;
        reused += part().schedule().reused;
        inside += part().schedule().inside > 0 ? 1 : 0;
        EXPECT_LE(part().capture_units(), 1.5 * scene.impostors->budget_texels) << i;
    }
    EXPECT_GT(inside, 80);
    EXPECT_GE(reused / seen, 0.95);
}

// The default scene's walk: gentle, above the ground, and the player's as soon as he moves.
TEST_F(ImpostorSceneTest, TheCameraFollowsItsPathUntilThePlayerTakesOver) {
    Scene scene = *load_scene(std::string(default_scene));
    ASSERT_TRUE(scene.flight);
    EXPECT_EQ(scene.flight->keys.front().position_m, scene.camera_position_m); // the first picture is the scene's own
    scene.impostors.reset();
    scene.probes.reset();
    scene.transfer.reset();
    game_->enter(scene);
    game_->update(0.0, 480, 270);
    glm::vec3 before = game_->camera.position_m;
    EXPECT_EQ(before, scene.camera_position_m);
    for (int frame = 1; frame < 600; ++frame) {
        game_->update(1.0 / 60.0, 480, 270);
        const glm::vec3 now = game_->camera.position_m;
        EXPECT_LT(glm::length(now - before), 2.0F / 60.0F) << frame; // a walk
        EXPECT_GT(now.z, game_->world().terrain.height_m(glm::vec2(now)) + 1.7F);
        before = now;
    }
    EXPECT_GT(glm::length(before - scene.camera_position_m), 3.0F);
    game_->camera.turn(0.01F, 0.0F);
    const float yaw = game_->camera.yaw_rad;
    update(5);
    EXPECT_EQ(game_->camera.position_m, before);
    EXPECT_EQ(game_->camera.yaw_rad, yaw);
    for (const std::unique_ptr<Part>& part : game_->parts()) {
        part->press('P');
    }
    update(5);
    EXPECT_NE(game_->camera.position_m, before); // on it goes
}

// A window that changes its size in the middle of a cloud, and a jump to another one.
TEST_F(ImpostorSceneTest, AResizeAndAJumpAreShownAtOnce) {
    game_->enter(*load_scene("fly-through"));
    update(60);
    for (const glm::ivec2 size : {glm::ivec2(640, 200), glm::ivec2(97, 331), glm::ivec2(480, 270)}) {
        for (int i = 0; i < 12; ++i) {
            game_->update(1.0 / 60.0, size.x, size.y);
            EXPECT_FALSE(drawn().indices.empty());
            for (const ImpostorTile& tile : drawn().tiles) {
                EXPECT_LE(tile.x + tile.width, drawn().atlas_width);
                EXPECT_LE(tile.y + tile.height, drawn().atlas_height);
                EXPECT_EQ(tile.texels.size(),
                          static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height));
            }
        }
    }
    game_->camera.position_m += glm::vec3(2000.0F, 1500.0F, 0.0F); // the player's doing: the path lets go
    game_->camera.turn(2.0F, 0.1F);
    update(30);
    EXPECT_EQ(part().schedule().unserved, 0U);
    EXPECT_FALSE(drawn().indices.empty());
}

TEST(ViewPredictionTest, GoesOnAsBefore) {
    const auto view = [](int frame) {
        return impostors::look_at({3.0 * frame, 2.0 * frame, 100.0},
                                  {3.0 * frame + std::sin(0.01 * frame), 2.0 * frame + std::cos(0.01 * frame), 100.1},
                                  {0.0, 0.0, 1.0}, 0.9, 320, 180);
    };
    ViewPrediction prediction;
    prediction.see(view(10));
    prediction.see(view(11));
    const impostors::Frustum then = prediction.after(6);
    EXPECT_LT(glm::length(then.eye_m - view(17).eye_m), 1e-9);
    EXPECT_LT(glm::length(then.forward - view(17).forward), 1e-6);
    EXPECT_LT(glm::length(then.up - view(17).up), 1e-6);
    prediction.see(view(11));
    EXPECT_EQ(prediction.after(6).eye_m, view(11).eye_m); // stands still
    prediction.see(view(400));
    EXPECT_EQ(prediction.after(6).eye_m, view(400).eye_m); // a jump is not a flight
}

TEST(ViewPredictionTest, KnowsWhatAPictureCovers) {
    const impostors::Frustum view =
        impostors::look_at(glm::dvec3(0.0), {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, 0.9, 320, 180);
    const impostors::Frustum wide = impostors::screen_aligned(view, 3.0, 0.05);
    EXPECT_TRUE(covers(view, view, 1e-9));
    EXPECT_TRUE(covers(wide, view, 0.0));
    EXPECT_FALSE(covers(view, wide, 0.01));
    const impostors::Frustum turned =
        impostors::look_at(glm::dvec3(0.0), {0.5, 1.0, 0.0}, {0.0, 0.0, 1.0}, 0.9, 320, 180);
    EXPECT_FALSE(covers(wide, turned, 0.01));
    const impostors::Frustum rolled =
        impostors::look_at(glm::dvec3(0.0), {0.0, 1.0, 0.0}, {1.0, 0.0, 0.3}, 0.9, 320, 180);
    EXPECT_FALSE(covers(wide, rolled, 0.01));
}

TEST(TemporalDifferenceTest, CountsWhatComesAtOnceAndNotWhatStays) {
    const std::vector<std::byte> dark(64, std::byte{10});
    const std::vector<std::byte> bright(64, std::byte{110});
    const std::vector<std::byte> off(64, std::byte{14});             // wrong by 4
    EXPECT_EQ(temporal_difference(dark, bright, dark, bright), 0.0); // both change alike
    EXPECT_EQ(temporal_difference(off, off, dark, dark), 0.0);       // wrong as before
    EXPECT_NEAR(temporal_difference(dark, off, dark, dark), 4.0, 1e-12);
    EXPECT_NEAR(temporal_difference(off, dark, dark, dark), 4.0, 1e-12);
    EXPECT_NEAR(temporal_difference(dark, dark, dark, bright), 100.0, 1e-12);
    std::vector<std::byte> alpha = dark;
    for (std::size_t i = 3; i < alpha.size(); i += 4) {
        alpha[i] = std::byte{200};
    }
    EXPECT_EQ(temporal_difference(dark, alpha, dark, dark), 0.0);
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
