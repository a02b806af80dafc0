#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>

#include <glm/geometric.hpp>

#include "sandbox/app/game.hpp"
#include "sandbox/world/landscape_file.hpp"

namespace alpenglow::sandbox {
namespace {

// The landscape takes a while to load: the tests share one game and enter scenes.
class GameTest : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        const std::filesystem::path file = built_landscape();
        game_ = new Game(scene("alpine-morning"), open_world(std::span(&file, 1)).world);
    }
    static void TearDownTestSuite() {
        delete game_;
        game_ = nullptr;
    }
    static Scene scene(const char* name) {
        auto loaded = load_scene(name);
        EXPECT_TRUE(loaded) << name;
        return loaded ? *loaded : Scene{};
    }
    static std::uint32_t updated() {
        std::uint32_t sum = 0;
        for (const SystemReport& report : game_->reports()) {
            sum += report.updated;
        }
        return sum;
    }
    static inline Game* game_ = nullptr;
};

float luminance(const glm::vec3& rgb) {
    return 0.2126F * rgb.r + 0.7152F * rgb.g + 0.0722F * rgb.b;
}

TEST_F(GameTest, AStaticSceneRecomputesNothingAfterTheFirstFrame) {
    Scene still = scene("alpine-morning");
    still.time_rate = 0.0;
    game_->enter(still);
    game_->update(0.0, 960, 540);
    for (int frame = 0; frame < 5; ++frame) {
        game_->update(1.0 / 60.0, 960, 540);
        EXPECT_EQ(updated(), 0U);
        EXPECT_EQ(game_->reports().size(), 6U);
    }
}

TEST_F(GameTest, AtTheRateOfRealTimeNearlyAllFramesAreSkipped) {
    game_->enter(scene("alpine-morning"));
    game_->update(0.0, 960, 540);
    std::uint32_t ephemeris = 0;
    std::uint32_t sky = 0;
    for (int frame = 0; frame < 600; ++frame) { // ten seconds
        game_->update(1.0 / 60.0, 960, 540);
        for (const SystemReport& report : game_->reports()) {
            ephemeris += std::string_view(report.system) == "ephemeris" ? report.updated : 0U;
            sky += std::string_view(report.system) == "sky" ? report.updated : 0U;
        }
    }
    EXPECT_GT(ephemeris, 0U);
    EXPECT_LT(ephemeris, 120U);
    EXPECT_LT(sky, 12U);
}

TEST_F(GameTest, ExposureFollowsTheLightFromNoonToNight) {
    game_->enter(scene("noon"));
    game_->update(0.0, 960, 540);
    const float noon = game_->frame().exposure;
    game_->enter(scene("full-moon-night"));
    game_->update(0.0, 960, 540);
    const float night = game_->frame().exposure;
    EXPECT_GT(night / noon, 1e4F);
    EXPECT_EQ(luminance(game_->frame().sun_illuminance_lux), 0.0F);
    EXPECT_GT(luminance(game_->frame().moon_illuminance_lux), 0.01F);
}

TEST_F(GameTest, NoonIsBlueAboveAndBrighterAtTheHorizon) {
    game_->enter(scene("noon"));
    game_->update(0.0, 960, 540);
    const auto sky = game_->frame().sky_vertices;
    const glm::vec3 to_sun = game_->frame().to_sun;
    float horizon = 0.0F;
    float high = 0.0F;
    int horizon_count = 0;
    int high_count = 0;
    for (const SkyVertex& vertex : sky) {
        if (glm::dot(vertex.direction, to_sun) > 0.5F) {
            continue; // away from the sun's glare
        }
        if (vertex.direction.z < 0.05F) {
            horizon += luminance(vertex.radiance_cd_m2);
            ++horizon_count;
        } else if (vertex.direction.z > 0.6F) {
            EXPECT_GT(vertex.radiance_cd_m2.b, vertex.radiance_cd_m2.r);
            high += luminance(vertex.radiance_cd_m2);
            ++high_count;
        }
    }
    ASSERT_GT(horizon_count, 0);
    ASSERT_GT(high_count, 0);
    EXPECT_GT(horizon / static_cast<float>(horizon_count), high / static_cast<float>(high_count));
}

TEST_F(GameTest, TheSunIsWhereTheSceneSaysItIs) {
    game_->enter(scene("alpine-morning"));
    game_->update(0.0, 960, 540);
    EXPECT_GT(game_->frame().to_sun.x, 0.5F); // east
    EXPECT_GT(game_->frame().to_sun.z, 0.1F);
    game_->enter(scene("southern-summer"));
    game_->update(0.0, 960, 540);
    EXPECT_GT(game_->frame().to_sun.z, 0.0F);
    game_->enter(scene("polar-summer"));
    game_->update(0.0, 960, 540);
    EXPECT_GT(game_->frame().to_sun.z, 0.0F); // the midnight sun
}

TEST_F(GameTest, FramesAreTheSameTwice) {
    const auto run = [] {
        game_->enter(scene("sunset"));
        game_->update(0.0, 640, 360);
        for (int i = 0; i < 3; ++i) {
            game_->update(1.0 / 60.0, 640, 360);
        }
        return game_->frame();
    };
    const FrameData first = run();
    const std::vector<std::uint32_t> indices(first.terrain_indices.begin(), first.terrain_indices.end());
    const FrameData second = run();
    EXPECT_EQ(first.exposure, second.exposure);
    EXPECT_EQ(first.to_sun, second.to_sun);
    ASSERT_EQ(indices.size(), second.terrain_indices.size());
    EXPECT_EQ(std::memcmp(indices.data(), second.terrain_indices.data(), indices.size() * sizeof(std::uint32_t)), 0);
}

} // namespace
} // namespace alpenglow::sandbox
