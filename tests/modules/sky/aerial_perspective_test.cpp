#include <alpenglow/sky/aerial_perspective.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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

// A ray of a landscape: from a height, with a slope, over a distance that ends above the ground and below `ceiling_m`.
template <class F>
void landscape_paths(const std::vector<float>& heights_m, const std::vector<float>& distances_m, float ceiling_m,
                     const F& visit) {
    for (float height : heights_m) {
        for (float rise : {-0.9F, -0.5F, -0.2F, -0.1F, -0.03F, 0.0F, 0.01F, 0.05F, 0.2F, 0.5F}) {
            for (float distance : distances_m) {
                const float end = height + rise * distance;
                if (end < 0.0F || end > ceiling_m) {
                    continue;
                }
                for (float azimuth : {0.3F, 1.7F, 4.0F}) {
                    const float level = std::sqrt(1.0F - rise * rise);
                    visit(height, glm::vec3(level * std::cos(azimuth), level * std::sin(azimuth), rise), distance);
                }
            }
        }
    }
}

struct Worst {
    double in_scatter = 0.0, transmittance = 0.0;
};
Worst against_march(const std::vector<float>& heights_m, const std::vector<float>& distances_m, float ceiling_m,
                    int steps) {
    Worst worst;
    for (float turbidity : {2.0F, 4.0F, 8.0F}) {
        const Air air = make_air(turbidity);
        landscape_paths(heights_m, distances_m, ceiling_m, [&](float height, const glm::vec3& v, float distance) {
            const auto got = aerial_perspective(air, height, v, distance, sun, lux, ambient);
            const auto want = march_aerial_perspective(air, height, v, distance, sun, lux, ambient, steps);
            for (int k = 0; k < 3; ++k) {
                worst.in_scatter =
                    std::max(worst.in_scatter, std::abs(double(got.in_scatter[k]) / want.in_scatter[k] - 1.0));
                worst.transmittance =
                    std::max(worst.transmittance, std::abs(double(got.transmittance[k]) - want.transmittance[k]));
            }
        });
    }
    return worst;
}

TEST(AerialPerspective, KeepsToTheMarch) {
    const Worst landscape = against_march({0.0F, 500.0F, 1500.0F, 4000.0F}, {100, 1000, 5000, 14e3, 6e4}, 4500, 4000);
    EXPECT_LT(landscape.transmittance, 2e-5);
    EXPECT_LT(landscape.in_scatter, 0.01);
    const Worst flight = against_march({8000.0F, 12000.0F}, {1e3, 1e4, 3e4, 1e5, 2e5}, 13000, 1000);
    EXPECT_LT(flight.transmittance, 2e-4);
    EXPECT_LT(flight.in_scatter, 0.02);
    std::printf("worst in-scatter error %.4f, from flights %.4f\n", landscape.in_scatter, flight.in_scatter);
}

// No step in the light where one stretch becomes two.
TEST(AerialPerspective, ContinuousWhereThePathIsCut) {
    const Air air = make_air(4.0F);
    const float cut_m = 2.0F * air.mie_height_m;
    for (float rise : {-0.4F, -0.05F, 0.05F, 0.4F}) {
        const glm::vec3 v(std::sqrt(1.0F - rise * rise), 0.0F, rise);
        const auto at = [&](float climb_m) {
            return aerial_perspective(air, 3000.0F, v, climb_m / std::abs(rise), sun, lux, ambient);
        };
        const auto below = at(0.9999F * cut_m);
        const auto above = at(1.0001F * cut_m);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(above.in_scatter[k] / below.in_scatter[k], 1.0F, 4e-4F);
            EXPECT_NEAR(above.transmittance[k], below.transmittance[k], 4e-4F);
        }
    }
}

struct Batch {
    std::vector<float> x, y, z, distance;
    std::array<std::vector<float>, 6> out;

    void add(const glm::vec3& v, float d) {
        x.push_back(v.x);
        y.push_back(v.y);
        z.push_back(v.z);
        distance.push_back(d);
    }
    void run(const Air& air, float height) {
        for (auto& o : out) {
            o.assign(x.size(), -1.0F);
        }
        aerial_perspective(air, height, sun, lux, ambient, {x, y, z, distance},
                           {out[0], out[1], out[2], out[3], out[4], out[5]});
    }
};

TEST(AerialPerspective, BatchIsTheScalarFunction) {
    for (float turbidity : {1.0F, 3.0F, 8.0F}) {
        const Air air = make_air(turbidity);
        for (float height : {0.0F, 800.0F, 4000.0F, 12000.0F}) {
            Batch batch;
            std::vector<AerialPerspective> want;
            landscape_paths({height}, {0.0F, 1.0F, 30, 1000, 5000, 14e3, 6e4, 2e5}, 1e6F,
                            [&](float, const glm::vec3& v, float distance) {
                                batch.add(v, distance);
                                want.push_back(aerial_perspective(air, height, v, distance, sun, lux, ambient));
                            });
            ASSERT_NE(batch.x.size() % 16, 0U); // the last vector is partly filled
            batch.run(air, height);
            for (std::size_t i = 0; i < want.size(); ++i) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const int c = static_cast<int>(k);
                    EXPECT_NEAR(batch.out[k][i], want[i].transmittance[c], 1e-4F);
                    EXPECT_NEAR(batch.out[3 + k][i], want[i].in_scatter[c], 1e-4F * want[i].in_scatter[c])
                        << "height " << height << " rise " << batch.z[i] << " distance " << batch.distance[i];
                }
            }
        }
    }
}

} // namespace
} // namespace alpenglow::sky
