#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>

#include <glm/geometric.hpp>

#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/occlusion.hpp>
#include <alpenglow/clouds/vdb.hpp>

#include "one_game.hpp"
#include "sandbox/app/camera_flight.hpp"
#include "sandbox/app/cloud_depth.hpp"
#include "sandbox/app/cloud_scene.hpp"
#ifdef ALPENGLOW_TEST_PROBES
#include "sandbox/app/probe_scene.hpp"
#endif

namespace alpenglow::sandbox {
namespace {

// Small, coarse clouds, so that modelling and lighting take a moment.
Scene cloudy(double time_rate = 0.0) {
    Scene scene = *load_scene("cumulus");
    scene.time_rate = time_rate;
    CloudLayerSettings layer;
    layer.extent_m = 8000.0F;
    layer.voxel_m = 100.0F;
    scene.clouds->layers = {layer};
    return scene;
}

constexpr int width = 192;
constexpr int height = 108;

class CloudSceneTest : public OneGame {
protected:
    static void update(double dt_s) { game_->update(dt_s, width, height); }
};

TEST_F(CloudSceneTest, AStaticSceneBakesAndMarchesOnce) {
    game_->enter(cloudy());
    update(0.0);
    update(1.0 / 60.0);
    const std::uint32_t picture = game_->frame().clouds->revision;
    const std::uint32_t shadow = game_->frame().clouds->shadow.revision;
    for (int frame = 0; frame < 5; ++frame) {
        update(1.0 / 60.0);
        for (const char* system : {"clouds", "cloud_shade", "cloud_view"}) {
            EXPECT_EQ(report(system)->updated, 0U) << system;
        }
    }
    EXPECT_EQ(game_->frame().clouds->revision, picture);
    EXPECT_EQ(game_->frame().clouds->shadow.revision, shadow);
}

TEST_F(CloudSceneTest, TheWindMovesTheShadowWithoutMakingItAgainAndThePictureInPieces) {
    game_->enter(cloudy(1.0));
    game_->part<CloudScene>()->settings.wind_m_s = 50.0F;
    update(0.0);
    update(1.0 / 60.0);
    const CloudShadowMap before = game_->frame().clouds->shadow;
    const std::uint32_t picture = game_->frame().clouds->revision;
    std::uint32_t marched = 0;
    for (int frame = 0; frame < 60; ++frame) {
        update(1.0 / 60.0);
        marched += report("cloud_view")->updated;
    }
    const CloudShadowMap& after = game_->frame().clouds->shadow;
    EXPECT_EQ(after.revision, before.revision);
    EXPECT_NEAR(glm::length(after.offset_m - before.offset_m), 50.0F, 0.5F); // a second of wind
    EXPECT_NE(game_->frame().clouds->revision, picture);
    EXPECT_GT(marched, 0U);
}

// A device that marches gets the tables in place of the picture: bricks and light once, an eye's fields when it has
// moved on, and what drifts in the few words ahead of them.
TEST_F(CloudSceneTest, TheDevicesTablesStayWhileTheyHold) {
    game_->quality = Quality::full;
    game_->storage_bytes = std::uint64_t(1) << 27;
    game_->enter(cloudy(1.0));
    game_->part<CloudScene>()->settings.wind_m_s = 50.0F;
    update(0.0);
    ASSERT_NE(game_->frame().clouds->march, nullptr);
    const CloudMarch before = *game_->frame().clouds->march;
    const std::uint32_t picture = game_->frame().clouds->revision;
    ASSERT_FALSE(before.clouds.empty());
    for (int frame = 0; frame < 30; ++frame) {
        update(1.0 / 60.0);
    }
    const CloudMarch& after = *game_->frame().clouds->march;
    EXPECT_NE(game_->frame().clouds->revision, picture); // the wind has moved it
    ASSERT_EQ(after.tables.size(), before.tables.size());
    for (std::size_t i = 0; i < after.tables.size(); ++i) {
        EXPECT_EQ(after.tables[i].revision, before.tables[i].revision) << i;
    }
    EXPECT_NE(after.clouds.front().eye, before.clouds.front().eye);
    game_->quality = Quality::lean;
}

TEST_F(CloudSceneTest, WhereTheTablesDoNotFitTheCpuMarchesAndTheMessageSaysSo) {
    game_->quality = Quality::full;
    game_->storage_bytes = 4096;
    game_->enter(cloudy());
    update(0.0);
    EXPECT_EQ(game_->frame().clouds->march, nullptr);
    EXPECT_FALSE(game_->frame().clouds->transmittance.empty());
    const std::vector<Error> problems = game_->take_problems();
    ASSERT_EQ(problems.size(), 1U);
    EXPECT_NE(problems[0].message().find("4096 bytes"), std::string::npos) << problems[0].message();
    update(1.0 / 60.0);
    EXPECT_TRUE(game_->take_problems().empty());
    EXPECT_EQ(report("cloud_view")->updated, 0U);
    game_->quality = Quality::lean;
}

// The picture of a moving camera stays until that of the resting one is there, which takes some frames.
TEST_F(CloudSceneTest, ACameraThatComesToRestGetsItsPictureInPieces) {
    game_->enter(cloudy());
    update(0.0);
    const int still = game_->frame().clouds->width;
    for (int frame = 0; frame < 3; ++frame) {
        game_->camera.position_m.x += 3.0F;
        update(1.0 / 60.0);
    }
    const int moving = game_->frame().clouds->width;
    EXPECT_LT(moving, still);
    int frames = 0;
    while (game_->frame().clouds->width == moving && frames < 100) {
        update(1.0 / 60.0);
        const CloudRenderData& clouds = *game_->frame().clouds;
        ASSERT_EQ(clouds.transmittance.size(), std::size_t(clouds.width) * std::size_t(clouds.height));
        ASSERT_EQ(clouds.landscape_m.size(), clouds.transmittance.size());
        ++frames;
    }
    EXPECT_EQ(game_->frame().clouds->width, still);
    EXPECT_GT(frames, 5);
    EXPECT_LT(frames, 20);
}

// What is finer than a voxel changes with time alone: pictures, but neither light nor shadow.
TEST_F(CloudSceneTest, DetailReshapesCloudsWithoutLight) {
    Scene scene = cloudy(1.0);
    scene.clouds->reshape_s = 5.0F;
    scene.clouds->wind_m_s = 0.0F;
    game_->enter(scene);
    update(0.0);
    const std::vector<float> before(game_->frame().clouds->transmittance.begin(),
                                    game_->frame().clouds->transmittance.end());
    const std::uint32_t shadow = game_->frame().clouds->shadow.revision;
    for (int frame = 0; frame < 60; ++frame) {
        update(1.0 / 12.0); // in all the time in which they have become others
        EXPECT_EQ(report("clouds")->updated, 0U);
    }
    const std::span<const float> after = game_->frame().clouds->transmittance;
    ASSERT_EQ(after.size(), before.size());
    double change = 0.0;
    double cover = 0.0;
    for (std::size_t i = 0; i < after.size(); ++i) {
        change += std::abs(double(after[i]) - double(before[i]));
        cover += 1.0 - double(before[i]);
    }
    EXPECT_GT(change, 0.02 * cover);
    EXPECT_LT(change, 0.5 * cover); // the same clouds
    EXPECT_EQ(game_->frame().clouds->shadow.revision, shadow);
}

// What a layer lets through is all that the one below it gets of the sun.
TEST_F(CloudSceneTest, ALayerShadesTheOneBelow) {
    Scene scene = cloudy();
    CloudLayerSettings high = scene.clouds->layers.front();
    high.type = CloudLayerType::stratus;
    high.base_m = 6000.0F;
    high.top_m = 6600.0F;
    const auto shares = [&](float cover) { // of the lower layer, of the one above
        high.cover = cover;
        scene.clouds->layers = {cloudy().clouds->layers.front(), high};
        game_->enter(scene);
        update(0.0);
        const CloudScene& clouds = *game_->part<CloudScene>();
        std::vector<float> found;
        const clouds::CloudLighting* last = nullptr;
        for (const clouds::LitCloud& cloud : clouds.lit_clouds(glm::dvec3(0.0))) {
            if (cloud.lighting != last) {
                found.push_back(cloud.lighting->lights()[0].irradiance.g / clouds.sources().lights[0].irradiance.g);
            }
            last = cloud.lighting;
        }
        update(1.0 / 60.0);
        EXPECT_EQ(report("cloud_view")->updated, 0U); // it is in the first picture already
        return found;
    };
    const std::vector<float> thick = shares(1.0F);
    ASSERT_EQ(thick.size(), 2U);
    EXPECT_LT(thick[0], 0.1F);
    EXPECT_EQ(thick[1], 1.0F);
    const std::vector<float> broken = shares(0.5F);
    EXPECT_GT(broken[0], 0.3F);
    EXPECT_LT(broken[0], 0.9F);
    EXPECT_EQ(broken[1], 1.0F);
}

TEST_F(CloudSceneTest, ClearAndCoveredAreTheEndsOfTheShadow) {
    Scene scene = cloudy();
    scene.clouds->layers.front().cover = 0.0F;
    game_->enter(scene);
    update(0.0);
    for (const std::uint8_t texel : game_->frame().clouds->shadow.texels) {
        ASSERT_EQ(texel, 255);
    }
    const float clear = glm::length(glm::vec3(game_->frame().irradiance_matrix[1][3]));
    scene.clouds->layers.front().type = CloudLayerType::stratus;
    scene.clouds->layers.front().cover = 1.0F;
    game_->enter(scene);
    update(0.0);
    const std::span<const std::uint8_t> texels = game_->frame().clouds->shadow.texels;
    ASSERT_FALSE(texels.empty());
    double sum = 0.0;
    for (const std::uint8_t texel : texels) {
        sum += texel;
    }
    EXPECT_LT(sum / static_cast<double>(texels.size()), 0.1 * 255.0);
    EXPECT_TRUE(std::isfinite(game_->frame().irradiance_matrix[1][3][3]));
    EXPECT_GT(clear, 0.0F);
}

TEST_F(CloudSceneTest, FilesThatAreNoCloudsAreLeftOutAndSaidByName) {
    const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "alpenglow_clouds";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "broken.vdb") << "not a VDB file";
    Scene scene = cloudy();
    scene.clouds->folder = folder.string();
    scene.clouds->files.resize(2);
    scene.clouds->files[0].path = "missing.vdb";
    scene.clouds->files[1].path = "broken.vdb";
    game_->enter(scene);
    const std::vector<Error> problems = game_->take_problems();
    ASSERT_EQ(problems.size(), 2U);
    EXPECT_NE(problems[0].message().find("missing.vdb"), std::string::npos) << problems[0].message();
    EXPECT_NE(problems[1].message().find("broken.vdb"), std::string::npos) << problems[1].message();
    EXPECT_TRUE(game_->take_problems().empty());
    EXPECT_EQ(game_->part<CloudScene>()->clouds(), 1U);
    update(0.0);
    EXPECT_NE(game_->frame().clouds, nullptr);
}

TEST_F(CloudSceneTest, AFileDroppedIntoASceneShowsUpWhereItIsPut) {
    const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "alpenglow_clouds";
    std::filesystem::create_directories(folder);
    const clouds::VdbGrid grid = clouds::vdb_from_sparse(clouds::noise_cloud(7, 32), "density");
    ASSERT_TRUE(clouds::save_vdb((folder / "puff.vdb").string(), std::span(&grid, 1)));
    Scene scene = cloudy();
    scene.clouds->layers.clear();
    scene.clouds->folder = folder.string();
    CloudFileSettings file;
    file.path = "puff.vdb";
    file.scale = 40.0F; // 1 m voxels become 40 m
    const Camera camera = scene_camera(scene);
    file.position_m = camera.position_m + 4000.0F * camera.forward() + 1200.0F * camera.up();
    scene.clouds->files = {file};
    game_->enter(scene);
    EXPECT_TRUE(game_->take_problems().empty());
    update(0.0);
    const CloudRenderData& clouds = *game_->frame().clouds;
    // Its middle is 17 degrees above the view's: in the upper half, in the middle column.
    std::size_t thickest = 0;
    for (std::size_t i = 0; i < clouds.transmittance.size(); ++i) {
        thickest = clouds.transmittance[i] < clouds.transmittance[thickest] ? i : thickest;
    }
    EXPECT_LT(clouds.transmittance[thickest], 0.2F);
    EXPECT_NEAR(clouds.distance_m[thickest], 4176.0F, 800.0F);
    const auto x = static_cast<float>(thickest % static_cast<std::size_t>(clouds.width));
    const auto y = static_cast<float>(thickest / static_cast<std::size_t>(clouds.width));
    EXPECT_NEAR(x / static_cast<float>(clouds.width), 0.5F, 0.2F);
    EXPECT_LT(y / static_cast<float>(clouds.height), 0.5F);
}

// What the panel shows: the scene's own light against its path-traced picture.
TEST_F(CloudSceneTest, TheSceneIsCloseToItsReference) {
    game_->enter(*load_scene("cumulus"));
    update(0.0);
    CloudScene& clouds = *game_->part<CloudScene>();
    clouds.measure_error();
    ASSERT_TRUE(clouds.error().has_value());
    RecordProperty("relative_rmse", std::to_string(clouds.error()->relative_rmse));
    RecordProperty("bias", std::to_string(clouds.error()->bias));
    EXPECT_LT(clouds.error()->relative_rmse, 0.12);
    EXPECT_LT(std::abs(clouds.error()->bias), 0.08); // its light's cells are 120 m: docs/clouds.md
}

// Energy: what a pixel shows of the clouds is finite, at most the light of a white wall in the sun, and none where
// nothing hides the sky.
TEST_F(CloudSceneTest, ThePictureIsSound) {
    game_->enter(cloudy());
    update(0.0);
    const CloudRenderData& clouds = *game_->frame().clouds;
    ASSERT_EQ(clouds.radiance_cd_m2.size(), clouds.transmittance.size());
    const FrameData& frame = game_->frame();
    const float brightest = frame.sun_illuminance_lux.g;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < clouds.transmittance.size(); ++i) {
        ASSERT_GE(clouds.transmittance[i], 0.0F);
        ASSERT_LE(clouds.transmittance[i], 1.0F);
        ASSERT_GE(clouds.radiance_cd_m2[i].g, 0.0F);
        ASSERT_LE(clouds.radiance_cd_m2[i].g, brightest);
        if (clouds.transmittance[i] < 0.5F) {
            ++seen;
            EXPECT_GT(clouds.distance_m[i], 0.0F);
            EXPECT_LT(clouds.distance_m[i], clouds.landscape_m[i]); // nothing behind the mountains
        }
    }
    EXPECT_GT(seen, 100U);
}

TEST_F(CloudSceneTest, TheLandscapesDistanceIsThatOfItsTriangles) {
    game_->enter(cloudy());
    update(0.0);
    const clouds::Camera camera = cloud_camera(game_->camera, width, height, 4);
    std::vector<float> distance;
    const WorldData& data = game_->world().data;
    landscape_distance(camera, data.terrain.vertices, game_->frame().terrain_indices, distance);
    // A ray against every triangle (Moeller and Trumbore 1997).
    const glm::vec3 eye(camera.position_m);
    int hits = 0;
    for (int y = 1; y < camera.height; y += 5) {
        for (int x = 1; x < camera.width; x += 7) {
            const glm::vec3 d = camera.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
            float nearest = 1e30F;
            const auto indices = game_->frame().terrain_indices;
            for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
                const glm::vec3 a = data.terrain.vertices[indices[i]].position_m - eye;
                const glm::vec3 u = data.terrain.vertices[indices[i + 1]].position_m - eye - a;
                const glm::vec3 v = data.terrain.vertices[indices[i + 2]].position_m - eye - a;
                const glm::vec3 p = glm::cross(d, v);
                const float determinant = glm::dot(u, p);
                if (determinant == 0.0F) {
                    continue;
                }
                const float s = -glm::dot(a, p) / determinant;
                const glm::vec3 q = glm::cross(-a, u);
                const float t = glm::dot(d, q) / determinant;
                const float far = glm::dot(v, q) / determinant;
                if (s >= 0.0F && t >= 0.0F && s + t <= 1.0F && far > 1.0F) {
                    nearest = std::min(nearest, far);
                }
            }
            const float found = distance[static_cast<std::size_t>(y * camera.width + x)];
            if (nearest > 1e29F || found > 1e29F) {
                continue; // at the outline a ray may pass between
            }
            ++hits;
            EXPECT_NEAR(found / nearest, 1.0F, 0.02F) << x << ", " << y;
        }
    }
    EXPECT_GT(hits, 5);
}

#ifdef ALPENGLOW_TEST_PROBES
// Probes under a closed deck get the deck's light, those far from any cloud the clear sky's; a static scene looks once.
TEST_F(CloudSceneTest, ProbesSeeTheSkyBehindTheClouds) {
    const auto mean_light = [] { // radiance over all probes and directions
        double sum = 0.0;
        const ProbeGridSh& light = game_->part<ProbeScene>()->grid_light();
        for (std::size_t i = 0; i < light.coefficients.size(); i += light.lines) {
            sum += double(light.coefficients[i].values[0]); // red of Y_0^0
        }
        return sum;
    };
    const auto settle = [] {
        for (int frame = 0; frame < 60; ++frame) {
            update(1.0 / 60.0);
        }
    };
    Scene scene = cloudy();
    scene.probes.emplace();
    const Scene yard = *load_scene("probes");
    scene.camera_position_m = yard.camera_position_m;
    scene.camera_yaw_deg = yard.camera_yaw_deg;
    scene.camera_pitch_deg = yard.camera_pitch_deg;
    scene.clouds->layers.front().type = CloudLayerType::stratus;
    scene.clouds->layers.front().cover = 1.0F;
    game_->enter(scene);
    update(0.0);
    EXPECT_EQ(report("cloud_cover")->updated, 1U);
    settle();
    EXPECT_EQ(report("cloud_cover")->considered, 1U);
    EXPECT_EQ(report("cloud_cover")->updated, 0U);
    EXPECT_EQ(report("probes")->updated, 0U);
    const CloudCoverLight under = *game_->part<ProbeScene>()->cover();
    const double under_light = mean_light();
    const ProbeGrid& grid = game_->part<ProbeScene>()->grid();
    const glm::dvec3 at = 0.5 * glm::dvec3(grid.min_m + grid.max_m);
    const CloudScene& clouds = *game_->part<CloudScene>();
    clouds::SkySh sky;
    sky.bands = 4;
    std::copy_n(game_->sky_light().coefficients.begin(), 16, sky.coefficients.begin());
    const clouds::SkySh exact = clouds::sky_behind_clouds(sky, clouds.lit_clouds(at), at, 2048);
    double difference = 0.0;
    double norm = 0.0;
    for (std::size_t k = 0; k < 16; ++k) {
        const glm::vec3 d = under.sky[k] - exact.coefficients[k];
        difference += double(glm::dot(d, d));
        norm += double(glm::dot(exact.coefficients[k], exact.coefficients[k]));
    }
    EXPECT_LT(std::sqrt(difference / norm), 0.05);
    EXPECT_LT(under.sun, 0.1F);
    EXPECT_LT(under.open, 0.25F); // above the horizon the deck, 24 km wide, has an end

    scene.clouds->layers.front().cover = 0.0F;
    game_->enter(scene);
    update(0.0);
    settle();
    const CloudCoverLight open = *game_->part<ProbeScene>()->cover();
    const double open_light = mean_light();
    EXPECT_EQ(open.sun, 1.0F);
    EXPECT_NEAR(open.open, 1.0F, 1e-3F);
    scene.clouds.reset();
    game_->enter(scene);
    update(0.0);
    settle();
    EXPECT_EQ(game_->part<ProbeScene>()->cover(), nullptr);
    EXPECT_NEAR(open_light / mean_light(), 1.0, 0.02);
    EXPECT_LT(under_light, 0.7 * open_light);
}
#endif

TEST(CameraFlight, PassesThroughItsKeysAndTurnsTheShorterWay) {
    const FlightSettings flight{
        .keys = {{0.0, {0, 0, 100}, 170, 0}, {10.0, {100, 0, 120}, -170, 10}, {25.0, {100, 300, 90}, -90, -10}}};
    for (const FlightKey& key : flight.keys) {
        if (key.time_s >= 25.0) {
            continue; // there the path begins anew
        }
        const FlightKey at = flight_at(flight, key.time_s);
        EXPECT_NEAR(glm::length(at.position_m - key.position_m), 0.0F, 1e-3F);
        EXPECT_NEAR(std::remainder(at.yaw_deg - key.yaw_deg, 360.0F), 0.0F, 1e-3F);
        EXPECT_NEAR(at.pitch_deg, key.pitch_deg, 1e-3F);
    }
    EXPECT_NEAR(std::abs(std::remainder(flight_at(flight, 5.0).yaw_deg - 180.0F, 360.0F)), 0.0F, 5.0F);
    EXPECT_EQ(flight_at(flight, 25.0).position_m, flight.keys.front().position_m);
}

} // namespace
} // namespace alpenglow::sandbox
