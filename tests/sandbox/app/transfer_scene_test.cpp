// Scene `transfer`: bakes in the background and their cache, light on what stands there, and what is left alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <glm/geometric.hpp>

#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/transfer_file.hpp>
#include <alpenglow/sh/dering.hpp>

#include "one_game.hpp"
#include "sandbox/app/transfer_scene.hpp"
#include "sandbox/app/transfer_shapes.hpp"
#include "sandbox/world/transfer_render_data.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr double frame_s = 1.0 / 60.0;

// One landscape and one cache for all tests.
class TransferSceneTest : public OneGame {
protected:
    static void SetUpTestSuite() {
        cache_ = std::filesystem::temp_directory_path() / ("alpenglow-transfer-test-" + std::to_string(::getpid()));
        std::filesystem::remove_all(cache_);
        setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
        OneGame::SetUpTestSuite();
    }
    static void TearDownTestSuite() {
        OneGame::TearDownTestSuite();
        std::filesystem::remove_all(cache_);
    }
    static Scene scene(double time_rate = 0.0) {
        Scene scene = *load_scene("transfer");
        scene.time_rate = time_rate;
        scene.transfer->detail = 0.1F; // bakes of a fraction of a second
        return scene;
    }
    static void enter(const Scene& scene) {
        game_->enter(scene);
        game_->wait();
    }
    static void update(int frames) {
        for (int i = 0; i < frames; ++i) {
            game_->update(frame_s, 960, 540);
        }
    }
    static TransferScene& part() { return *game_->part<TransferScene>(); }
    static const TransferRenderData& drawn() { return *game_->frame().transfer; }
    static double sum(const TransferBody& body) {
        double total = 0.0;
        for (const glm::vec3& c : body.light) {
            total += static_cast<double>(c.r + c.g + c.b);
        }
        return total;
    }
    static inline std::filesystem::path cache_;
};

TEST_F(TransferSceneTest, OtherScenesDoNoWorkForIt) {
    game_->enter(*load_scene("noon"));
    update(2);
    EXPECT_EQ(report("transfer"), nullptr);
    EXPECT_EQ(report("transfer_scene"), nullptr);
    EXPECT_EQ(game_->part<TransferScene>(), nullptr);
    EXPECT_EQ(game_->frame().transfer, nullptr);
}

TEST_F(TransferSceneTest, StaticLightIsEvaluatedOnceAndThenSkipped) {
    enter(scene());
    update(1);
    const std::uint32_t entities = report("transfer")->considered;
    EXPECT_GE(entities, 9U);
    EXPECT_EQ(report("transfer")->updated, entities);
    for (int frame = 0; frame < 4; ++frame) {
        update(1);
        for (const SystemReport& r : game_->reports()) {
            EXPECT_EQ(r.updated, 0U) << r.system;
        }
        EXPECT_EQ(report("transfer")->skipped, entities);
        EXPECT_EQ(report("transfer_scene")->skipped, report("transfer_scene")->considered);
    }
}

TEST_F(TransferSceneTest, TheSunMovesAndEverythingResponds) {
    enter(scene());
    update(1);
    std::vector<double> before;
    for (const TransferBody& body : drawn().bodies) {
        before.push_back(sum(body));
    }
    const auto smoke = std::vector<SmokeVertex>(drawn().smoke_vertices.begin(), drawn().smoke_vertices.end());
    game_->clock().utc_j2000_s += 5400.0;
    update(1);
    EXPECT_EQ(report("transfer")->updated, report("transfer")->considered);
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_GT(std::abs(sum(drawn().bodies[i]) / before[i] - 1.0), 0.02) << i;
    }
    ASSERT_EQ(drawn().smoke_vertices.size(), smoke.size());
    EXPECT_FALSE(std::equal(smoke.begin(), smoke.end(), drawn().smoke_vertices.begin(),
                            [](const SmokeVertex& a, const SmokeVertex& b) { return a.radiance == b.radiance; }));
}

TEST_F(TransferSceneTest, LevelsDifferAsTheyShould) {
    enter(scene());
    std::array<double, 3> figure{};
    for (const TransferLevel level :
         {TransferLevel::interreflected, TransferLevel::shadowed, TransferLevel::unshadowed}) {
        part().settings.level = level;
        update(1);
        EXPECT_GT(report("transfer")->updated, 0U);
        figure[static_cast<std::size_t>(level)] = sum(drawn().bodies[0]);
        update(1);
        EXPECT_EQ(report("transfer")->updated, 0U);
    }
    // Shadows take light away, bounces bring some of it back.
    EXPECT_LT(figure[1], 0.97 * figure[0]);
    EXPECT_GT(figure[2], 1.02 * figure[1]);
    EXPECT_LT(figure[2], figure[0]);
    EXPECT_TRUE(part().press('T'));
    EXPECT_EQ(part().settings.level, TransferLevel::shadowed);
    EXPECT_FALSE(part().press('Q'));
}

TEST_F(TransferSceneTest, TheGlidersShadowMovesAndNothingElse) {
    enter(scene(1.0));
    update(1);
    const std::size_t ground = part().mound();
    const std::size_t glider = part().glider();
    part().settings.level = TransferLevel::unshadowed;
    update(2);
    const auto open = std::vector<glm::vec3>(drawn().bodies[ground].light.begin(), drawn().bodies[ground].light.end());
    part().settings.level = TransferLevel::shadowed;
    update(2);
    // Frames in which neither the sky nor any other body changes, while the shadow goes on.
    std::vector<std::uint32_t> revisions;
    for (const TransferBody& body : drawn().bodies) {
        revisions.push_back(body.light_revision);
    }
    const glm::vec3 was = drawn().bodies[glider].position_m;
    update(3);
    EXPECT_GT(glm::distance(drawn().bodies[glider].position_m, was), 0.01F);
    for (std::size_t i = 0; i < revisions.size(); ++i) {
        if (i == ground) {
            EXPECT_NE(drawn().bodies[i].light_revision, revisions[i]);
        } else if (i != glider) {
            EXPECT_EQ(drawn().bodies[i].light_revision, revisions[i]) << i;
        }
    }
    // Under the glider it is darker than where it was without it, by more than the ground's own shadows vary.
    game_->update(6.0, 960, 540);
    const auto later = std::vector<glm::vec3>(drawn().bodies[ground].light.begin(), drawn().bodies[ground].light.end());
    game_->update(6.0, 960, 540);
    float deepest = 1.0F;
    for (std::size_t v = 0; v < later.size(); ++v) {
        const float now = drawn().bodies[ground].light[v].g;
        if (later[v].g > 0.1F * open[v].g && now > 0.1F * open[v].g) {
            deepest = std::min({deepest, now / later[v].g, later[v].g / now});
        }
    }
    EXPECT_LT(deepest, 0.9F);
}

TEST_F(TransferSceneTest, SecondEntryReadsTheCacheAndShowsTheSame) {
    enter(scene());
    update(1);
    const std::vector<glm::vec3> first(drawn().bodies[0].light.begin(), drawn().bodies[0].light.end());
    enter(scene());
    const TransferBakes::State state = part().bakes();
    EXPECT_EQ(state.from_cache, state.done);
    EXPECT_GT(state.done, 5U);
    EXPECT_EQ(state.failed, 0U);
    update(1);
    ASSERT_EQ(drawn().bodies[0].light.size(), first.size());
    EXPECT_TRUE(std::equal(first.begin(), first.end(), drawn().bodies[0].light.begin()));
}

TEST_F(TransferSceneTest, DamagedCacheFilesAreBakedAnew) {
    enter(scene());
    for (const auto& entry : std::filesystem::directory_iterator(cache_ / "alpenglow")) {
        std::filesystem::resize_file(entry.path(), entry.file_size() / 2);
        break;
    }
    enter(scene());
    EXPECT_EQ(part().bakes().failed, 0U);
    EXPECT_EQ(part().bakes().from_cache + 1, part().bakes().done);
}

TEST_F(TransferSceneTest, WithoutACacheItBakesEachTime) {
    const std::filesystem::path file = cache_ / "no-folder";
    std::ofstream(file) << "a file";
    setenv("XDG_CACHE_HOME", file.c_str(), 1);
    enter(scene());
    setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
    EXPECT_EQ(part().bakes().failed, 0U);
    EXPECT_EQ(part().bakes().from_cache, 0U);
    EXPECT_FALSE(part().bakes().problem.empty());
    update(1);
    EXPECT_GT(sum(drawn().bodies[0]), 0.0);
}

TEST_F(TransferSceneTest, WhileItBakesTheCosineAloneIsShown) {
    Scene unseen = scene();
    unseen.transfer->detail = 0.11F; // not in the cache
    game_->enter(unseen);
    update(1); // at once: nothing is waited for
    EXPECT_GT(sum(drawn().bodies[0]), 0.0);
    game_->enter(*load_scene("noon")); // cancels
}

TEST_F(TransferSceneTest, WindowsKeepWhatTheyNameFromGoingNegative) {
    enter(scene());
    float left = 1.0F;
    for (const TransferWindow window :
         {TransferWindow::none, TransferWindow::irradiance, TransferWindow::halfway, TransferWindow::radiance}) {
        part().settings.window = window;
        update(1);
        const TransferLight& light = part().light();
        EXPECT_LE(light.window, left);
        left = light.window;
        // The lowest radiance over its mean.
        const auto lowest = [](const std::vector<glm::vec3>& coefficients) {
            double least = 0.0;
            for (int channel = 0; channel < 3; ++channel) {
                std::vector<double> c;
                for (const glm::vec3& coefficient : coefficients) {
                    c.push_back(static_cast<double>(coefficient[channel]));
                }
                least = std::min(least, sh::certified_minimum(transfer_bands, c, 1e-4 * c[0]).value / c[0]);
            }
            return least;
        };
        EXPECT_GT(lowest(light.sure), -1e-3);
        if (window == TransferWindow::radiance) {
            EXPECT_EQ(light.coefficients, light.sure);
        } else {
            EXPECT_LT(lowest(light.coefficients), -0.01);
        }
    }
    EXPECT_GT(left, 0.3F);
    EXPECT_LT(left, 1.0F);
}

TEST_F(TransferSceneTest, OutOfViewNothingIsLitOrDrawn) {
    enter(scene(1.0));
    game_->camera.turn(3.14F, 0.0F);
    game_->camera.position_m.y -= 60.0F;
    update(2);
    EXPECT_EQ(game_->frame().transfer, nullptr);
    EXPECT_EQ(report("transfer")->updated, 0U);
    EXPECT_EQ(report("transfer")->skipped, report("transfer")->considered);
    EXPECT_EQ(report("transfer_scene")->updated, 0U);
}

// What goes to the vertex shader is what the CPU would have evaluated.
TEST_F(TransferSceneTest, ShadersGetTheSameTablesAndLight) {
    enter(scene());
    update(1);
    const std::vector<glm::vec3> cpu(drawn().bodies[0].light.begin(), drawn().bodies[0].light.end());
    part().settings.path = TransferPath::shader;
    update(1);
    EXPECT_TRUE(drawn().by_shader);
    const TransferBody& body = drawn().bodies[0];
    ASSERT_EQ(body.diffuse.coefficients, 25U);
    ASSERT_EQ(body.diffuse.light.size(), 25U);
    prt::TransferTable table;
    table.info.encoding = prt::Encoding::f16;
    table.info.order = transfer_bands;
    table.info.channels = body.diffuse.channels;
    table.info.count = cpu.size();
    table.info.slots = (cpu.size() + prt::block_points - 1) / prt::block_points * prt::block_points;
    table.blocks = body.diffuse.blocks;
    std::vector<glm::vec3> out(cpu.size());
    prt::evaluate_scalar(table, body.diffuse.light, out);
    for (std::size_t v = 0; v < cpu.size(); ++v) {
        const glm::vec3 shown = body.light[v] * body.vertices[v].albedo * glm::max(out[v], glm::vec3(0.0F));
        EXPECT_LT(glm::distance(shown, cpu[v]), 1e-4F * (1.0F + glm::length(cpu[v]))) << v;
    }
    for (int frame = 0; frame < 2; ++frame) {
        update(1);
        EXPECT_EQ(report("transfer")->updated, 0U);
        EXPECT_EQ(report("transfer_scene")->updated, 0U);
    }
}

TEST_F(TransferSceneTest, AMeshThatCannotBeReadIsSaidAndTheFigureStands) {
    Scene broken = scene();
    broken.transfer->mesh = "/nowhere/statue.glb";
    enter(broken);
    update(1);
    EXPECT_GT(sum(drawn().bodies[0]), 0.0);
}

// Closed, outwards, and on the surface.
TEST(TransferShapes, SurfaceNetsOfASphere) {
    const prt::Mesh mesh =
        surface_nets([](const glm::vec3& p) { return glm::length(p) - 0.8F; }, glm::vec3(-1.0F), glm::vec3(1.0F), 0.1F);
    ASSERT_GT(mesh.positions.size(), 300U);
    double volume = 0.0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.x]);
        volume += glm::dot(a, glm::cross(glm::dvec3(mesh.positions[t.y]), glm::dvec3(mesh.positions[t.z]))) / 6.0;
    }
    EXPECT_NEAR(volume, 4.0 / 3.0 * 3.14159265 * 0.512, 0.03);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        EXPECT_NEAR(glm::length(mesh.positions[v]), 0.8F, 0.01F);
        EXPECT_GT(glm::dot(mesh.normals[v], glm::normalize(mesh.positions[v])), 0.99F);
    }
}

TEST(TransferShapes, AllFaceOutwards) {
    const auto white = [](float) { return glm::vec3(0.5F); };
    for (const prt::Mesh& mesh :
         {make_figure(0.08F), make_disc(1.0F, 0.2F, 24, 8, white), make_knot(0.7F, 0.15F, 60, 10, {}),
          make_ring(0.6F, 0.7F, 0.3F, 40, 3, {}), make_brazier(16, {}), make_glider(3.0F, 6)}) {
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
        ASSERT_EQ(mesh.albedo.size(), mesh.positions.size());
        std::size_t agree = 0;
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::vec3 face =
                glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
            const glm::vec3 normal = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
            agree += glm::dot(face, normal) >= 0.0F ? 1 : 0;
        }
        EXPECT_GT(agree, 0.97 * static_cast<double>(mesh.triangles.size()));
    }
}

} // namespace
} // namespace alpenglow::sandbox
