#include "sandbox/app/transfer_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <alpenglow/prt/shapes.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;

std::uint32_t u32(int value) {
    return static_cast<std::uint32_t>(value);
}

// Quads between rows of `around` vertices that wrap, counter-clockwise where rows go up and columns to the right as
// seen from outside.
void wrap_rows(prt::Mesh& mesh, std::uint32_t first, int around, int rows) {
    const std::uint32_t n = u32(around);
    for (std::uint32_t r = 0; r + 1 < u32(rows); ++r) {
        for (std::uint32_t a = 0; a < n; ++a) {
            const std::uint32_t b = (a + 1) % n;
            const std::uint32_t row = first + r * n;
            mesh.triangles.emplace_back(row + a, row + b, row + n + b);
            mesh.triangles.emplace_back(row + a, row + n + b, row + n + a);
        }
    }
}

// A profile (radius, height) turned about +Z, walked so that its outside is on the right.
void append_turned(prt::Mesh& mesh, const std::vector<glm::vec2>& profile, int around) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& p : profile) {
        for (int a = 0; a < around; ++a) {
            const float phi = 2.0F * pi_f * static_cast<float>(a) / static_cast<float>(around);
            mesh.positions.emplace_back(p.x * std::cos(phi), p.x * std::sin(phi), p.y);
        }
    }
    wrap_rows(mesh, first, around, static_cast<int>(profile.size()));
}

std::vector<glm::vec2> along(glm::vec2 from, glm::vec2 to, int steps) {
    std::vector<glm::vec2> points;
    for (int i = 0; i <= steps; ++i) {
        points.push_back(glm::mix(from, to, static_cast<float>(i) / static_cast<float>(steps)));
    }
    return points;
}

// Signed distances.
float round_cone(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b, float ra, float rb) {
    const glm::vec3 ab = b - a;
    const float t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0F, 1.0F);
    return glm::length(p - a - t * ab) - glm::mix(ra, rb, t);
}

float ellipsoid(const glm::vec3& p, const glm::vec3& centre,
                const glm::vec3& radii) { // not exact, but zero where it should be
    const glm::vec3 q = (p - centre) / radii;
    const float k = glm::length(q);
    return k < 1e-6F ? -std::min({radii.x, radii.y, radii.z}) : k * (k - 1.0F) / glm::length(q / radii);
}

float blend(float a, float b, float width) { // smooth minimum, polynomial
    const float h = std::max(width - std::abs(a - b), 0.0F) / width;
    return std::min(a, b) - 0.25F * h * h * width;
}

// A robe: a cone around an axis, its radius swinging with the azimuth, the more the lower.
float robe(const glm::vec3& p) {
    constexpr float top = 1.13F;
    constexpr float hem = 0.20F;
    const float down = std::clamp((top - p.z) / (top - hem), 0.0F, 1.0F);
    const glm::vec2 axis(0.01F - 0.03F * down, -0.02F * down);
    const glm::vec2 q(p.x - axis.x, (p.y - axis.y) * 1.2F);
    const float phi = std::atan2(q.y, q.x);
    const float twist = phi + 0.9F * down;
    const float folds = std::cos(9.0F * twist) + 0.5F * std::cos(5.0F * twist + 1.3F);
    const float radius = glm::mix(0.135F, 0.265F, std::pow(down, 0.8F)) + 0.022F * down * folds;
    const float side = (glm::length(q) - radius) * 0.75F;
    return std::max({side, p.z - top, hem - p.z});
}

float figure_distance(const glm::vec3& at) {
    constexpr float plinth_m = 0.5F;
    const glm::vec3 p = at - glm::vec3(0.0F, 0.0F, plinth_m);
    // Trunk.
    float d = ellipsoid(p, {0.0F, 0.0F, 1.29F}, {0.165F, 0.115F, 0.20F});
    d = blend(d, round_cone(p, {0.005F, 0.0F, 1.02F}, {0.0F, 0.005F, 1.22F}, 0.135F, 0.12F), 0.08F);
    d = blend(d, ellipsoid(p, {0.01F, 0.005F, 0.97F}, {0.165F, 0.125F, 0.13F}), 0.06F);
    d = blend(d, round_cone(p, {-0.15F, 0.01F, 1.41F}, {0.15F, 0.01F, 1.43F}, 0.062F, 0.062F), 0.08F);
    // Neck and head, turned up to the raised hand.
    d = blend(d, round_cone(p, {0.0F, 0.01F, 1.44F}, {0.015F, -0.005F, 1.56F}, 0.055F, 0.05F), 0.05F);
    float head = ellipsoid(p, {0.025F, -0.012F, 1.665F}, {0.078F, 0.098F, 0.118F});
    head =
        blend(head, round_cone(p, {0.04F, -0.105F, 1.665F}, {0.042F, -0.118F, 1.64F}, 0.012F, 0.018F), 0.03F); // nose
    head = blend(head, ellipsoid(p, {0.032F, -0.075F, 1.575F}, {0.035F, 0.03F, 0.025F}), 0.04F);               // chin
    head = blend(head, ellipsoid(p, {0.01F, 0.10F, 1.70F}, {0.06F, 0.055F, 0.055F}), 0.03F);                   // hair
    d = blend(d, head, 0.03F);
    // The raised arm and its ball.
    d = blend(d, round_cone(p, {0.17F, 0.01F, 1.42F}, {0.37F, -0.05F, 1.56F}, 0.055F, 0.043F), 0.05F);
    d = blend(d, round_cone(p, {0.37F, -0.05F, 1.56F}, {0.35F, -0.11F, 1.82F}, 0.043F, 0.030F), 0.03F);
    d = blend(d, ellipsoid(p, {0.348F, -0.115F, 1.86F}, {0.045F, 0.04F, 0.05F}), 0.03F);
    d = blend(d, glm::length(p - glm::vec3(0.345F, -0.12F, 1.965F)) - 0.085F, 0.02F);
    // The arm on the hip.
    d = blend(d, round_cone(p, {-0.17F, 0.01F, 1.41F}, {-0.37F, 0.06F, 1.20F}, 0.055F, 0.042F), 0.05F);
    d = blend(d, round_cone(p, {-0.37F, 0.06F, 1.20F}, {-0.19F, -0.06F, 1.04F}, 0.042F, 0.032F), 0.03F);
    // Robe, one knee forward under it, and feet.
    d = blend(d, robe(p), 0.05F);
    d = blend(d, ellipsoid(p, {-0.10F, -0.13F, 0.58F}, {0.09F, 0.10F, 0.20F}), 0.10F);
    d = blend(d, round_cone(p, {0.09F, 0.02F, 0.22F}, {0.09F, -0.02F, 0.04F}, 0.06F, 0.045F), 0.03F);
    d = blend(d, round_cone(p, {0.09F, 0.0F, 0.04F}, {0.11F, -0.17F, 0.03F}, 0.045F, 0.035F), 0.03F);
    d = blend(d, round_cone(p, {-0.11F, -0.02F, 0.22F}, {-0.13F, -0.05F, 0.04F}, 0.06F, 0.045F), 0.03F);
    d = blend(d, round_cone(p, {-0.13F, -0.03F, 0.04F}, {-0.18F, -0.19F, 0.03F}, 0.045F, 0.035F), 0.03F);
    // A cloth over the shoulder.
    d = blend(d, round_cone(p, {0.13F, -0.08F, 1.43F}, {-0.12F, -0.12F, 1.05F}, 0.035F, 0.05F), 0.04F);
    // The plinth: a rounded drum with a cornice.
    const float r = glm::length(glm::vec2(at));
    const auto drum = [&](float radius, float low, float high) {
        const glm::vec2 q(r - radius + 0.03F, std::abs(at.z - 0.5F * (low + high)) - 0.5F * (high - low) + 0.03F);
        return glm::length(glm::max(q, 0.0F)) + std::min(std::max(q.x, q.y), 0.0F) - 0.03F;
    };
    d = std::min(d, drum(0.36F, -0.2F, 0.44F));
    return std::min(d, drum(0.42F, 0.40F, plinth_m));
}

} // namespace

void paint(prt::Mesh& mesh, const glm::vec3& albedo) {
    mesh.albedo.assign(mesh.positions.size(), albedo);
}

prt::Mesh surface_nets(const std::function<float(const glm::vec3&)>& distance_m, const glm::vec3& low_m,
                       const glm::vec3& high_m, float cell_m) {
    const glm::ivec3 n = glm::ivec3(glm::ceil((high_m - low_m) / cell_m)) + 1; // nodes
    const auto node = [&](int i, int j, int k) {
        return static_cast<std::size_t>(i) +
               static_cast<std::size_t>(n.x) *
                   (static_cast<std::size_t>(j) + static_cast<std::size_t>(n.y) * static_cast<std::size_t>(k));
    };
    const auto place = [&](int i, int j, int k) {
        return low_m + cell_m * glm::vec3(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
    };
    std::vector<float> value(node(0, 0, n.z));
    for (int k = 0; k < n.z; ++k) {
        for (int j = 0; j < n.y; ++j) {
            for (int i = 0; i < n.x; ++i) {
                value[node(i, j, k)] = distance_m(place(i, j, k));
            }
        }
    }
    constexpr std::uint32_t none = 0xFFFFFFFFU;
    std::vector<std::uint32_t> vertex(value.size(), none); // of the cell above a node
    prt::Mesh mesh;
    const float h = 0.1F * cell_m;
    const auto gradient = [&](const glm::vec3& p) {
        const glm::vec3 dx(h, 0.0F, 0.0F);
        const glm::vec3 dy(0.0F, h, 0.0F);
        const glm::vec3 dz(0.0F, 0.0F, h);
        return glm::vec3(distance_m(p + dx) - distance_m(p - dx), distance_m(p + dy) - distance_m(p - dy),
                         distance_m(p + dz) - distance_m(p - dz)) /
               (2.0F * h);
    };
    for (int k = 0; k + 1 < n.z; ++k) {
        for (int j = 0; j + 1 < n.y; ++j) {
            for (int i = 0; i + 1 < n.x; ++i) {
                glm::vec3 sum(0.0F);
                int crossings = 0;
                for (int axis = 0; axis < 3; ++axis) {
                    for (int edge = 0; edge < 4; ++edge) {
                        glm::ivec3 a(i, j, k);
                        a[(axis + 1) % 3] += edge & 1;
                        a[(axis + 2) % 3] += edge >> 1;
                        glm::ivec3 b = a;
                        ++b[axis];
                        const float va = value[node(a.x, a.y, a.z)];
                        const float vb = value[node(b.x, b.y, b.z)];
                        if ((va < 0.0F) != (vb < 0.0F)) {
                            sum += glm::mix(place(a.x, a.y, a.z), place(b.x, b.y, b.z), va / (va - vb));
                            ++crossings;
                        }
                    }
                }
                if (crossings == 0) {
                    continue;
                }
                glm::vec3 p = sum / static_cast<float>(crossings);
                for (int step = 0; step < 3; ++step) { // onto the surface, within the cell
                    const glm::vec3 g = gradient(p);
                    const float length2 = glm::dot(g, g);
                    if (length2 > 1e-4F) {
                        p -= distance_m(p) / length2 * g;
                    }
                }
                vertex[node(i, j, k)] = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(glm::clamp(p, place(i, j, k), place(i + 1, j + 1, k + 1)));
            }
        }
    }
    for (int k = 1; k + 1 < n.z; ++k) {
        for (int j = 1; j + 1 < n.y; ++j) {
            for (int i = 1; i + 1 < n.x; ++i) {
                for (int axis = 0; axis < 3; ++axis) {
                    glm::ivec3 b(i, j, k);
                    ++b[axis];
                    const bool inside = value[node(i, j, k)] < 0.0F;
                    if (inside == (value[node(b.x, b.y, b.z)] < 0.0F)) {
                        continue;
                    }
                    std::array<std::uint32_t, 4> quad{}; // cells around the edge, counter-clockwise about its axis
                    for (int c = 0; c < 4; ++c) {
                        glm::ivec3 cell(i, j, k);
                        cell[(axis + 1) % 3] -= c == 0 || c == 3 ? 1 : 0;
                        cell[(axis + 2) % 3] -= c < 2 ? 1 : 0;
                        quad[static_cast<std::size_t>(c)] = vertex[node(cell.x, cell.y, cell.z)];
                    }
                    if (!inside) {
                        std::swap(quad[1], quad[3]);
                    }
                    mesh.triangles.emplace_back(quad[0], quad[1], quad[2]);
                    mesh.triangles.emplace_back(quad[0], quad[2], quad[3]);
                }
            }
        }
    }
    for (const glm::vec3& p : mesh.positions) {
        const glm::vec3 g = gradient(p);
        const float length = glm::length(g);
        mesh.normals.push_back(length > 1e-6F ? g / length : glm::vec3(0.0F, 0.0F, 1.0F));
    }
    return mesh;
}

prt::Mesh make_figure(float cell_m) {
    prt::Mesh mesh = surface_nets(figure_distance, {-0.56F, -0.5F, -0.08F}, {0.56F, 0.5F, 2.62F}, cell_m);
    constexpr glm::vec3 marble(0.42F, 0.40F, 0.36F);
    constexpr glm::vec3 sandstone(0.24F, 0.185F, 0.12F);
    for (const glm::vec3& p : mesh.positions) {
        mesh.albedo.push_back(p.z > 0.505F ? marble : sandstone);
    }
    return mesh;
}

prt::Mesh make_disc(float radius_m, float thickness_m, int around, int rings,
                    const std::function<glm::vec3(float radius_m)>& albedo) {
    prt::Mesh mesh;
    const float bevel = 0.3F * thickness_m;
    std::vector<glm::vec2> profile = along({radius_m, -thickness_m}, {radius_m, -bevel}, 2);
    profile.emplace_back(radius_m - 0.3F * bevel, -0.3F * bevel);
    const std::vector<glm::vec2> top = along({radius_m - bevel, 0.0F}, {0.02F * radius_m, 0.0F}, rings);
    profile.insert(profile.end(), top.begin(), top.end());
    append_turned(mesh, profile, around);
    const auto last = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.emplace_back(0.0F, 0.0F, 0.0F);
    for (std::uint32_t a = 0; a < u32(around); ++a) {
        mesh.triangles.emplace_back(last - u32(around) + a, last - u32(around) + (a + 1) % u32(around), last);
    }
    prt::compute_normals(mesh);
    for (const glm::vec3& p : mesh.positions) {
        mesh.albedo.push_back(albedo(glm::length(glm::vec2(p))));
    }
    return mesh;
}

prt::Mesh make_knot(float size_m, float tube_m, int along_count, int across, const glm::vec3& albedo) {
    prt::Mesh mesh;
    const auto curve = [&](float t) {
        const float r = 2.0F + std::cos(3.0F * t);
        return size_m / 3.0F * glm::vec3(r * std::cos(2.0F * t), 0.9F * std::sin(3.0F * t), r * std::sin(2.0F * t));
    };
    // Frames carried along, and the twist that closes them spread over the way.
    const float step = 2.0F * pi_f / static_cast<float>(along_count);
    std::vector<glm::vec3> sides;
    glm::vec3 side(0.0F, 1.0F, 0.0F);
    const auto tangent_at = [&](int i) {
        const float t = step * static_cast<float>(i);
        return glm::normalize(curve(t + 0.25F * step) - curve(t - 0.25F * step));
    };
    for (int i = 0; i <= along_count; ++i) {
        const glm::vec3 tangent = tangent_at(i);
        side = glm::normalize(side - glm::dot(side, tangent) * tangent);
        sides.push_back(side);
    }
    const glm::vec3 first_tangent = tangent_at(0);
    const float open = std::atan2(glm::dot(glm::cross(sides.back(), sides.front()), first_tangent),
                                  glm::dot(sides.back(), sides.front()));
    float lowest = 0.0F;
    for (int i = 0; i < along_count; ++i) {
        const glm::vec3 tangent = tangent_at(i);
        const glm::vec3 up = glm::cross(tangent, sides[static_cast<std::size_t>(i)]);
        const float turn = open * static_cast<float>(i) / static_cast<float>(along_count);
        for (int j = 0; j < across; ++j) {
            const float phi = 2.0F * pi_f * static_cast<float>(j) / static_cast<float>(across) + turn;
            mesh.positions.push_back(curve(step * static_cast<float>(i)) +
                                     tube_m *
                                         (std::cos(phi) * sides[static_cast<std::size_t>(i)] + std::sin(phi) * up));
            lowest = std::min(lowest, mesh.positions.back().z);
        }
    }
    const std::uint32_t n = u32(across);
    for (std::uint32_t i = 0; i < u32(along_count); ++i) {
        const std::uint32_t next = (i + 1) % u32(along_count);
        for (std::uint32_t j = 0; j < n; ++j) {
            const std::uint32_t k = (j + 1) % n;
            mesh.triangles.emplace_back(i * n + j, next * n + k, next * n + j);
            mesh.triangles.emplace_back(i * n + j, i * n + k, next * n + k);
        }
    }
    for (glm::vec3& p : mesh.positions) {
        p.z -= lowest;
    }
    prt::compute_normals(mesh);
    paint(mesh, albedo);
    return mesh;
}

prt::Mesh make_ring(float inner_m, float outer_m, float height_m, int around, int up, const glm::vec3& albedo) {
    prt::Mesh mesh;
    append_turned(mesh, along({outer_m, 0.0F}, {outer_m, height_m}, up), around);
    append_turned(mesh, along({outer_m, height_m}, {inner_m, height_m}, 1), around);
    append_turned(mesh, along({inner_m, height_m}, {inner_m, 0.0F}, up), around);
    prt::compute_normals(mesh);
    paint(mesh, albedo);
    return mesh;
}

prt::Mesh make_brazier(int around, const glm::vec3& albedo) {
    prt::Mesh mesh;
    std::vector<glm::vec2> profile;
    for (const glm::vec2 p : {glm::vec2(0.26F, 0.0F),
                              {0.26F, 0.05F},
                              {0.16F, 0.10F},
                              {0.08F, 0.20F},
                              {0.07F, 0.32F},
                              {0.10F, 0.42F},
                              {0.24F, 0.50F},
                              {0.36F, 0.60F},
                              {0.42F, 0.72F},
                              {0.45F, 0.74F},
                              {0.44F, 0.77F},
                              {0.40F, 0.75F},
                              {0.34F, 0.64F},
                              {0.20F, 0.56F},
                              {0.02F, 0.54F}}) {
        profile.push_back(p);
    }
    append_turned(mesh, profile, around);
    mesh = subdivided(std::move(mesh), 1);
    prt::compute_normals(mesh);
    paint(mesh, albedo);
    return mesh;
}

prt::Mesh make_glider(float half_m, int divisions) {
    // Ellipsoids that run into each other; what lies within others is never seen.
    const auto part = [&](int fineness, const glm::vec3& radii, const glm::vec3& at) {
        prt::Mesh mesh = prt::sphere(1.0F, std::max(2, fineness));
        for (glm::vec3& p : mesh.positions) {
            p = half_m * (p * radii + at);
        }
        mesh.normals.clear();
        prt::compute_normals(mesh);
        return mesh;
    };
    prt::Mesh mesh = part(divisions, {1.0F, 0.20F, 0.022F}, {0.0F, 0.08F, 0.05F});                            // wings
    mesh = prt::merged(std::move(mesh), part(divisions / 2, {0.075F, 0.40F, 0.085F}, {0.0F, 0.16F, 0.0F}));   // body
    mesh = prt::merged(std::move(mesh), part(divisions / 2, {0.028F, 0.48F, 0.03F}, {0.0F, -0.34F, 0.015F})); // boom
    mesh = prt::merged(std::move(mesh), part(divisions / 2, {0.30F, 0.075F, 0.014F}, {0.0F, -0.74F, 0.17F})); // tail
    mesh = prt::merged(std::move(mesh), part(divisions / 2, {0.014F, 0.09F, 0.11F}, {0.0F, -0.73F, 0.09F}));  // fin
    for (const glm::vec3& p : mesh.positions) {
        const bool red = std::abs(p.x) > 0.78F * half_m || (p.y < -0.6F * half_m && p.z > 0.1F * half_m);
        mesh.albedo.push_back(red ? glm::vec3(0.40F, 0.05F, 0.025F) : glm::vec3(0.42F, 0.41F, 0.38F));
    }
    return mesh;
}

prt::Mesh subdivided(prt::Mesh mesh, int times) {
    for (int i = 0; i < times; ++i) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, added] =
                middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
            if (added) {
                mesh.positions.push_back(0.5F * (mesh.positions[a] + mesh.positions[b]));
                if (!mesh.normals.empty()) {
                    const glm::vec3 sum = mesh.normals[a] + mesh.normals[b];
                    const float length = glm::length(sum);
                    mesh.normals.push_back(length > 1e-6F ? sum / length : mesh.normals[a]);
                }
                if (!mesh.albedo.empty()) {
                    mesh.albedo.push_back(0.5F * (mesh.albedo[a] + mesh.albedo[b]));
                }
            }
            return at->second;
        };
        std::vector<glm::uvec3> triangles;
        for (const glm::uvec3& t : mesh.triangles) {
            const std::uint32_t ab = middle(t.x, t.y);
            const std::uint32_t bc = middle(t.y, t.z);
            const std::uint32_t ca = middle(t.z, t.x);
            for (const glm::uvec3& part : {glm::uvec3(t.x, ab, ca), {ab, t.y, bc}, {ca, bc, t.z}, {ab, bc, ca}}) {
                triangles.push_back(part);
            }
        }
        mesh.triangles = std::move(triangles);
        mesh.texcoords.clear();
    }
    return mesh;
}

} // namespace alpenglow::sandbox
