#include "points.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::prt {

std::vector<Point> vertex_points(const Mesh& mesh) {
    Mesh mended;
    mended.positions = mesh.positions;
    mended.triangles = mesh.triangles;
    compute_normals(mended);
    std::vector<double> length(mesh.positions.size(), 0.0);
    std::vector<unsigned> edges(mesh.positions.size(), 0);
    std::vector<glm::dvec3> inwards(mesh.positions.size(), glm::dvec3(0.0)); // towards the middles of the triangles
    std::vector<std::uint8_t> records(mesh.positions.size(), mesh.mirror.empty() ? 1 : 0);
    float largest = 0.0F;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int i = 0; i < 3; ++i) {
            const unsigned a = mesh.triangles[t][i];
            const unsigned b = mesh.triangles[t][(i + 1) % 3];
            const double edge = glm::length(glm::dvec3(mesh.positions[a]) - glm::dvec3(mesh.positions[b]));
            const glm::dvec3 along = glm::dvec3(mesh.positions[b]) - glm::dvec3(mesh.positions[a]);
            inwards[a] += along;
            inwards[b] -= along;
            length[a] += edge;
            length[b] += edge;
            ++edges[a];
            ++edges[b];
            if (!mesh.mirror.empty() && mesh.mirror[t] == 0) {
                records[a] = 1; // a vertex of mirrors alone records no transfer
            }
            largest = std::max(
                {largest, std::abs(mesh.positions[a].x), std::abs(mesh.positions[a].y), std::abs(mesh.positions[a].z)});
        }
    }
    std::vector<Point> points(mesh.positions.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        glm::vec3 normal = mended.normals[v];
        if (normal == glm::vec3(0.0F) || records[v] == 0) {
            continue;
        }
        if (!mesh.normals.empty()) {
            const float norm2 = glm::dot(mesh.normals[v], mesh.normals[v]);
            if (std::abs(norm2 - 1.0F) < 1e-2F) {
                normal = mesh.normals[v] / std::sqrt(norm2);
            }
        }
        const double lift = std::max(1e-3 * length[v] / edges[v], 2e-6 * static_cast<double>(largest));
        // A vertex at a crease lies in the neighbouring wall: a hundredth of an edge into its own surface it does not.
        glm::dvec3 nudge = inwards[v] / static_cast<double>(edges[v]) * 0.01;
        nudge -= glm::dvec3(normal) * glm::dot(nudge, glm::dvec3(normal));
        points[v] = {glm::vec3(glm::dvec3(mesh.positions[v]) + nudge + glm::dvec3(normal) * lift), normal};
    }
    return points;
}

} // namespace alpenglow::prt
