#include "sandbox/render/sky_dome.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "sandbox/render/frustum.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

const std::vector<glm::vec3> kSuns{{0.0F, 0.0F, 1.0F}, {0.0F, 0.0F, -1.0F}, {1.0F, 0.0F, 0.0F},  {0.0F, -1.0F, 0.0F},
                                   {0.6F, 0.0F, 0.8F}, {-0.3F, 0.9F, 0.1F}, {0.1F, -0.2F, -0.4F}};

double solid_angle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) { // van Oosterom and Strackee 1983
    return 2.0 *
           std::atan2(std::abs(glm::dot(a, glm::cross(b, c))), 1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
}

TEST(SkyDomeTest, RingsRiseFromTheHorizonAndFallFromIt) {
    std::vector<SkyVertex> sky(SkyDome::vertices);
    for (const float horizon : {0.0F, -0.06F, -0.5F}) {
        for (const glm::vec3& sun : kSuns) {
            place_sky_vertices(glm::normalize(sun), horizon, sky);
            for (std::uint32_t i = 0; i < SkyDome::vertices; ++i) {
                ASSERT_NEAR(glm::length(sky[i].direction), 1.0F, 1e-6F);
                const std::uint32_t ring = i / SkyDome::azimuths;
                const float z = sky[i].direction.z;
                if (ring == 0) {
                    ASSERT_FLOAT_EQ(z, std::sin(horizon));
                } else if (ring == SkyDome::rings) {
                    ASSERT_LT(z, sky[i % SkyDome::azimuths].direction.z);
                } else if (ring < SkyDome::rings) {
                    ASSERT_GT(z, sky[i - SkyDome::azimuths].direction.z);
                } else {
                    ASSERT_LT(z, sky[i - SkyDome::azimuths].direction.z);
                }
            }
        }
    }
}

TEST(SkyDomeTest, CoversTheSphereOnce) {
    std::vector<SkyVertex> sky(SkyDome::vertices);
    const std::vector<std::uint32_t> indices = sky_dome_indices();
    ASSERT_EQ(indices.size() % 3, 0U);
    for (const glm::vec3& sun : kSuns) {
        place_sky_vertices(glm::normalize(sun), -0.03F, sky);
        double covered = 0.0;
        for (std::size_t t = 0; t < indices.size(); t += 3) {
            covered +=
                solid_angle(sky[indices[t]].direction, sky[indices[t + 1]].direction, sky[indices[t + 2]].direction);
        }
        EXPECT_NEAR(covered, 4.0 * std::numbers::pi, 1e-3);
    }
}

// Every edge between triangles is shared by two of them, in opposite directions: no hole, no fold. The zenith's and the
// nadir's rings are one point each and close the ends.
TEST(SkyDomeTest, TopologyIsClosed) {
    const auto point = [](std::uint32_t vertex) {
        for (const std::uint32_t pole :
             {SkyDome::vertices - SkyDome::azimuths, SkyDome::vertices_above - SkyDome::azimuths}) {
            if (vertex >= pole && vertex < pole + SkyDome::azimuths) {
                return pole;
            }
        }
        return vertex;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    const std::vector<std::uint32_t> indices = sky_dome_indices();
    for (std::size_t t = 0; t < indices.size(); t += 3) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = point(indices[t + k]);
            const std::uint32_t b = point(indices[t + (k + 1) % 3]);
            ASSERT_NE(a, b);
            ASSERT_LT(std::max(indices[t + k], indices[t + (k + 1) % 3]), SkyDome::vertices);
            ++edges[{a, b}];
        }
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1U);
    }
}

TEST(SkyDomeTest, IsFinestAtTheSun) {
    std::vector<SkyVertex> sky(SkyDome::vertices);
    const glm::vec3 sun = glm::normalize(glm::vec3(0.5F, -0.4F, 0.25F));
    place_sky_vertices(sun, 0.0F, sky);
    const auto nearest = [&](glm::vec3 direction) {
        float best = -1.0F;
        for (const SkyVertex& vertex : sky) {
            best = std::max(best, glm::dot(vertex.direction, direction));
        }
        return std::acos(std::min(best, 1.0F));
    };
    EXPECT_LT(nearest(sun), 1.5F * kPi / 180.0F);
    for (std::uint32_t i = 1; i < SkyDome::azimuths; ++i) {
        EXPECT_GT(sky_azimuth_from_light(i), sky_azimuth_from_light(i - 1));
    }
}

TEST(SkyDomeTest, PatchesAreTheWholeDomeInOrder) {
    const std::vector<std::uint32_t> indices = sky_dome_indices();
    std::uint32_t next = 0;
    for (const SkyPatch& patch : sky_dome_patches()) {
        EXPECT_EQ(patch.first_index, next);
        next += patch.index_count;
        for (std::uint32_t i = patch.first_index; i < next; ++i) {
            EXPECT_TRUE(std::binary_search(patch.corners.begin(), patch.corners.end(), indices[i]));
        }
    }
    EXPECT_EQ(next, indices.size());
}

// Any triangle with a point in the picture is drawn, and most of the dome is not.
TEST(SkyDomeTest, WhatIsInViewIsDrawn) {
    std::vector<SkyVertex> sky(SkyDome::vertices);
    place_sky_vertices(glm::normalize(glm::vec3(0.5F, -0.4F, 0.25F)), -0.02F, sky);
    const std::vector<std::uint32_t> indices = sky_dome_indices();
    const std::vector<SkyPatch> patches = sky_dome_patches();
    std::mt19937 random(4);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (int view = 0; view < 40; ++view) {
        const glm::vec3 along = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
        glm::mat4 clip = glm::perspectiveRH_ZO(0.9F, 1.7F, 1.0F, 1000.0F) *
                         glm::lookAtRH(glm::vec3(0.0F), along, glm::vec3(0.1F, 0.0F, 1.0F));
        const std::vector<IndexRun> runs = visible_sky(patches, sky, side_planes(clip));
        std::uint32_t drawn = 0;
        for (const IndexRun& run : runs) {
            drawn += run.count;
        }
        EXPECT_LT(drawn, indices.size());
        for (std::uint32_t t = 0; t < indices.size(); t += 3) {
            const glm::vec3 middle =
                (sky[indices[t]].direction + sky[indices[t + 1]].direction + sky[indices[t + 2]].direction) / 3.0F;
            const glm::vec4 p = clip * glm::vec4(middle, 0.0F);
            const bool in_view = p.w > 0.0F && std::abs(p.x) <= p.w && std::abs(p.y) <= p.w;
            const bool is_drawn = std::any_of(runs.begin(), runs.end(), [t](const IndexRun& run) {
                return t >= run.first && t < run.first + run.count;
            });
            ASSERT_TRUE(!in_view || is_drawn);
        }
    }
}

} // namespace
} // namespace alpenglow::sandbox
