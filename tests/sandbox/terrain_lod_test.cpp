#include "test_terrain.hpp"

#include <sandbox/world/camera.hpp>
#include <sandbox/world/terrain_lod.hpp>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace alpenglow::sandbox {
namespace {

// Positions as whole multiples of the inner spacing.
using Point = std::pair<long, long>;

Point point_of(const TerrainLod& lod, std::uint32_t vertex) {
    const glm::vec3 p = lod.position_m(vertex);
    return {std::lround(p.x / Terrain::inner_spacing_m), std::lround(p.y / Terrain::inner_spacing_m)};
}

// Whole multiples of the inner spacing from the south-west corner, row by row.
constexpr std::size_t sites = static_cast<std::size_t>(Terrain::samples - 1) * Terrain::ratio + 1;

std::size_t site_of(Point p) {
    const auto from_corner = [](long k) { return static_cast<std::size_t>(k + static_cast<long>(sites / 2)); };
    return from_corner(p.second) * sites + from_corner(p.first);
}

LodView view_of(const Camera& camera) {
    return {camera.position_m, camera.projection(16.0F / 9.0F) * camera.view(), camera.pixels_per_radian(540.0F)};
}

Camera camera_at(const Terrain& terrain, int k) {
    Camera camera;
    const glm::vec2 p(12000.0F * (hash_unit(k, 1, 9) - 0.5F), 12000.0F * (hash_unit(k, 2, 9) - 0.5F));
    camera.position_m = {p, terrain.height_m(p) + 2.0F + 800.0F * hash_unit(k, 3, 9) * hash_unit(k, 4, 9)};
    camera.yaw_rad = 6.28F * hash_unit(k, 5, 9);
    camera.pitch_rad = 0.6F * (hash_unit(k, 6, 9) - 0.6F);
    return camera;
}

// No vertex that is used lies inside an edge of a triangle: bisection puts vertices in the middles of edges alone.
void expect_no_cracks(const TerrainLod& lod, std::span<const std::uint32_t> indices) {
    std::vector<bool> used(sites * sites, false);
    for (const std::uint32_t v : indices) {
        used[site_of(point_of(lod, v))] = true;
    }
    for (std::size_t t = 0; t < indices.size(); t += 3) {
        for (std::size_t e = 0; e < 3; ++e) {
            const Point a = point_of(lod, indices[t + e]);
            const Point b = point_of(lod, indices[t + (e + 1) % 3]);
            const long dx = b.first - a.first;
            const long dy = b.second - a.second;
            const long parts = std::max(std::abs(dx), std::abs(dy));
            ASSERT_TRUE(dx == 0 || dy == 0 || std::abs(dx) == std::abs(dy));
            for (long part = parts / 2; part >= 1; part /= 2) {
                for (long at = part; at < parts; at += part) {
                    ASSERT_FALSE(used[site_of({a.first + dx / parts * at, a.second + dy / parts * at})]);
                }
                if (parts > 64) {
                    break; // long edges: their middle is enough, a split edge is split there first
                }
            }
        }
    }
}

TEST(TerrainLod, WholeTriangulationIsClosedAndCoversTheSquare) {
    const Terrain& terrain = rough_terrain();
    const TerrainLod lod = rough_lod();
    const std::vector<std::uint32_t> indices = lod.coarse_indices(150.0F);
    ASSERT_GT(indices.size(), 1000U);
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Edge> edges;
    edges.reserve(indices.size());
    double area = 0.0;
    for (std::size_t t = 0; t < indices.size(); t += 3) {
        const glm::vec3 a = lod.position_m(indices[t]);
        const glm::vec3 b = lod.position_m(indices[t + 1]);
        const glm::vec3 c = lod.position_m(indices[t + 2]);
        const double twice =
            static_cast<double>(b.x - a.x) * (c.y - a.y) - static_cast<double>(b.y - a.y) * (c.x - a.x);
        ASSERT_GT(twice, 0.0); // counter-clockwise from above
        area += 0.5 * twice;
        for (std::size_t e = 0; e < 3; ++e) {
            edges.emplace_back(indices[t + e], indices[t + (e + 1) % 3]);
        }
    }
    const double side = terrain.outer.extent_m();
    EXPECT_NEAR(area, side * side, 1e-6 * side * side);
    std::sort(edges.begin(), edges.end());
    ASSERT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end()); // each runs once in each direction
    for (const Edge& edge : edges) {
        if (!std::binary_search(edges.begin(), edges.end(), Edge{edge.second, edge.first})) {
            // Only the border of the square has one side.
            const glm::vec3 a = lod.position_m(edge.first);
            const glm::vec3 b = lod.position_m(edge.second);
            const float half = 0.5F * terrain.outer.extent_m();
            ASSERT_TRUE((a.x == b.x && std::abs(a.x) == half) || (a.y == b.y && std::abs(a.y) == half));
        }
    }
    expect_no_cracks(lod, indices);
}

TEST(TerrainLod, KeepsTheBudgetWithoutCracksWhereverTheCameraStands) {
    const Terrain& terrain = rough_terrain();
    TerrainLod lod = rough_lod();
    LodSettings settings;
    settings.max_triangles = 12000;
    for (int k = 0; k < 8; ++k) {
        const Camera camera = camera_at(terrain, k);
        const SystemReport report = lod.update(view_of(camera), settings);
        EXPECT_EQ(report.updated, 1U);
        EXPECT_LE(lod.indices().size() / 3, settings.max_triangles);
        EXPECT_GE(lod.error_px(), settings.target_error_px);
        expect_no_cracks(lod, lod.indices());
    }
}

TEST(TerrainLod, ErrorOnTheScreenIsBounded) {
    const Terrain& terrain = rough_terrain();
    TerrainLod lod = rough_lod();
    for (int k = 0; k < 4; ++k) {
        const Camera camera = camera_at(terrain, k);
        const LodView view = view_of(camera);
        (void)lod.update(view, {});
        double worst = 0.0;
        for (int s = 0; s < 20000; ++s) {
            // Samples of the inner grid, away from the strip where resolution fades out towards its border.
            const int i = 40 + static_cast<int>(944.0F * hash_unit(s, 7, 1));
            const int j = 40 + static_cast<int>(944.0F * hash_unit(s, 8, 1));
            const glm::vec3 p(terrain.inner.position_m(i, j), terrain.inner.at(i, j));
            const float error = std::abs(lod.surface_height_m(glm::vec2(p)) - p.z);
            const float distance = glm::distance(p, camera.position_m);
            const float allowed = distance * std::exp(distance / LodSettings{}.haze_m);
            worst = std::max(worst, static_cast<double>(error / allowed * view.pixels_per_radian));
        }
        EXPECT_LE(worst, lod.error_px() * 1.001 + 1e-3);
        EXPECT_GT(worst, 0.0);
    }
}

TEST(TerrainLod, DrawsWhatCanBeSeen) {
    const Terrain& terrain = rough_terrain();
    TerrainLod lod = rough_lod();
    for (int k = 0; k < 4; ++k) {
        const Camera camera = camera_at(terrain, k + 20);
        const LodView view = view_of(camera);
        (void)lod.update(view, {});
        const std::span<const std::uint32_t> indices = lod.indices();
        int seen = 0;
        for (int s = 0; s < 3000; ++s) {
            const glm::vec2 q(16000.0F * (hash_unit(s, 1, 2) - 0.5F), 16000.0F * (hash_unit(s, 2, 2) - 0.5F));
            const glm::vec3 p(q, lod.surface_height_m(q));
            const glm::vec4 clip = view.clip_from_world * glm::vec4(p, 1.0F);
            if (clip.w < 1.0F || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) {
                continue;
            }
            // Walk towards the eye over the surface that is drawn.
            const float distance = glm::distance(p, camera.position_m);
            bool visible = true;
            for (float along = 10.0F; along < distance && visible; along += 10.0F) {
                const glm::vec3 r = p + (camera.position_m - p) * (along / distance);
                visible = lod.surface_height_m(glm::vec2(r)) < r.z;
            }
            if (!visible) {
                continue;
            }
            ++seen;
            bool covered = false;
            for (std::size_t t = 0; t < indices.size() && !covered; t += 3) {
                const glm::vec2 a(lod.position_m(indices[t]));
                const glm::vec2 b(lod.position_m(indices[t + 1]));
                const glm::vec2 c(lod.position_m(indices[t + 2]));
                const auto left = [&](glm::vec2 u, glm::vec2 v) {
                    return (v.x - u.x) * (q.y - u.y) - (v.y - u.y) * (q.x - u.x) >= -1.0F;
                };
                covered = left(a, b) && left(b, c) && left(c, a);
            }
            ASSERT_TRUE(covered) << "camera " << k << " does not get the ground at " << q.x << ", " << q.y;
        }
        EXPECT_GT(seen, 3);
    }
}

TEST(TerrainLod, IsKeptUntilTheCameraHasMovedOrTurned) {
    const Terrain& terrain = rough_terrain();
    TerrainLod lod = rough_lod();
    const LodSettings settings;
    Camera camera = camera_at(terrain, 3);
    camera.position_m.z += 300.0F;
    EXPECT_EQ(lod.update(view_of(camera), settings).updated, 1U);
    const std::uint32_t revision = lod.revision();
    const SystemReport still = lod.update(view_of(camera), settings);
    EXPECT_EQ(still.updated, 0U);
    EXPECT_EQ(still.skipped, 1U);
    camera.position_m.x += 0.9F * settings.move_m;
    camera.yaw_rad += 0.9F * settings.turn_rad;
    EXPECT_EQ(lod.update(view_of(camera), settings).updated, 0U);
    EXPECT_EQ(lod.revision(), revision);
    camera.position_m.x += 0.2F * settings.move_m;
    EXPECT_EQ(lod.update(view_of(camera), settings).updated, 1U);
    camera.yaw_rad += 1.1F * settings.turn_rad;
    EXPECT_EQ(lod.update(view_of(camera), settings).updated, 1U);
    EXPECT_EQ(lod.revision(), revision + 2);
}

TEST(TerrainLod, FlatGroundNeedsTwoTriangles) {
    const TerrainLod lod = flat_lod();
    EXPECT_EQ(lod.coarse_indices(0.0F).size(), 6U);
}

} // namespace
} // namespace alpenglow::sandbox
