#include "sandbox/render/gpu_data.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "sandbox/render/sky_dome.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

glm::mat4 projection(float near_m, float far_m) {
    glm::mat4 p = glm::perspectiveRH_ZO(0.9F, 16.0F / 9.0F, near_m, far_m);
    p[1][1] = -p[1][1];
    return p;
}

TEST(ReversedDepthTest, NearIsOneFarIsZeroAndTheRestUnchanged) {
    const glm::mat4 standard = projection(1.0F, 200000.0F);
    const glm::mat4 reversed = reversed_depth(standard);
    for (const float distance : {1.0F, 3.0F, 100.0F, 5000.0F, 200000.0F}) {
        const glm::vec4 point(0.3F * distance, -0.2F * distance, -distance, 1.0F);
        const glm::vec4 a = standard * point;
        const glm::vec4 b = reversed * point;
        EXPECT_FLOAT_EQ(a.x, b.x);
        EXPECT_FLOAT_EQ(a.y, b.y);
        EXPECT_FLOAT_EQ(a.w, b.w);
        EXPECT_NEAR(a.z / a.w + b.z / b.w, 1.0F, 1e-5F);
    }
    // Surfaces 10 m apart are told apart out to 100 km.
    const auto depth = [&reversed](float d) { return (reversed * glm::vec4(0, 0, -d, 1)).z / d; };
    for (float distance = 10.0F; distance < 100000.0F; distance += 10.0F) {
        ASSERT_GT(depth(distance), depth(distance + 10.0F)) << distance;
    }
}

// The mean over the disc by summing over its points.
float integrate_moon(float phase) {
    const glm::vec3 to_observer(0.0F, 0.0F, 1.0F);
    const glm::vec3 to_sun(std::sin(phase), 0.0F, std::cos(phase));
    double sum = 0.0;
    int count = 0;
    constexpr int kSteps = 400;
    for (int j = 0; j < kSteps; ++j) {
        for (int i = 0; i < kSteps; ++i) {
            const float x = (static_cast<float>(i) + 0.5F) / kSteps * 2.0F - 1.0F;
            const float y = (static_cast<float>(j) + 0.5F) / kSteps * 2.0F - 1.0F;
            const float r2 = x * x + y * y;
            if (r2 < 1.0F) {
                sum += std::max(glm::dot(glm::vec3(x, y, std::sqrt(1.0F - r2) * to_observer.z), to_sun), 0.0F);
                ++count;
            }
        }
    }
    return static_cast<float>(sum / count);
}

TEST(MoonTest, MeanCosineOfALambertianBall) {
    EXPECT_NEAR(moon_disc_mean_cosine(1.0F), 2.0F / 3.0F, 1e-6F);
    EXPECT_NEAR(moon_disc_mean_cosine(-1.0F), 0.0F, 1e-6F);
    for (const float phase : {0.0F, 0.5F, 1.2F, kPi / 2.0F, 2.2F, 2.9F}) {
        EXPECT_NEAR(moon_disc_mean_cosine(std::cos(phase)), integrate_moon(phase), 2e-3F) << phase;
    }
    EXPECT_TRUE(std::isfinite(moon_disc_mean_cosine(1.0000001F)));
}

// Light that falls in from the disc equals the light that was given: radiance times solid angle.
TEST(FrameBlockTest, DiscsGiveTheirIlluminance) {
    FrameData frame;
    frame.projection = projection(1.0F, 1000.0F);
    frame.exposure = 0.01F;
    frame.to_sun = glm::normalize(glm::vec3(0.5F, 0.2F, 0.4F));
    frame.to_moon = glm::normalize(glm::vec3(-0.3F, 0.9F, 0.3F));
    frame.sun_illuminance_lux = {90000.0F, 80000.0F, 70000.0F};
    frame.moon_illuminance_lux = {0.2F, 0.19F, 0.18F};
    const gpu::FrameBlock block = make_frame_block(frame, {}, 540);
    const float sun_angle = kPi * std::pow(std::sin(frame.sun_angular_radius_rad), 2.0F);
    EXPECT_NEAR(block.sun_disc.x * sun_angle / frame.exposure, 90000.0F, 1.0F);
    const float moon_angle = kPi * std::pow(std::sin(frame.moon_angular_radius_rad), 2.0F);
    const float phase = std::acos(-glm::dot(frame.to_moon, frame.to_sun));
    EXPECT_NEAR(block.moon_disc.y * moon_angle * integrate_moon(phase) / frame.exposure, 0.19F, 0.001F);
    // Lambert: irradiance over pi, exposed.
    EXPECT_FLOAT_EQ(block.sun.z, 70000.0F * 0.01F / kPi);
    EXPECT_FLOAT_EQ(block.sun.w, frame.exposure);
}

TEST(FrameBlockTest, NewMoonIsDarkAndFinite) {
    FrameData frame;
    frame.to_moon = frame.to_sun;
    frame.moon_illuminance_lux = glm::vec3(1e-6F);
    const gpu::FrameBlock block = make_frame_block(frame, {}, 540);
    EXPECT_EQ(block.moon_disc.x, 0.0F);
}

// Word k / 4, byte k % 4 holds azimuth k.
TEST(FrameBlockTest, HorizonSectorsBracketTheLight) {
    FrameData frame;
    for (int i = 0; i < 720; ++i) {
        const float azimuth = static_cast<float>(i) * kPi / 360.0F;
        frame.to_sun = {std::sin(azimuth), std::cos(azimuth), 0.0F};
        const gpu::FrameBlock block = make_frame_block(frame, {}, 540);
        const std::uint32_t first = block.sun_sector.x * 4 + block.sun_sector.y / 8;
        const std::uint32_t second = block.sun_sector.z * 4 + block.sun_sector.w / 8;
        ASSERT_LT(first, 16U);
        ASSERT_EQ(second, (first + 1) % 16);
        ASSERT_EQ(block.sun_sector.y % 8, 0U);
        ASSERT_GE(block.sector.x, 0.0F);
        ASSERT_LE(block.sector.x, 1.0F);
        const float between = (static_cast<float>(first) + block.sector.x) * kPi / 8.0F;
        EXPECT_NEAR(std::remainder(between - azimuth, 2.0F * kPi), 0.0F, 1e-5F);
    }
}

TEST(FrameBlockTest, CameraBehindAMountainStandsInTheShade) {
    FrameData frame;
    frame.to_sun = glm::normalize(glm::vec3(0.0F, 1.0F, 0.2F)); // north, 11.3 degrees up
    EXPECT_FLOAT_EQ(make_frame_block(frame, {}, 540).haze.x, 1.0F);
    frame.camera_horizon = {0x000000FFU, 0, 0, 0}; // 90 degrees in the north
    EXPECT_FLOAT_EQ(make_frame_block(frame, {}, 540).haze.x, 0.0F);
}

TEST(SkyExtractTest, TakesTheHorizonRing) {
    FrameData frame;
    frame.to_sun = glm::normalize(glm::vec3(-0.6F, 0.3F, 0.4F));
    std::vector<SkyVertex> sky(SkyDome::vertices);
    place_sky_vertices(frame.to_sun, 0.0F, sky);
    const glm::vec2 sun = glm::normalize(glm::vec2(frame.to_sun));
    for (SkyVertex& vertex : sky) {
        const float level = glm::length(glm::vec2(vertex.direction));
        const float c = level > 0.0F ? glm::dot(glm::vec2(vertex.direction) / level, sun) : 0.0F;
        vertex.radiance_cd_m2 = glm::vec3(2.0F + c, 5.0F, vertex.direction.z); // the last is 0 at the horizon
    }
    frame.sky_vertices = sky;
    const SkyExtract extract = extract_sky(frame);
    for (std::size_t i = 0; i < extract.horizon.size(); ++i) {
        const float s = static_cast<float>(i) / 16.0F - 1.0F;
        EXPECT_NEAR(extract.horizon[i].x, 2.0F + (1.0F - 2.0F * s * s), 5e-3F) << i; // cos = 1 - 2 sin^2 of the half
        EXPECT_NEAR(extract.horizon[i].y, 5.0F, 1e-5F);
        EXPECT_NEAR(extract.horizon[i].z, 0.0F, 1e-6F);
    }
}

TEST(ShadowMapTest, KeepsToWholeTexelsAsTheCameraMoves) {
    FrameData frame;
    frame.to_sun = glm::normalize(glm::vec3(0.4F, -0.5F, 0.6F));
    frame.sun_illuminance_lux = glm::vec3(1.0F);
    constexpr std::uint32_t kSize = 2048;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> step(-40.0F, 40.0F);
    const glm::vec3 fixed(25.0F, -10.0F, 30.0F); // a point of the world
    glm::vec2 first{0.0F};
    for (int i = 0; i < 50; ++i) {
        const glm::vec4 clip = shadow_from_relative(frame, kSize) * glm::vec4(fixed - frame.camera_m, 1.0F);
        const glm::vec2 texel = glm::vec2(clip) * (0.5F * kSize);
        if (i == 0) {
            first = texel;
        }
        const glm::vec2 moved = texel - first;
        EXPECT_NEAR(moved.x, std::round(moved.x), 0.02F);
        EXPECT_NEAR(moved.y, std::round(moved.y), 0.02F);
        frame.camera_m += glm::vec3(step(random), step(random), 0.1F * step(random));
    }
}

TEST(ShadowMapTest, DepthGrowsTowardsTheStrongerLight) {
    FrameData frame;
    frame.to_sun = glm::normalize(glm::vec3(0.1F, 0.2F, -0.9F));
    frame.to_moon = glm::normalize(glm::vec3(0.7F, 0.1F, 0.5F));
    frame.moon_illuminance_lux = glm::vec3(0.2F);
    EXPECT_TRUE(moon_is_key(frame));
    const glm::mat4 map = shadow_from_relative(frame, 1024);
    const glm::vec4 here = map * glm::vec4(1.0F, 2.0F, 3.0F, 1.0F);
    const glm::vec4 nearer = map * glm::vec4(glm::vec3(1.0F, 2.0F, 3.0F) + 50.0F * frame.to_moon, 1.0F);
    EXPECT_GT(nearer.z, here.z);
    EXPECT_NEAR(nearer.x, here.x, 1e-5F);
    EXPECT_NEAR(nearer.y, here.y, 1e-5F);
}

} // namespace
} // namespace alpenglow::sandbox
