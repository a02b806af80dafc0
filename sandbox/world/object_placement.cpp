#include "noise.hpp"
#include "terrain_mesh.hpp"
#include "world.hpp"

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace alpenglow::sandbox {
namespace {

// A hamlet: buildings by offset from its centre, groups of trees and boulders around.
struct Building {
    ObjectKind kind;
    glm::vec2 offset_m;
    float azimuth_deg; // of the front
};
struct Fence {
    glm::vec2 from_m, to_m;
};
struct Place {
    glm::vec2 centre_m;
    std::span<const Building> buildings; // and what else has its place
    std::span<const Fence> fences;
    int tree_groups;
    int trees; // a group
    int boulders;
    float reach_m;
};

constexpr std::array<Building, 7> hamlet{{{ObjectKind::hut, {0.0F, 0.0F}, 200.0F},
                                          {ObjectKind::chapel, {34.0F, 22.0F}, 250.0F},
                                          {ObjectKind::barn, {-30.0F, 14.0F}, 160.0F},
                                          {ObjectKind::barn, {20.0F, -30.0F}, 110.0F},
                                          {ObjectKind::linden, {52.0F, 30.0F}, 0.0F},
                                          {ObjectKind::linden, {-14.0F, -38.0F}, 70.0F},
                                          {ObjectKind::linden, {-16.0F, 38.0F}, 200.0F}}};
constexpr std::array<Fence, 2> hamlet_fences{
    {{{361.0F, -324.0F}, {408.0F, -270.0F}}, {{408.0F, -270.0F}, {396.0F, -212.0F}}}};
constexpr std::array<Fence, 1> farm_fences{{{{-1800.0F, -388.0F}, {-1716.0F, -372.0F}}}};
constexpr std::array<Building, 3> farm{{{ObjectKind::hut, {0.0F, 0.0F}, 180.0F},
                                        {ObjectKind::barn, {24.0F, 8.0F}, 140.0F},
                                        {ObjectKind::linden, {-17.0F, 6.0F}, 20.0F}}};
constexpr std::array<Building, 1> alp{{{ObjectKind::hut, {0.0F, 0.0F}, 170.0F}}};

const std::array<Place, 4> places{{{{330.0F, -260.0F}, hamlet, hamlet_fences, 8, 6, 4, 220.0F},
                                   {{-1765.0F, -335.0F}, farm, farm_fences, 5, 5, 2, 150.0F},
                                   {{4700.0F, 4556.0F}, alp, {}, 5, 7, 7, 170.0F},
                                   {{6530.0F, -3590.0F}, farm, {}, 4, 6, 3, 160.0F}}};

float slope_at(const Terrain& terrain, glm::vec2 p) {
    const float d = 8.0F;
    const float dx = terrain.height_m(p + glm::vec2(d, 0)) - terrain.height_m(p - glm::vec2(d, 0));
    const float dy = terrain.height_m(p + glm::vec2(0, d)) - terrain.height_m(p - glm::vec2(0, d));
    return std::hypot(dx, dy) / (2.0F * d);
}

ObjectInstance stand(const Terrain& terrain, const MeshData& mesh, ObjectKind kind, glm::vec2 p, float azimuth_rad,
                     float scale, float sink_m) {
    ObjectInstance object;
    // The front (-Y) turns to the azimuth.
    const float c = -std::cos(azimuth_rad);
    const float s = -std::sin(azimuth_rad);
    object.world_from_object = {glm::vec4(scale * c, -scale * s, 0, 0), glm::vec4(scale * s, scale * c, 0, 0),
                                glm::vec4(0, 0, scale, 0), glm::vec4(p, terrain.height_m(p) - sink_m, 1)};
    object.horizon = terrain_horizon(terrain, mesh, p);
    object.mesh = static_cast<std::uint32_t>(kind);
    return object;
}

} // namespace

std::vector<ObjectInstance> place_objects(const Terrain& terrain, const MeshData& mesh,
                                          const std::vector<ObjectMesh>& meshes) {
    std::vector<ObjectInstance> objects;
    constexpr float turn_rad = 2.0F * std::numbers::pi_v<float>;
    std::uint32_t draws = terrain.seed * 7907U;
    const auto draw = [&] { return hash_unit(static_cast<int>(++draws), 17, 23U); };
    for (const Place& place : places) {
        const std::size_t first = objects.size();
        for (const Building& b : place.buildings) {
            objects.push_back(stand(terrain, mesh, b.kind, place.centre_m + b.offset_m,
                                    b.azimuth_deg * std::numbers::pi_v<float> / 180.0F, 1.0F, 0.2F));
        }
        for (const Fence& fence : place.fences) {
            const glm::vec2 along = fence.to_m - fence.from_m;
            const int pieces = static_cast<int>(glm::length(along) / fence_m);
            for (int k = 0; k < pieces; ++k) {
                const glm::vec2 middle =
                    fence.from_m + glm::normalize(along) * (fence_m * (static_cast<float>(k) + 0.5F));
                objects.push_back(
                    stand(terrain, mesh, ObjectKind::fence, middle, -std::atan2(along.y, along.x), 1.0F, 0.0F));
            }
        }
        const auto is_free = [&](glm::vec2 p, float clearance_m) {
            return std::all_of(objects.begin() + static_cast<std::ptrdiff_t>(first), objects.end(),
                               [&](const ObjectInstance& o) {
                                   return glm::distance(glm::vec2(o.world_from_object[3]), p) >
                                          clearance_m + 0.6F * meshes[o.mesh].radius_m;
                               });
        };
        for (int g = 0; g < place.tree_groups; ++g) {
            const float angle =
                turn_rad * (static_cast<float>(g) + 0.7F * draw()) / static_cast<float>(place.tree_groups);
            const glm::vec2 centre =
                place.centre_m + place.reach_m * (0.35F + 0.65F * draw()) * glm::vec2(std::sin(angle), std::cos(angle));
            for (int t = 0; t < place.trees; ++t) {
                const glm::vec2 p = centre + 17.0F * glm::vec2(draw() + draw() - 1.0F, draw() + draw() - 1.0F);
                const float height = terrain.height_m(p);
                const float scale = 0.65F + 0.6F * draw();
                const ObjectKind kind = draw() < 0.72F ? ObjectKind::spruce : ObjectKind::larch;
                if (height < 1850.0F && slope_at(terrain, p) < 0.8F && lake_distance_m(p) > 15.0F && is_free(p, 2.5F)) {
                    objects.push_back(stand(terrain, mesh, kind, p, turn_rad * draw(), scale, 0.3F));
                }
            }
        }
        for (int b = 0; b < place.boulders; ++b) {
            const float angle = turn_rad * draw();
            const glm::vec2 p =
                place.centre_m + place.reach_m * (0.15F + 0.5F * draw()) * glm::vec2(std::sin(angle), std::cos(angle));
            const float scale = 0.6F + 1.1F * draw();
            if (is_free(p, 4.0F)) {
                objects.push_back(stand(terrain, mesh, ObjectKind::boulder, p, turn_rad * draw(), scale, 0.3F * scale));
            }
        }
    }
    // Groves along the edges of the woods, which hide the rest.
    for (const Place& place : places) {
        constexpr int reach = 30;
        for (int j = -reach; j <= reach; ++j) {
            for (int i = -reach; i <= reach; ++i) {
                const glm::vec2 p =
                    place.centre_m + grove_m * glm::vec2(static_cast<float>(i) + 0.5F * (draw() - 0.5F),
                                                         static_cast<float>(j) + 0.5F * (draw() - 0.5F));
                const float scale = 0.85F + 0.35F * draw();
                const float turn = turn_rad * draw();
                const auto cover = [&](float x, float y) { return wood_cover(terrain, p + grove_m * glm::vec2(x, y)); };
                const bool edge = std::min({cover(1, 0), cover(-1, 0), cover(0, 1), cover(0, -1)}) < 0.5F;
                if (cover(0, 0) > 0.5F && edge) {
                    objects.push_back(stand(terrain, mesh, ObjectKind::grove, p, turn, scale, 0.5F));
                }
            }
        }
    }
    std::stable_sort(objects.begin(), objects.end(),
                     [](const ObjectInstance& a, const ObjectInstance& b) { return a.mesh < b.mesh; });
    return objects;
}

} // namespace alpenglow::sandbox
