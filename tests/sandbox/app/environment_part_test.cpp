// A scene whose light is a picture.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include <glm/geometric.hpp>

#include "sandbox/app/game.hpp"
#include "sandbox/app/probe_scene.hpp"
#include "sandbox/world/environment_render_data.hpp"
#include "sandbox/world/landscape_file.hpp"

namespace alpenglow::sandbox {
namespace {

// A flat Radiance file of one colour.
std::filesystem::path write_picture(const char* name) {
    const std::filesystem::path file = std::filesystem::temp_directory_path() / name;
    std::ofstream out(file, std::ios::binary);
    out << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n";
    constexpr std::array<std::uint8_t, 4> texel{128, 64, 32, 129}; // 1, 1/2, 1/4
    for (int i = 0; i < 16 * 32; ++i) {
        out.write(reinterpret_cast<const char*>(texel.data()), texel.size());
    }
    return file;
}

const SystemReport* report(const Game& game, std::string_view system) {
    for (const SystemReport& r : game.reports()) {
        if (r.system == system) {
            return &r;
        }
    }
    return nullptr;
}

TEST(EnvironmentPart, PictureTakesThePlaceOfSkyAndSun) {
    const std::filesystem::path landscape = built_landscape();
    Scene scene = *load_scene("probes");
    scene.time_rate = 0.0;
    scene.environment = EnvironmentSettings{.file = write_picture("alpenglow_environment.hdr"), .scale = 2000.0F};
    Game game(scene, open_world(std::span(&landscape, 1)).world);
    EXPECT_TRUE(game.take_problems().empty());
    game.update(0.0, 320, 180);
    ASSERT_NE(game.frame().environment, nullptr);
    EXPECT_EQ(game.frame().environment->width, 32);
    EXPECT_EQ(glm::length(game.frame().sun_illuminance_lux), 0.0F);
    // Uniform light: the irradiance is pi times the radiance, whatever the normal; and so a probe's mean.
    constexpr float pi = 3.14159265F;
    for (const glm::vec3 normal : {glm::vec3(0, 0, 1), glm::vec3(1, 0, 0), glm::vec3(0, 0, -1)}) {
        const glm::vec4 n(normal, 1.0F);
        EXPECT_NEAR(glm::dot(n, game.frame().irradiance_matrix[0] * n), pi * 2000.0F, 5.0F);
        EXPECT_NEAR(glm::dot(n, game.frame().irradiance_matrix[2] * n), pi * 500.0F, 2.0F);
    }
    for (const SkyVertex& vertex : game.frame().sky_vertices) {
        ASSERT_NEAR(vertex.radiance_cd_m2.g, 1000.0F, 1.0F);
    }
    EXPECT_EQ(report(game, "environment")->updated, 1U);
    const float exposure = game.frame().exposure;
    game.update(1.0 / 60.0, 320, 180); // time stands still: nothing to do
    EXPECT_EQ(report(game, "environment")->updated, 0U);
    EXPECT_EQ(game.frame().exposure, exposure);

    const std::uint32_t pictured = game.frame().sky_revision;
    game.enter(*load_scene("noon"));
    game.update(0.0, 320, 180);
    EXPECT_EQ(game.frame().environment, nullptr);
    EXPECT_GT(glm::length(game.frame().sun_illuminance_lux), 1e4F);
    EXPECT_NE(game.frame().sky_revision, pictured);
    EXPECT_EQ(report(game, "environment"), nullptr);
}

TEST(EnvironmentPart, AMissingPictureIsNamedAndTheSceneGoesOn) {
    const std::filesystem::path landscape = built_landscape();
    Scene scene = *load_scene("noon");
    scene.environment = EnvironmentSettings{.file = "/nowhere/forest.hdr"};
    Game game(scene, open_world(std::span(&landscape, 1)).world);
    const std::vector<Error> problems = game.take_problems();
    ASSERT_EQ(problems.size(), 1U);
    EXPECT_NE(problems[0].message().find("forest.hdr"), std::string::npos);
    EXPECT_TRUE(game.take_problems().empty());
    game.update(0.0, 320, 180);
    EXPECT_EQ(game.frame().environment, nullptr);
    EXPECT_GT(glm::length(game.frame().sun_illuminance_lux), 1e4F);
}

} // namespace
} // namespace alpenglow::sandbox
