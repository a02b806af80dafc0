#include <alpenglow/sky/aerial_perspective.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

const glm::vec3 sun = glm::normalize(glm::vec3(0.3F, 0.7F, 0.5F));
const glm::vec3 lux(9e4F, 8.5e4F, 7.5e4F);
const glm::vec3 ambient(3000.0F, 4000.0F, 6000.0F);

TEST(AerialPerspective, NothingInNoDistance) {
    const auto a = aerial_perspective(make_air(3.0F), 500.0F, {1, 0, 0}, 0.0F, sun, lux, ambient);
    EXPECT_EQ(a.transmittance, glm::vec3(1.0F));
    EXPECT_EQ(a.in_scatter, glm::vec3(0.0F));
}

// The course's formula as printed, for one kind of particle at constant density: a level path.
TEST(AerialPerspective, LevelPathIsTheCoursesFormula) {
    Air air;
    air.mie_per_m = glm::vec3(0.0F);
    const float cos_sun = glm::dot(glm::vec3(1, 0, 0), sun);
    const auto a = aerial_perspective(air, 0.0F, {1, 0, 0}, 3e4F, sun, lux, glm::vec3(0.0F));
    for (int k = 0; k < 3; ++k) {
        const float f = std::exp(-air.rayleigh_per_m[k] * 3e4F);
        const float phase = 3.0F / (16.0F * 3.14159265F) * (1.0F + cos_sun * cos_sun);
        EXPECT_NEAR(a.transmittance[k], f, 1e-6F);
        EXPECT_NEAR(a.in_scatter[k], lux[k] * phase * (1.0F - f), 1e-4F * lux[k] * phase);
    }
}

TEST(AerialPerspective, DistanceFadesAndBlues) {
    float before = 1.0F;
    for (float distance = 100.0F; distance < 2e5F; distance *= 2.0F) {
        const auto a = aerial_perspective(make_air(2.0F), 500.0F, {1, 0, 0}, distance, sun, lux, ambient);
        EXPECT_LT(a.transmittance.y, before);
        EXPECT_LT(a.transmittance.z, a.transmittance.x);
        before = a.transmittance.y;
    }
    const auto near = aerial_perspective(make_air(2.0F), 500.0F, {-1, 0, 0}, 5e3F, sun, lux, ambient);
    EXPECT_GT(near.in_scatter.z, near.in_scatter.x); // blue distance, away from the sun
}

TEST(AerialPerspective, OpticalLengthBothWaysIsTheSame) {
    const float up = optical_length_m(100.0F, 0.2F, 8000.0F, 1250.0F);
    const float down = optical_length_m(1700.0F, -0.2F, 8000.0F, 1250.0F);
    EXPECT_NEAR(up / down, 1.0F, 1e-5F);
    // Continuous where the series takes over.
    const float below = optical_length_m(0.0F, 0.0499999F, 1000.0F, 1000.0F);
    const float above = optical_length_m(0.0F, 0.0500001F, 1000.0F, 1000.0F);
    EXPECT_NEAR(below / above, 1.0F, 1e-6F);
}

// Relative to the in-scattered light plus a hundredth of what the path could add, over paths in a landscape: heights to
// 4 km, slopes that stay above the ground, distances to 60 km.
TEST(AerialPerspective, KeepsToTheMarch) {
    double worst = 0.0;
    double worst_transmittance = 0.0;
    for (float turbidity : {2.0F, 4.0F, 8.0F}) {
        const Air air = make_air(turbidity);
        for (float height : {0.0F, 500.0F, 1500.0F, 4000.0F}) {
            for (float rise : {-0.5F, -0.1F, -0.03F, 0.0F, 0.01F, 0.05F, 0.2F}) {
                for (float distance : {100.0F, 1000.0F, 5000.0F, 2e4F, 6e4F}) {
                    const float end = height + rise * distance;
                    if (end < 0.0F || end > 4500.0F) {
                        continue;
                    }
                    for (float azimuth : {0.3F, 1.7F, 4.0F}) {
                        const float level = std::sqrt(1.0F - rise * rise);
                        const glm::vec3 v(level * std::cos(azimuth), level * std::sin(azimuth), rise);
                        const auto got = aerial_perspective(air, height, v, distance, sun, lux, ambient);
                        const auto want = march_aerial_perspective(air, height, v, distance, sun, lux, ambient, 4000);
                        for (int k = 0; k < 3; ++k) {
                            worst = std::max(worst, std::abs(double(got.in_scatter[k]) / want.in_scatter[k] - 1.0));
                            worst_transmittance = std::max(
                                worst_transmittance, std::abs(double(got.transmittance[k]) - want.transmittance[k]));
                        }
                    }
                }
            }
        }
    }
    EXPECT_LT(worst_transmittance, 2e-5);
    EXPECT_LT(worst, 0.05);
    RecordProperty("worst_in_scatter", std::to_string(worst));
    std::printf("worst in-scatter error %.4f, transmittance %.2g\n", worst, worst_transmittance);
}

} // namespace
} // namespace alpenglow::sky
