#include <alpenglow/prt/mesh.hpp>

#include <alpenglow/prt/hash.hpp>

#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::prt {

void compute_normals(Mesh& mesh) {
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
    for (const glm::uvec3& triangle : mesh.triangles) {
        if (triangle.x >= sums.size() || triangle.y >= sums.size() || triangle.z >= sums.size()) {
            continue;
        }
        const glm::dvec3 corner[3] = {mesh.positions[triangle.x], mesh.positions[triangle.y],
                                      mesh.positions[triangle.z]};
        const glm::dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
        const double length = glm::length(normal);
        if (!(length > 0.0) || !std::isfinite(length)) {
            continue;
        }
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3 a = corner[(i + 1) % 3] - corner[i];
            const glm::dvec3 b = corner[(i + 2) % 3] - corner[i];
            const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
            sums[triangle[i]] += normal * (angle / length);
        }
    }
    mesh.normals.resize(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const double length = glm::length(sums[i]);
        mesh.normals[i] = length > 1e-12 ? glm::vec3(sums[i] / length) : glm::vec3(0.0F);
    }
}

std::uint64_t mesh_hash(const Mesh& mesh) noexcept {
    Hasher hasher;
    hasher.add_values(std::span<const glm::vec3>(mesh.positions));
    hasher.add_values(std::span<const glm::vec3>(mesh.normals));
    hasher.add_values(std::span<const glm::uvec3>(mesh.triangles));
    hasher.add_values(std::span<const glm::vec3>(mesh.albedo));
    hasher.add_values(std::span<const std::uint8_t>(mesh.mirror));
    return hasher.digest();
}

Bounds bounds(const Mesh& mesh) noexcept {
    if (mesh.positions.empty()) {
        return {};
    }
    Bounds box{mesh.positions.front(), mesh.positions.front()};
    for (const glm::vec3& p : mesh.positions) {
        box.low = glm::min(box.low, p);
        box.high = glm::max(box.high, p);
    }
    return box;
}

} // namespace alpenglow::prt
