#include <sandbox/world/camera.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;

glm::vec3 project(const Camera& camera, glm::vec3 world, float aspect = 16.0F / 9.0F) {
    const glm::vec4 clip = camera.projection(aspect) * camera.view() * glm::vec4(world, 1.0F);
    return glm::vec3(clip) / clip.w;
}

TEST(Camera, YawRunsFromNorthThroughEast) {
    Camera camera;
    EXPECT_NEAR(camera.forward().y, 1.0F, 1e-6F);
    camera.yaw_rad = 0.5F * pi_f;
    EXPECT_NEAR(camera.forward().x, 1.0F, 1e-6F);
    EXPECT_NEAR(camera.right().y, -1.0F, 1e-6F); // looking east, south is to the right
    camera.pitch_rad = 0.25F * pi_f;
    EXPECT_NEAR(camera.forward().z, std::sqrt(0.5F), 1e-6F);
}

TEST(Camera, ProjectsToVulkanClipSpace) {
    Camera camera;
    camera.position_m = {100.0F, -50.0F, 20.0F};
    camera.yaw_rad = 0.7F;
    camera.pitch_rad = -0.2F;
    const glm::vec3 middle = project(camera, camera.position_m + 10.0F * camera.forward());
    EXPECT_NEAR(middle.x, 0.0F, 1e-5F);
    EXPECT_NEAR(middle.y, 0.0F, 1e-5F);
    EXPECT_NEAR(project(camera, camera.position_m + camera.near_m * camera.forward()).z, 0.0F, 1e-5F);
    EXPECT_NEAR(project(camera, camera.position_m + camera.far_m * camera.forward()).z, 1.0F, 1e-5F);
    EXPECT_GT(project(camera, camera.position_m + 10.0F * camera.forward() + camera.right()).x, 0.0F);
    EXPECT_LT(project(camera, camera.position_m + 10.0F * camera.forward() + camera.up()).y, 0.0F); // y down
    // The edge of the field of view is the edge of the image.
    const float edge = std::tan(0.5F * camera.fov_y_rad);
    EXPECT_NEAR(project(camera, camera.position_m + camera.forward() + edge * camera.up()).y, -1.0F, 1e-4F);
}

TEST(Camera, TurnsAndMoves) {
    Camera camera;
    camera.turn(3.0F * pi_f, 100.0F);
    EXPECT_NEAR(std::abs(camera.yaw_rad), pi_f, 1e-4F);
    EXPECT_LT(camera.pitch_rad, 0.5F * pi_f); // never over the top
    camera = Camera{};
    camera.move({1.0F, 2.0F, 3.0F});
    EXPECT_NEAR(camera.position_m.x, 1.0F, 1e-6F);
    EXPECT_NEAR(camera.position_m.y, 3.0F, 1e-6F);
    EXPECT_NEAR(camera.position_m.z, 2.0F, 1e-6F);
    camera.stay_above(10.0F, 2.0F);
    EXPECT_FLOAT_EQ(camera.position_m.z, 12.0F);
}

TEST(Camera, CountsPixelsInTheMiddle) {
    Camera camera;
    const float small = 1e-3F;
    const glm::vec3 p = project(camera, 100.0F * (camera.forward() + small * camera.up()));
    EXPECT_NEAR(-p.y * 270.0F, small * camera.pixels_per_radian(540.0F), 1e-3F);
}

} // namespace
} // namespace alpenglow::sandbox
