#include <alpenglow/prt/shapes.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;

unsigned u(int value) {
    return static_cast<unsigned>(value);
}

// Quads of a (columns + 1) x (rows + 1) grid whose vertices stand row by row from `first` on.
void grid_triangles(Mesh& mesh, unsigned first, int columns, int rows) {
    const unsigned stride = u(columns) + 1;
    for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
            const unsigned a = first + u(r) * stride + u(c);
            mesh.triangles.emplace_back(a, a + 1, a + stride + 1);
            mesh.triangles.emplace_back(a, a + stride + 1, a + stride);
        }
    }
}

// A closed tube: rings of `around` vertices that wrap, and a pole at each end.
Mesh revolve(int around, int rings, const std::function<glm::vec3(float, float)>& point) {
    Mesh mesh;
    mesh.positions.push_back(point(0.0F, 0.0F));
    for (int r = 1; r <= rings; ++r) {
        for (int a = 0; a < around; ++a) {
            mesh.positions.push_back(point(static_cast<float>(a) / static_cast<float>(around),
                                           static_cast<float>(r) / static_cast<float>(rings + 1)));
        }
    }
    mesh.positions.push_back(point(0.0F, 1.0F));
    const unsigned n = u(around);
    const unsigned last = static_cast<unsigned>(mesh.positions.size()) - 1;
    for (unsigned a = 0; a < n; ++a) {
        const unsigned b = (a + 1) % n;
        mesh.triangles.emplace_back(0, 1 + b, 1 + a);
        for (unsigned r = 0; r + 1 < u(rings); ++r) {
            const unsigned row = 1 + r * n;
            mesh.triangles.emplace_back(row + a, row + b, row + n + b);
            mesh.triangles.emplace_back(row + a, row + n + b, row + n + a);
        }
        const unsigned row = 1 + (u(rings) - 1) * n;
        mesh.triangles.emplace_back(row + a, row + b, last);
    }
    return mesh;
}

} // namespace

Mesh sphere(float radius_m, int divisions) {
    const float t = (1.0F + std::sqrt(5.0F)) / 2.0F;
    const glm::vec3 corners[12] = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
    const int faces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                              {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                              {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    Mesh mesh;
    std::map<std::array<int, 6>, unsigned> known; // corners and their weights, sorted, so that edges share vertices
    const auto vertex = [&](const int* face, int i, int j) {
        const int weight[3] = {divisions - i - j, i, j};
        std::array<std::pair<int, int>, 3> parts;
        for (std::size_t k = 0; k < 3; ++k) {
            parts[k] = {weight[k] == 0 ? -1 : face[k], weight[k]};
        }
        std::sort(parts.begin(), parts.end());
        const std::array<int, 6> key{parts[0].first,  parts[1].first,  parts[2].first,
                                     parts[0].second, parts[1].second, parts[2].second};
        const auto [place, added] = known.try_emplace(key, static_cast<unsigned>(mesh.positions.size()));
        if (added) {
            glm::vec3 p(0.0F);
            for (const auto& [corner, w] : parts) {
                p += corner < 0 ? glm::vec3(0.0F) : corners[corner] * static_cast<float>(w);
            }
            mesh.positions.push_back(glm::normalize(p) * radius_m);
        }
        return place->second;
    };
    for (const auto& face : faces) {
        for (int i = 0; i < divisions; ++i) {
            for (int j = 0; i + j < divisions; ++j) {
                mesh.triangles.emplace_back(vertex(face, i, j), vertex(face, i + 1, j), vertex(face, i, j + 1));
                if (i + j + 1 < divisions) {
                    mesh.triangles.emplace_back(vertex(face, i + 1, j), vertex(face, i + 1, j + 1),
                                                vertex(face, i, j + 1));
                }
            }
        }
    }
    compute_normals(mesh);
    return mesh;
}

Mesh inverted(Mesh mesh) {
    for (glm::uvec3& triangle : mesh.triangles) {
        std::swap(triangle.y, triangle.z);
    }
    for (glm::vec3& normal : mesh.normals) {
        normal = -normal;
    }
    return mesh;
}

Mesh heightfield(float half_m, int cells, const std::function<float(float, float)>& height) {
    Mesh mesh;
    for (int r = 0; r <= cells; ++r) {
        for (int c = 0; c <= cells; ++c) {
            const float x = half_m * (2.0F * static_cast<float>(c) / static_cast<float>(cells) - 1.0F);
            const float y = half_m * (2.0F * static_cast<float>(r) / static_cast<float>(cells) - 1.0F);
            mesh.positions.emplace_back(x, y, height(x, y));
            mesh.texcoords.emplace_back(static_cast<float>(c) / static_cast<float>(cells),
                                        static_cast<float>(r) / static_cast<float>(cells));
        }
    }
    grid_triangles(mesh, 0, cells, cells);
    compute_normals(mesh);
    return mesh;
}

Mesh plane(float half_m, int cells) {
    return heightfield(half_m, cells, [](float, float) { return 0.0F; });
}

Mesh box(const glm::vec3& half_m, int cells) {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0F, 1.0F}) {
            const unsigned first = static_cast<unsigned>(mesh.positions.size());
            for (int r = 0; r <= cells; ++r) {
                for (int c = 0; c <= cells; ++c) {
                    const float a = 2.0F * static_cast<float>(c) / static_cast<float>(cells) - 1.0F;
                    const float b = 2.0F * static_cast<float>(r) / static_cast<float>(cells) - 1.0F;
                    glm::vec3 p(0.0F);
                    p[axis] = side;
                    p[(axis + 1) % 3] = a * side;
                    p[(axis + 2) % 3] = b;
                    mesh.positions.push_back(p * half_m);
                }
            }
            grid_triangles(mesh, first, cells, cells);
        }
    }
    compute_normals(mesh);
    return mesh;
}

Mesh torus(float major_m, float minor_m, int around, int across) {
    Mesh mesh;
    for (int a = 0; a < around; ++a) {
        for (int b = 0; b < across; ++b) {
            const float p = 2.0F * pi_f * static_cast<float>(a) / static_cast<float>(around);
            const float q = 2.0F * pi_f * static_cast<float>(b) / static_cast<float>(across);
            const float r = major_m + minor_m * std::cos(q);
            mesh.positions.emplace_back(r * std::cos(p), r * std::sin(p), minor_m * std::sin(q));
        }
    }
    const unsigned n = u(across);
    for (unsigned a = 0; a < u(around); ++a) {
        for (unsigned b = 0; b < n; ++b) {
            const unsigned next_a = (a + 1) % u(around);
            const unsigned next_b = (b + 1) % n;
            mesh.triangles.emplace_back(a * n + b, next_a * n + b, next_a * n + next_b);
            mesh.triangles.emplace_back(a * n + b, next_a * n + next_b, a * n + next_b);
        }
    }
    compute_normals(mesh);
    return mesh;
}

Mesh bowl(float radius_m, int around, int down) {
    Mesh mesh;
    mesh.positions.emplace_back(0.0F, 0.0F, -radius_m);
    const unsigned n = u(around);
    for (int r = 1; r <= down; ++r) {
        const float theta = 0.5F * pi_f * static_cast<float>(r) / static_cast<float>(down);
        for (int a = 0; a < around; ++a) {
            const float phi = 2.0F * pi_f * static_cast<float>(a) / static_cast<float>(around);
            mesh.positions.push_back(radius_m * glm::vec3(std::sin(theta) * std::cos(phi),
                                                          std::sin(theta) * std::sin(phi), -std::cos(theta)));
        }
    }
    for (unsigned a = 0; a < n; ++a) {
        const unsigned b = (a + 1) % n;
        mesh.triangles.emplace_back(0, 1 + a, 1 + b);
        for (unsigned r = 0; r + 1 < u(down); ++r) {
            const unsigned row = 1 + r * n;
            mesh.triangles.emplace_back(row + a, row + n + b, row + b);
            mesh.triangles.emplace_back(row + a, row + n + a, row + n + b);
        }
    }
    compute_normals(mesh);
    return mesh;
}

Mesh figure(int vertices) {
    // A bust, 1.8 m tall: torso, neck, head with brow, nose and chin, arms held close, folds in the cloth.
    const int around = std::max(12, static_cast<int>(std::lround(std::sqrt(static_cast<double>(vertices) / 1.5))));
    const int rings = std::max(8, vertices / around);
    const auto bump = [](float x, float centre, float width) {
        const float d = (x - centre) / width;
        return std::exp(-d * d);
    };
    Mesh mesh = revolve(around, rings, [&](float along, float up) {
        const float phi = 2.0F * pi_f * along;
        const float front = std::cos(phi); // +X is the front
        const float side = std::abs(std::sin(phi));
        float radius = 0.34F * bump(up, 0.12F, 0.16F) + 0.25F * bump(up, 0.42F, 0.18F) + 0.13F * bump(up, 0.82F, 0.1F) +
                       0.05F * bump(up, 0.65F, 0.1F);
        radius *= 1.0F + 0.75F * side * side * bump(up, 0.5F, 0.1F);             // shoulders
        radius *= 1.0F + 0.16F * std::cos(14.0F * phi) * bump(up, 0.15F, 0.14F); // folds
        radius += 0.10F * std::pow(side, 12.0F) * bump(up, 0.38F, 0.09F);        // elbows
        const float face = std::pow(std::max(front, 0.0F), 24.0F);
        radius += face * (0.055F * bump(up, 0.83F, 0.02F) + 0.03F * bump(up, 0.765F, 0.016F)); // nose, chin
        radius += 0.02F * std::pow(std::max(front, 0.0F), 3.0F) * bump(up, 0.875F, 0.015F);    // brow
        radius *= std::sqrt(std::max(0.0F, 1.0F - std::pow(2.0F * up - 1.0F, 10.0F)));
        const float z = 1.8F * (0.5F - 0.5F * std::cos(pi_f * up));
        return glm::vec3(radius * front, radius * std::sin(phi), z);
    });
    compute_normals(mesh);
    return mesh;
}

Mesh glider(float half_m) {
    const float h = half_m;
    Mesh mesh;
    const auto slab = [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, float thickness) {
        const glm::vec3 lift = thickness * glm::normalize(glm::cross(b - a, c - a));
        const unsigned first = static_cast<unsigned>(mesh.positions.size());
        for (const glm::vec3& p : {a, b, c}) {
            mesh.positions.push_back(p + lift);
        }
        for (const glm::vec3& p : {a, b, c}) {
            mesh.positions.push_back(p - lift);
        }
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.triangles.emplace_back(first + 3, first + 5, first + 4);
        for (unsigned i = 0; i < 3; ++i) {
            const unsigned j = (i + 1) % 3;
            mesh.triangles.emplace_back(first + i, first + 3 + i, first + 3 + j);
            mesh.triangles.emplace_back(first + i, first + 3 + j, first + j);
        }
    };
    const glm::vec3 nose{0.0F, 0.6F * h, 0.0F};
    const glm::vec3 tail{0.0F, -0.25F * h, -0.04F * h};
    slab(nose, glm::vec3(-h, -0.4F * h, 0.08F * h), tail, 0.01F * h);
    slab(nose, tail, glm::vec3(h, -0.4F * h, 0.08F * h), 0.01F * h);
    Mesh pilot = box(glm::vec3(0.06F * h, 0.3F * h, 0.05F * h), 4);
    mesh.normals.clear();
    compute_normals(mesh);
    return merged(std::move(mesh), pilot, glm::vec3(0.0F, 0.0F, -0.22F * h));
}

Mesh merged(Mesh a, const Mesh& b, const glm::vec3& shift_of_b_m) {
    const unsigned first = static_cast<unsigned>(a.positions.size());
    const std::size_t first_triangle = a.triangles.size();
    for (const glm::vec3& p : b.positions) {
        a.positions.push_back(p + shift_of_b_m);
    }
    a.normals.resize(first, glm::vec3(0.0F));
    a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    a.normals.resize(a.positions.size(), glm::vec3(0.0F));
    for (const glm::uvec3& triangle : b.triangles) {
        a.triangles.push_back(triangle + first);
    }
    if (!a.albedo.empty() || !b.albedo.empty()) {
        a.albedo.resize(first, glm::vec3(0.5F));
        a.albedo.insert(a.albedo.end(), b.albedo.begin(), b.albedo.end());
        a.albedo.resize(a.positions.size(), glm::vec3(0.5F));
    }
    if (!a.mirror.empty() || !b.mirror.empty()) {
        a.mirror.resize(first_triangle, 0);
        a.mirror.insert(a.mirror.end(), b.mirror.begin(), b.mirror.end());
        a.mirror.resize(a.triangles.size(), 0);
    }
    a.texcoords.clear();
    return a;
}

} // namespace alpenglow::prt
