#include "sandbox/app/yard.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "sandbox/world/noise.hpp"
#include "sandbox/world/terrain_mesh.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;
constexpr glm::vec2 place_m(348.0F, -100.0F); // level to some centimetres, north of the hamlet
constexpr float cos_quarter_degree = 0.99999048F;
constexpr int openness_rays = 96;

bool inside(const glm::vec3& low, const glm::vec3& high, const glm::vec3& p) {
    return p.x > low.x && p.y > low.y && p.z > low.z && p.x < high.x && p.y < high.y && p.z < high.z;
}

} // namespace

glm::vec3 lattice_direction(int i, int count) {
    const float z = 1.0F - (2.0F * static_cast<float>(i) + 1.0F) / static_cast<float>(count);
    const float azimuth = static_cast<float>(i) * 2.39996323F; // the golden angle
    const float level = std::sqrt(1.0F - z * z);
    return {level * std::cos(azimuth), level * std::sin(azimuth), z};
}

Yard::Yard(const World& world) {
    middle_m_ = glm::vec3(place_m, world.terrain.height_m(place_m) + 0.15F);
    const std::array<std::uint32_t, 4> packed = terrain_horizon(world.terrain, world.data.terrain, place_m);
    for (std::size_t k = 0; k < horizon_.size(); ++k) {
        horizon_[k] = static_cast<std::uint8_t>(packed[k / 4] >> (8U * static_cast<unsigned>(k % 4)) & 255U);
    }
    const auto add = [this](glm::vec3 low, glm::vec3 high, float cell_m) {
        boxes_.push_back({middle_m_ + low, middle_m_ + high, cell_m});
    };
    add({-8.0F, -5.5F, -1.0F}, {8.0F, 6.0F, 0.0F}, 0.25F); // floor
    add({-8.0F, 5.6F, 0.0F}, {8.0F, 6.0F, 2.8F}, 0.25F);   // north wall, behind the arcade
    add({-8.0F, -5.5F, 0.0F}, {-7.6F, 5.6F, 0.9F}, 0.25F); // west
    add({7.6F, -5.5F, 0.0F}, {8.0F, 5.6F, 2.2F}, 0.25F);   // east
    add({-8.0F, 2.1F, 2.8F}, {8.0F, 6.0F, 3.1F}, 0.5F);    // roof of the arcade
    for (const float x : {-7.1F, -4.2F, -1.4F, 1.4F, 4.2F, 7.1F}) {
        add({x - 0.2F, 2.2F, 0.0F}, {x + 0.2F, 2.6F, 2.8F}, 0.2F); // pillars
    }
    for (const Box& box : boxes_) {
        make_corners(box);
    }
}

// A grid of corners on each face but those that nobody sees: undersides on the ground.
void Yard::make_corners(const Box& box) {
    for (int face = 0; face < 6; ++face) {
        const int a = face / 2;
        const bool positive = face % 2 == 0;
        const bool on_ground = box.low_m.z < middle_m_.z + 0.5F;
        if (a == 2 && !positive && on_ground) {
            continue;
        }
        // (u, v) such that u x v points outwards.
        const int u = positive ? (a + 1) % 3 : (a + 2) % 3;
        const int v = positive ? (a + 2) % 3 : (a + 1) % 3;
        const auto cells = [&](int axis) {
            return std::max(1, static_cast<int>(std::ceil((box.high_m[axis] - box.low_m[axis]) / box.cell_m - 0.01F)));
        };
        const int nu = cells(u);
        const int nv = cells(v);
        const auto first = static_cast<std::uint32_t>(corners_.size());
        for (int j = 0; j <= nv; ++j) {
            for (int i = 0; i <= nu; ++i) {
                Corner corner{};
                corner.position_m[a] = positive ? box.high_m[a] : box.low_m[a];
                corner.position_m[u] =
                    glm::mix(box.low_m[u], box.high_m[u], static_cast<float>(i) / static_cast<float>(nu));
                corner.position_m[v] =
                    glm::mix(box.low_m[v], box.high_m[v], static_cast<float>(j) / static_cast<float>(nv));
                corner.normal[a] = positive ? 1.0F : -1.0F;
                corner.spread_m[u] = 0.5F * (box.high_m[u] - box.low_m[u]) / static_cast<float>(nu);
                corner.spread_m[v] = 0.5F * (box.high_m[v] - box.low_m[v]) / static_cast<float>(nv);
                corner.shade = 0.93F + 0.14F * hash_unit(static_cast<std::int32_t>(corners_.size()), face, 91U);
                corner.open = openness(corner.position_m + 0.02F * corner.normal, corner.normal);
                corners_.push_back(corner);
            }
        }
        const auto row = static_cast<std::uint32_t>(nu + 1);
        for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(nv); ++j) {
            for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(nu); ++i) {
                const std::uint32_t c = first + j * row + i;
                indices_.insert(indices_.end(), {c, c + 1, c + row + 1, c, c + row + 1, c + row});
            }
        }
    }
}

bool Yard::is_solid(const glm::vec3& point_m) const {
    return std::any_of(boxes_.begin(), boxes_.end(),
                       [&](const Box& box) { return inside(box.low_m, box.high_m, point_m); });
}

bool Yard::walls_hide(const glm::vec3& point_m, const glm::vec3& direction) const {
    const glm::vec3 inverse = 1.0F / direction; // infinite along an axis: the slab test holds
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const Box& box) {
        const glm::vec3 a = (box.low_m - point_m) * inverse;
        const glm::vec3 b = (box.high_m - point_m) * inverse;
        const glm::vec3 near = glm::min(a, b);
        const glm::vec3 far = glm::max(a, b);
        const float enter = std::max({near.x, near.y, near.z, 0.0F});
        return enter <= std::min({far.x, far.y, far.z});
    });
}

bool Yard::hides(const glm::vec3& point_m, const glm::vec3& direction) const {
    float steps = std::atan2(direction.x, direction.y) * (static_cast<float>(horizon_azimuths) / (2.0F * pi_f));
    steps = steps < 0.0F ? steps + static_cast<float>(horizon_azimuths) : steps;
    const auto k = static_cast<std::size_t>(steps);
    const float elevation = glm::mix(decode_horizon_rad(horizon_[k % 16]), decode_horizon_rad(horizon_[(k + 1) % 16]),
                                     steps - static_cast<float>(k));
    return std::asin(std::clamp(direction.z, -1.0F, 1.0F)) < elevation || walls_hide(point_m, direction);
}

float Yard::visibility(const glm::vec3& point_m, const glm::vec3& reach_m, const glm::vec3& to_light) const {
    int seen = 0;
    int counted = 0;
    for (int i = 0; i < 27; ++i) {
        const glm::vec3 step(static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1),
                             static_cast<float>(i / 9 - 1));
        const glm::vec3 p = point_m + step * reach_m / 3.0F;
        if (!is_solid(p)) {
            ++counted;
            seen += hides(p, to_light) ? 0 : 1;
        }
    }
    return counted > 0 ? static_cast<float>(seen) / static_cast<float>(counted) : 0.0F;
}

float Yard::openness(const glm::vec3& point_m, const glm::vec3& normal) const {
    float all = 0.0F;
    float open = 0.0F;
    for (int i = 0; i < openness_rays; ++i) {
        const glm::vec3 direction = lattice_direction(i, openness_rays);
        const float cosine = glm::dot(direction, normal);
        if (cosine > 0.0F) {
            all += cosine;
            open += walls_hide(point_m, direction) ? 0.0F : cosine;
        }
    }
    return open / all;
}

// Of the cell around a corner, in nine points.
float Yard::lit_part(const Corner& corner, const glm::vec3& to_light) const {
    if (glm::dot(corner.normal, to_light) <= 0.0F || to_light.z < -0.02F) {
        return 0.0F;
    }
    const int u = corner.normal.x != 0.0F ? 1 : 0;
    const int v = corner.normal.z != 0.0F ? 1 : 2;
    int seen = 0;
    for (int i = 0; i < 9; ++i) {
        glm::vec3 p = corner.position_m + 0.01F * corner.normal;
        p[u] += static_cast<float>(i % 3 - 1) * (2.0F / 3.0F) * corner.spread_m[u];
        p[v] += static_cast<float>(i / 3 - 1) * (2.0F / 3.0F) * corner.spread_m[v];
        seen += hides(p, to_light) ? 0 : 1;
    }
    return static_cast<float>(seen) / 9.0F;
}

void Yard::append_mesh(const YardLight& light, std::vector<ColorVertex>& vertices,
                       std::vector<std::uint32_t>& indices) {
    const bool sun_moved = glm::dot(light.to_sun, traced_to_sun_) < cos_quarter_degree;
    const bool moon_moved = glm::dot(light.to_moon, traced_to_moon_) < cos_quarter_degree;
    traced_to_sun_ = sun_moved ? light.to_sun : traced_to_sun_;
    traced_to_moon_ = moon_moved ? light.to_moon : traced_to_moon_;
    for (Corner& corner : corners_) {
        corner.sun = sun_moved ? lit_part(corner, traced_to_sun_) : corner.sun;
        corner.moon = moon_moved ? lit_part(corner, traced_to_moon_) : corner.moon;
    }
    const auto irradiance = [&light](const glm::vec3& normal) {
        const glm::vec4 n(normal, 1.0F);
        const auto& m = light.irradiance_matrix;
        return glm::max(glm::vec3(glm::dot(n, m[0] * n), glm::dot(n, m[1] * n), glm::dot(n, m[2] * n)), 0.0F);
    };
    // What walls send back: as much as half-lit ground would, the probes' own assumption.
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    const glm::vec3 ground_lux = irradiance(up) + 0.5F * light.sun_lux * std::max(light.to_sun.z, 0.0F) +
                                 0.5F * light.moon_lux * std::max(light.to_moon.z, 0.0F);
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const Corner& corner : corners_) {
        const glm::vec3 lux = light.sun_lux * (corner.sun * std::max(glm::dot(corner.normal, light.to_sun), 0.0F)) +
                              light.moon_lux * (corner.moon * std::max(glm::dot(corner.normal, light.to_moon), 0.0F)) +
                              corner.open * irradiance(corner.normal) + (1.0F - corner.open) * albedo * ground_lux;
        vertices.push_back({corner.position_m, glm::vec4(corner.shade / pi_f * albedo * lux, 0.0F)});
    }
    for (const std::uint32_t index : indices_) {
        indices.push_back(first + index);
    }
}

} // namespace alpenglow::sandbox
