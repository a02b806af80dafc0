#include "test_terrain.hpp"

#include <sandbox/world/object_shadows.hpp>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;
constexpr float sun_radius_rad = 4.65e-3F;

glm::vec3 direction(float azimuth_deg, float elevation_deg) {
    const float a = azimuth_deg * pi_f / 180.0F;
    const float e = elevation_deg * pi_f / 180.0F;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

// A box of 4 x 4 x 10 m on flat ground.
struct Yard {
    Yard() {
        ObjectMesh box;
        std::vector<glm::vec3> corners;
        for (int k = 0; k < 8; ++k) {
            corners.emplace_back((k & 1) != 0 ? 2.0F : -2.0F, (k & 2) != 0 ? 2.0F : -2.0F, (k & 4) != 0 ? 10.0F : 0.0F);
        }
        box.solids.push_back(corners);
        box.radius_m = 2.9F;
        box.height_m = 10.0F;
        meshes.push_back(box);
        objects.emplace_back();
    }
    std::vector<ObjectMesh> meshes;
    std::vector<ObjectInstance> objects;
};

// The oracle: the fraction of rays to a disc of the light's size that enter the box.
float traced(glm::vec3 p, glm::vec3 to_light, float radius_rad) {
    const glm::vec3 side = glm::normalize(glm::cross(to_light, glm::vec3(0.3F, 0.2F, 0.93F)));
    const glm::vec3 up = glm::cross(to_light, side);
    int hits = 0;
    constexpr int rays = 2000;
    for (int k = 0; k < rays; ++k) {
        const float r = std::tan(radius_rad) * std::sqrt((static_cast<float>(k) + 0.5F) / rays);
        const float a = 2.399963F * static_cast<float>(k);
        const glm::vec3 d = to_light + r * (std::cos(a) * side + std::sin(a) * up);
        float enter = 0.0F;
        float leave = 1e30F;
        const glm::vec3 low(-2.0F, -2.0F, 0.0F);
        const glm::vec3 high(2.0F, 2.0F, 10.0F);
        for (int axis = 0; axis < 3; ++axis) {
            const float t0 = (low[axis] - p[axis]) / d[axis];
            const float t1 = (high[axis] - p[axis]) / d[axis];
            enter = std::max(enter, std::min(t0, t1));
            leave = std::min(leave, std::max(t0, t1));
        }
        hits += enter < leave ? 1 : 0;
    }
    return static_cast<float>(hits) / rays;
}

TEST(HiddenDiscFraction, IsTheAreaBehindAnEdge) {
    EXPECT_EQ(hidden_disc_fraction(-1.5F), 1.0F);
    EXPECT_EQ(hidden_disc_fraction(1.5F), 0.0F);
    EXPECT_NEAR(hidden_disc_fraction(0.0F), 0.5F, 1e-6F);
    float last = 1.0F;
    for (float x = -1.0F; x <= 1.0F; x += 0.01F) {
        const float f = hidden_disc_fraction(x);
        EXPECT_LE(f, last + 1e-6F);
        EXPECT_NEAR(f + hidden_disc_fraction(-x), 1.0F, 1e-5F);
        last = f;
    }
    // By integration of the chord.
    for (const float x : {-0.6F, 0.1F, 0.5F, 0.9F}) {
        double area = 0.0;
        for (int k = 0; k < 20000; ++k) {
            const double t = x + (1.0 - x) * (k + 0.5) / 20000.0;
            area += 2.0 * std::sqrt(1.0 - t * t) * (1.0 - x) / 20000.0;
        }
        EXPECT_NEAR(hidden_disc_fraction(x), area / std::numbers::pi, 1e-4);
    }
}

TEST(ObjectShadows, PointAwayFromTheSunAndHaveTheirLength) {
    const Yard yard;
    const ObjectShadows shadows(yard.meshes, yard.objects);
    for (const float azimuth : {10.0F, 75.0F, 190.0F, 300.0F}) {
        const glm::vec3 to_sun = direction(azimuth, 30.0F);
        const ShadowInput input{to_sun, sun_radius_rad, {}};
        const glm::vec2 away = -glm::normalize(glm::vec2(to_sun));
        const float length = 10.0F / std::tan(pi_f / 6.0F);
        EXPECT_EQ(shadows.shade(glm::vec3(0.8F * length * away, 0.0F), input), 1.0F);
        EXPECT_EQ(shadows.shade(glm::vec3((length + 4.0F) * away, 0.0F), input), 0.0F);
        EXPECT_EQ(shadows.shade(glm::vec3(-6.0F * away, 0.0F), input), 0.0F); // the sunny side
        EXPECT_EQ(shadows.shade(glm::vec3(0.5F * length * away + 6.0F * glm::vec2(-away.y, away.x), 0.0F), input),
                  0.0F);
    }
}

TEST(ObjectShadows, AgreeWithTracedRays) {
    const Yard yard;
    const ObjectShadows shadows(yard.meshes, yard.objects);
    for (const auto& [elevation, radius] :
         {std::pair{20.0F, sun_radius_rad}, std::pair{45.0F, 0.05F}, std::pair{70.0F, 0.02F}}) {
        const glm::vec3 to_light = direction(120.0F, elevation);
        const ShadowInput input{to_light, radius, {}};
        double sum = 0.0;
        double worst = 0.0;
        int count = 0;
        for (float x = -32.0F; x < 6.0F; x += 0.9F) {
            for (float y = -6.0F; y < 20.0F; y += 0.9F) {
                if (std::abs(x) <= 2.01F && std::abs(y) <= 2.01F) {
                    continue; // under the box
                }
                const double error =
                    std::abs(shadows.shade({x, y, 0.0F}, input) - traced({x, y, 0.0F}, to_light, radius));
                sum += error;
                worst = std::max(worst, error);
                ++count;
            }
        }
        EXPECT_LT(sum / count, 0.005) << "elevation " << elevation;
        EXPECT_LT(worst, 0.35) << "elevation " << elevation; // two edges at a corner count as one
    }
}

TEST(ObjectShadows, PenumbraGrowsWithDistance) {
    const Yard yard;
    const ObjectShadows shadows(yard.meshes, yard.objects);
    const glm::vec3 to_sun = direction(180.0F, 20.0F);
    const ShadowInput input{to_sun, sun_radius_rad, {}};
    const auto width = [&](float north) { // across the shadow's side
        float grey = 0.0F;
        for (float x = 1.0F; x < 3.0F; x += 0.005F) {
            const float s = shadows.shade({x, north, 0.0F}, input);
            grey += s > 0.02F && s < 0.98F ? 0.005F : 0.0F;
        }
        return grey;
    };
    EXPECT_LT(width(4.0F), 0.5F * width(20.0F));
    EXPECT_NEAR(width(20.0F), 2.0F * std::tan(sun_radius_rad) * 18.0F / std::cos(20.0F * pi_f / 180.0F), 0.06F);
}

TEST(ObjectShadows, AreRebuiltOnlyWhenNeeded) {
    const Yard yard;
    const TerrainLod lod = flat_lod();
    ObjectShadows shadows(yard.meshes, yard.objects);
    ShadowInput input{direction(90.0F, 25.0F), sun_radius_rad, {0.0F, -50.0F, 10.0F}};
    EXPECT_EQ(shadows.update(input, lod).updated, 1U);
    ASSERT_FALSE(shadows.indices().empty());
    const std::uint32_t revision = shadows.revision();
    for (const ShadowVertex& v : shadows.vertices()) {
        EXPECT_GE(v.shade, 0.0F);
        EXPECT_LE(v.shade, 1.0F);
        EXPECT_GT(v.position_m.z, 0.0F); // just above the ground
        EXPECT_LT(v.position_m.z, 0.2F);
    }
    const SystemReport still = shadows.update(input, lod);
    EXPECT_EQ(still.updated, 0U);
    EXPECT_EQ(still.skipped, still.considered);
    input.to_light = direction(90.05F, 25.0F);
    EXPECT_EQ(shadows.update(input, lod).updated, 0U);
    EXPECT_EQ(shadows.revision(), revision);
    input.to_light = direction(90.3F, 25.0F);
    EXPECT_EQ(shadows.update(input, lod).updated, 1U);
    EXPECT_EQ(shadows.revision(), revision + 1);
    // Nothing to do without light, or far away.
    input.to_light = direction(90.0F, -5.0F);
    (void)shadows.update(input, lod);
    EXPECT_TRUE(shadows.indices().empty());
    input.to_light = direction(90.0F, 25.0F);
    input.camera_m = {9000.0F, 0.0F, 0.0F};
    (void)shadows.update(input, lod);
    EXPECT_TRUE(shadows.indices().empty());
}

} // namespace
} // namespace alpenglow::sandbox
