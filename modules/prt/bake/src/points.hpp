// Where rays start.
#pragma once

#include <alpenglow/prt/mesh.hpp>

#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::prt {

// A point to bake at.
struct Point {
    glm::vec3 origin_m{0.0F}; // lifted off the surface
    glm::vec3 normal{0.0F};   // zero: do not bake
};

// Vertices as points: normals mended, origins lifted by a thousandth of the edges around and
// drawn a hundredth towards the middle of their triangles. Vertices of no proper
// triangle, or of mirrors alone, get no normal.
[[nodiscard]] std::vector<Point> vertex_points(const Mesh& mesh);

} // namespace alpenglow::prt
