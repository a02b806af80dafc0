// The triangle mesh that transfer is baked for.
#pragma once

#include <alpenglow/core/result.hpp>

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::prt {

// Positions in the object's frame, metres. A surface faces the side that its vertices stand counter-clockwise on.
struct Mesh {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;    // unit, one a vertex; empty until compute_normals
    std::vector<glm::uvec3> triangles; // vertex indices
    std::vector<glm::vec3> albedo;     // one a vertex, linear Rec.709, 0 .. 1; empty: the bake's default
    std::vector<std::uint8_t> mirror;  // one a triangle, 1: a perfect mirror; empty: none
    std::vector<glm::vec2> texcoords;  // one a vertex, for texel bakes; may be empty
};

// Vertex normals: triangle normals weighted by the corner's angle. Vertices of no proper triangle get (0, 0, 0).
void compute_normals(Mesh& mesh);

// 64 bits of everything that a bake depends on: positions, normals, triangles, albedo, mirrors.
[[nodiscard]] std::uint64_t mesh_hash(const Mesh& mesh) noexcept;

struct Bounds {
    glm::vec3 low{0.0F};
    glm::vec3 high{0.0F};
};
[[nodiscard]] Bounds bounds(const Mesh& mesh) noexcept;

} // namespace alpenglow::prt
