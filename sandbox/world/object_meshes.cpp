#include "object_meshes.hpp"

#include "noise.hpp"
#include "vertex.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace alpenglow::sandbox {
namespace {

constexpr glm::vec3 stone{0.30F, 0.28F, 0.26F};
constexpr glm::vec3 timber{0.155F, 0.090F, 0.048F};
constexpr glm::vec3 weathered{0.180F, 0.150F, 0.120F};
constexpr glm::vec3 shingle{0.105F, 0.088F, 0.078F};
constexpr glm::vec3 plaster{0.70F, 0.67F, 0.61F};
constexpr glm::vec3 copper{0.120F, 0.200F, 0.160F};
constexpr glm::vec3 dark{0.02F, 0.02F, 0.025F};

class Builder {
public:
    explicit Builder(ObjectMesh& object) : object_(object) {}

    // A flat polygon, corners counter-clockwise seen from outside.
    void face(std::initializer_list<glm::vec3> corners, glm::vec3 albedo) {
        const std::vector<glm::vec3> p(corners);
        const std::uint32_t normal = pack_normal(glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0])));
        const auto first = static_cast<std::uint32_t>(object_.mesh.vertices.size());
        for (const glm::vec3 q : p) {
            object_.mesh.vertices.push_back({q, normal, pack_albedo(albedo, 1.0F), {}, 0});
        }
        for (std::uint32_t k = 2; k < p.size(); ++k) {
            object_.mesh.indices.insert(object_.mesh.indices.end(), {first, first + k - 1, first + k});
        }
    }

    // Walls of a box, without floor; with a top if asked.
    void box(glm::vec3 low, glm::vec3 high, glm::vec3 albedo, bool top) {
        face({{low.x, low.y, low.z}, {high.x, low.y, low.z}, {high.x, low.y, high.z}, {low.x, low.y, high.z}}, albedo);
        face({{high.x, low.y, low.z}, {high.x, high.y, low.z}, {high.x, high.y, high.z}, {high.x, low.y, high.z}},
             albedo);
        face({{high.x, high.y, low.z}, {low.x, high.y, low.z}, {low.x, high.y, high.z}, {high.x, high.y, high.z}},
             albedo);
        face({{low.x, high.y, low.z}, {low.x, low.y, low.z}, {low.x, low.y, high.z}, {low.x, high.y, high.z}}, albedo);
        if (top) {
            face({{low.x, low.y, high.z}, {high.x, low.y, high.z}, {high.x, high.y, high.z}, {low.x, high.y, high.z}},
                 albedo);
        }
    }

    // A house: footing, walls, gables at -Y and +Y, overhanging roof with its ridge along Y.
    void house(glm::vec3 half, float footing, float ridge, float overhang, glm::vec3 footing_albedo,
               glm::vec3 wall_albedo, glm::vec3 roof_albedo) {
        const float x = half.x;
        const float y = half.y;
        const float z = half.z;
        box({-x, -y, -2.5F}, {x, y, footing}, footing_albedo, false);
        box({-x, -y, footing}, {x, y, z}, wall_albedo, false);
        face({{-x, -y, z}, {x, -y, z}, {0, -y, ridge}}, wall_albedo);
        face({{x, y, z}, {-x, y, z}, {0, y, ridge}}, wall_albedo);
        const float fall = (ridge - z) / x * overhang;
        const float e = x + overhang;
        const float g = y + overhang;
        const float t = 0.25F; // the roof's thickness
        face({{e, -g, z - fall + t}, {e, g, z - fall + t}, {0, g, ridge + t}, {0, -g, ridge + t}}, roof_albedo);
        face({{-e, g, z - fall + t}, {-e, -g, z - fall + t}, {0, -g, ridge + t}, {0, g, ridge + t}}, roof_albedo);
        // Eaves from below and the boards at the gables.
        face({{e, g, z - fall}, {e, -g, z - fall}, {0, -g, ridge}, {0, g, ridge}}, wall_albedo * 0.6F);
        face({{-e, -g, z - fall}, {-e, g, z - fall}, {0, g, ridge}, {0, -g, ridge}}, wall_albedo * 0.6F);
        for (const float s : {-1.0F, 1.0F}) {
            const float w = s * g;
            const glm::vec3 left{-s * e * -1.0F, w, z - fall};
            const glm::vec3 right{-s * e, w, z - fall};
            const glm::vec3 up{0, 0, t};
            const glm::vec3 top{0, w, ridge};
            face({left, top, top + up, left + up}, roof_albedo);
            face({top, right, right + up, top + up}, roof_albedo);
            face({{s * e, -g, z - fall}, {s * e, g, z - fall}, {s * e, g, z - fall + t}, {s * e, -g, z - fall + t}},
                 roof_albedo);
        }
        solid({{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}, {-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}});
        solid({{-e, -g, z - fall},
               {e, -g, z - fall},
               {e, g, z - fall},
               {-e, g, z - fall},
               {0, -g, ridge + t},
               {0, g, ridge + t}});
    }

    // A cone of `sides` sides, solid or (a spire) without a shadow.
    void cone(glm::vec3 base, float radius, float top, int sides, float twist, glm::vec3 albedo, float squash = 1.0F) {
        solid(spire(base, radius, top, sides, twist, albedo, squash));
    }
    std::vector<glm::vec3> spire(glm::vec3 base, float radius, float top, int sides, float twist, glm::vec3 albedo,
                                 float squash = 1.0F) {
        const glm::vec3 apex{base.x, base.y, top};
        std::vector<glm::vec3> ring;
        for (int k = 0; k < sides; ++k) {
            const float a =
                twist + 2.0F * std::numbers::pi_v<float> * static_cast<float>(k) / static_cast<float>(sides);
            ring.push_back(base + radius * glm::vec3(std::cos(a), squash * std::sin(a), 0.0F));
        }
        for (std::size_t k = 0; k < ring.size(); ++k) {
            face({ring[k], ring[(k + 1) % ring.size()], apex}, albedo);
        }
        ring.push_back(apex);
        return ring;
    }

    void solid(std::vector<glm::vec3> points) { object_.solids.push_back(std::move(points)); }

private:
    ObjectMesh& object_;
};

void windows(Builder& builder, float x, float z, std::initializer_list<float> ys) {
    for (const float y : ys) {
        for (const float s : {-1.0F, 1.0F}) {
            const float w = s * (x + 0.03F);
            builder.face(
                {{w, y - s * 0.5F, z}, {w, y + s * 0.5F, z}, {w, y + s * 0.5F, z + 1.1F}, {w, y - s * 0.5F, z + 1.1F}},
                dark);
        }
    }
}

void conifer(Builder& builder, float height, float radius, glm::vec3 needles, float squash) {
    builder.box({-0.22F, -0.22F, -1.5F}, {0.22F, 0.22F, 0.18F * height}, {0.07F, 0.05F, 0.035F}, false);
    builder.cone({0, 0, 0.12F * height}, radius, 0.62F * height, 7, 0.2F, needles * 0.85F, squash);
    builder.cone({0, 0, 0.40F * height}, 0.72F * radius, 0.83F * height, 6, 0.9F, needles, squash);
    builder.cone({0, 0, 0.64F * height}, 0.45F * radius, height, 5, 0.4F, needles * 1.15F, squash);
}

void boulder(Builder& builder) {
    // An octahedron split once, its corners pushed in and out.
    std::vector<std::array<glm::vec3, 3>> faces;
    const std::array<glm::vec3, 6> c{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
    for (std::size_t k = 0; k < 4; ++k) {
        faces.push_back({c[k], c[(k + 1) % 4], c[4]});
        faces.push_back({c[(k + 1) % 4], c[k], c[5]});
    }
    std::vector<glm::vec3> points;
    const auto shape = [&](glm::vec3 p) {
        p = glm::normalize(p);
        const int h = static_cast<int>(std::lround(p.x * 50.0F)) * 131 + static_cast<int>(std::lround(p.z * 50.0F));
        const float r = 1.0F + 0.45F * (hash_unit(h, static_cast<int>(std::lround(p.y * 50.0F)), 5U) - 0.5F);
        const glm::vec3 q = r * glm::vec3(1.5F, 1.1F, 0.95F) * p + glm::vec3(0, 0, 0.45F);
        points.push_back(q);
        return q;
    };
    for (const auto& f : faces) {
        const glm::vec3 ab = f[0] + f[1];
        const glm::vec3 bc = f[1] + f[2];
        const glm::vec3 ca = f[2] + f[0];
        for (const auto& t :
             {std::array{f[0], ab, ca}, std::array{ab, f[1], bc}, std::array{ca, bc, f[2]}, std::array{ab, bc, ca}}) {
            builder.face({shape(t[0]), shape(t[1]), shape(t[2])}, stone * 1.05F);
        }
    }
    builder.solid(points);
}

// A round crown on a trunk: three uneven rings of leaves between a low and a high point.
void broadleaf(Builder& builder, float height, float radius, glm::vec3 leaves) {
    constexpr int sides = 8;
    constexpr std::size_t rings = 3;
    constexpr std::array<float, rings> at{0.30F, 0.52F, 0.80F};
    constexpr std::array<float, rings> wide{0.78F, 1.0F, 0.66F};
    constexpr std::array<float, rings + 1> shade{0.62F, 0.82F, 1.0F, 1.12F};
    builder.box({-0.3F, -0.3F, -1.5F}, {0.3F, 0.3F, 0.3F * height}, {0.08F, 0.065F, 0.05F}, false);
    std::array<std::vector<glm::vec3>, rings> ring;
    std::vector<glm::vec3> crown;
    for (std::size_t r = 0; r < rings; ++r) {
        for (int k = 0; k < sides; ++k) {
            const float turn = (static_cast<float>(k) + 0.5F * static_cast<float>(r % 2)) / static_cast<float>(sides);
            const float a = 2.0F * std::numbers::pi_v<float> * turn;
            const auto uneven = [&](std::uint32_t seed) { return hash_unit(k, static_cast<int>(r), seed) - 0.5F; };
            const float across = radius * wide[r] * (1.0F + 0.22F * uneven(3U));
            ring[r].emplace_back(across * std::cos(a), across * std::sin(a), height * (at[r] + 0.08F * uneven(5U)));
        }
        crown.insert(crown.end(), ring[r].begin(), ring[r].end());
    }
    const glm::vec3 foot{0.0F, 0.0F, 0.19F * height};
    const glm::vec3 top{0.1F * radius, 0.0F, height};
    const auto leaf = [&](glm::vec3 p, glm::vec3 q, glm::vec3 r, float light) {
        builder.face({p, q, r}, leaves * light);
    };
    for (std::size_t k = 0; k < sides; ++k) {
        const std::size_t next = (k + 1) % sides;
        leaf(foot, ring[0][next], ring[0][k], shade[0]);
        // The second ring is turned by half a side.
        leaf(ring[0][k], ring[0][next], ring[1][k], shade[1]);
        leaf(ring[1][k], ring[0][next], ring[1][next], shade[1]);
        leaf(ring[1][k], ring[1][next], ring[2][next], shade[2]);
        leaf(ring[1][k], ring[2][next], ring[2][k], shade[2]);
        leaf(ring[2][k], ring[2][next], top, shade[3]);
    }
    crown.push_back(foot);
    crown.push_back(top);
    builder.solid(crown);
}

// Posts with two rails, each a board seen from both sides.
void fence(Builder& builder) {
    constexpr glm::vec3 rail{0.140F, 0.128F, 0.112F};
    const auto board = [&](glm::vec3 low, glm::vec3 high) {
        builder.face({{low.x, 0, low.z}, {high.x, 0, low.z}, {high.x, 0, high.z}, {low.x, 0, high.z}}, rail);
        builder.face({{high.x, 0, low.z}, {low.x, 0, low.z}, {low.x, 0, high.z}, {high.x, 0, high.z}}, rail);
    };
    for (const float x : {-4.5F, -1.5F, 1.5F, 4.5F}) {
        board({x - 0.08F, 0, -0.8F}, {x + 0.08F, 0, 1.25F});
    }
    for (const float z : {0.5F, 0.98F}) {
        board({-0.5F * fence_m, 0, z}, {0.5F * fence_m, 0, z + 0.13F});
    }
}

// Conifers on a jittered lattice, for the distance: a cone each, no trunks.
void grove(Builder& builder) {
    constexpr int rows = 3;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < rows; ++i) {
            const auto jitter = [&](std::uint32_t k) { return hash_unit(i, j, k) - 0.5F; };
            const float cell = grove_m / rows;
            const glm::vec3 foot{cell * (static_cast<float>(i - 1) + 0.8F * jitter(1)),
                                 cell * (static_cast<float>(j - 1) + 0.8F * jitter(2)), -1.0F};
            const float height = 17.0F + 10.0F * jitter(3);
            const bool larch = jitter(4) > 0.28F;
            const glm::vec3 needles = larch ? glm::vec3(0.066F, 0.098F, 0.034F) : glm::vec3(0.029F, 0.053F, 0.023F);
            builder.spire(foot, 0.22F * height, height, 5, 6.0F * jitter(6), needles * (1.0F + 0.5F * jitter(5)));
        }
    }
}

} // namespace

ObjectMesh make_object_mesh(ObjectKind kind) {
    ObjectMesh object;
    Builder builder(object);
    switch (kind) {
    case ObjectKind::hut:
        builder.house({4.2F, 5.5F, 4.6F}, 2.0F, 7.2F, 1.1F, plaster, timber, shingle);
        windows(builder, 4.2F, 0.7F, {-3.4F, 0.0F, 3.4F});
        windows(builder, 4.2F, 2.8F, {-3.4F, 0.0F, 3.4F});
        builder.face({{-0.6F, -5.53F, 0.0F}, {0.6F, -5.53F, 0.0F}, {0.6F, -5.53F, 1.9F}, {-0.6F, -5.53F, 1.9F}}, dark);
        builder.face({{-2.6F, -5.53F, 2.9F}, {-1.5F, -5.53F, 2.9F}, {-1.5F, -5.53F, 4.0F}, {-2.6F, -5.53F, 4.0F}},
                     dark);
        builder.face({{1.5F, -5.53F, 2.9F}, {2.6F, -5.53F, 2.9F}, {2.6F, -5.53F, 4.0F}, {1.5F, -5.53F, 4.0F}}, dark);
        builder.box({1.3F, 1.5F, 5.0F}, {2.1F, 2.3F, 8.0F}, stone, true);
        break;
    case ObjectKind::chapel:
        builder.house({2.8F, 4.8F, 4.2F}, 0.6F, 7.0F, 0.4F, stone, plaster, shingle);
        windows(builder, 2.8F, 1.6F, {-1.6F, 1.6F});
        builder.box({-1.5F, 4.4F, -2.5F}, {1.5F, 7.4F, 9.5F}, plaster, false);
        builder.solid({{-1.5F, 4.4F, 0},
                       {1.5F, 4.4F, 0},
                       {1.5F, 7.4F, 0},
                       {-1.5F, 7.4F, 0},
                       {-1.5F, 4.4F, 9.5F},
                       {1.5F, 4.4F, 9.5F},
                       {1.5F, 7.4F, 9.5F},
                       {-1.5F, 7.4F, 9.5F}});
        builder.cone({0, 5.9F, 9.4F}, 2.4F, 15.5F, 4, 0.25F * std::numbers::pi_v<float>, copper);
        builder.face({{-0.55F, -4.83F, 0.0F},
                      {0.55F, -4.83F, 0.0F},
                      {0.55F, -4.83F, 2.2F},
                      {0.0F, -4.83F, 2.8F},
                      {-0.55F, -4.83F, 2.2F}},
                     dark);
        break;
    case ObjectKind::barn:
        builder.house({3.2F, 4.4F, 3.0F}, 0.5F, 5.0F, 0.7F, stone, weathered, weathered * 0.75F);
        builder.face({{-1.2F, -4.43F, 0.3F}, {1.2F, -4.43F, 0.3F}, {1.2F, -4.43F, 2.7F}, {-1.2F, -4.43F, 2.7F}}, dark);
        break;
    case ObjectKind::spruce:
        conifer(builder, 17.0F, 3.2F, {0.030F, 0.055F, 0.024F}, 0.9F);
        break;
    case ObjectKind::larch:
        conifer(builder, 13.0F, 3.0F, {0.070F, 0.105F, 0.036F}, 1.0F);
        break;
    case ObjectKind::boulder:
        boulder(builder);
        break;
    case ObjectKind::linden:
        broadleaf(builder, 14.0F, 5.2F, {0.058F, 0.098F, 0.030F});
        break;
    case ObjectKind::fence:
        fence(builder);
        break;
    case ObjectKind::grove:
        grove(builder);
        break;
    }
    for (const Vertex& v : object.mesh.vertices) {
        object.radius_m = std::max(object.radius_m, std::hypot(v.position_m.x, v.position_m.y));
        object.height_m = std::max(object.height_m, v.position_m.z);
    }
    return object;
}

} // namespace alpenglow::sandbox
