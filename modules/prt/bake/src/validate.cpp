#include <alpenglow/prt/validate.hpp>

#include <cmath>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::prt {

Result<MeshReport> validate(const Mesh& mesh) {
    const auto wrong = [](const std::string& where, const std::string& what, const std::string& expected) {
        return Error{what, "mesh: " + where, expected};
    };
    MeshReport report;
    report.vertices = mesh.positions.size();
    report.triangles = mesh.triangles.size();
    if (mesh.positions.empty() || mesh.triangles.empty()) {
        return wrong("triangles",
                     std::to_string(mesh.positions.size()) + " vertices and " + std::to_string(mesh.triangles.size()) +
                         " triangles",
                     "one triangle or more");
    }
    if (mesh.positions.size() >= 0xFFFFFFFFU || mesh.triangles.size() >= 0xFFFFFFFFU) {
        return wrong("triangles", "too many for 32-bit indices", "fewer than 2^32 - 1");
    }
    const auto length_fits = [](std::size_t length, std::size_t wanted) { return length == 0 || length == wanted; };
    if (!length_fits(mesh.normals.size(), mesh.positions.size())) {
        return wrong("normals", std::to_string(mesh.normals.size()) + " values", "one a vertex, or none");
    }
    if (!length_fits(mesh.albedo.size(), mesh.positions.size())) {
        return wrong("albedo", std::to_string(mesh.albedo.size()) + " values", "one a vertex, or none");
    }
    if (!length_fits(mesh.mirror.size(), mesh.triangles.size())) {
        return wrong("mirror", std::to_string(mesh.mirror.size()) + " values", "one a triangle, or none");
    }
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::vec3& p = mesh.positions[i];
        for (int axis = 0; axis < 3; ++axis) {
            if (!(std::abs(p[axis]) <= 1e15F)) {
                return wrong("vertex " + std::to_string(i), "coordinate is " + std::to_string(p[axis]),
                             "a finite number of metres up to 1e15");
            }
        }
        if (!mesh.albedo.empty()) {
            for (int channel = 0; channel < 3; ++channel) {
                const float a = mesh.albedo[i][channel];
                if (!(a >= 0.0F && a <= 1.0F)) {
                    return wrong("albedo of vertex " + std::to_string(i), std::to_string(a), "0 .. 1");
                }
            }
        }
    }
    std::vector<std::uint8_t> used(mesh.positions.size(), 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const glm::uvec3& t = mesh.triangles[i];
        for (int corner = 0; corner < 3; ++corner) {
            if (t[corner] >= mesh.positions.size()) {
                return wrong("triangle " + std::to_string(i), "vertex index " + std::to_string(t[corner]),
                             "less than " + std::to_string(mesh.positions.size()));
            }
        }
        const glm::dvec3 a(mesh.positions[t.x]);
        const glm::dvec3 cross = glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
        if (!(glm::dot(cross, cross) > 0.0)) {
            ++report.degenerate_triangles;
            continue;
        }
        used[t.x] = used[t.y] = used[t.z] = 1;
    }
    if (report.degenerate_triangles == report.triangles) {
        return wrong("triangles", "all " + std::to_string(report.triangles) + " have no area",
                     "one triangle with area or more");
    }
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        report.isolated_vertices += used[i] == 0 ? 1 : 0;
        if (!mesh.normals.empty() && used[i] != 0) {
            const float length2 = glm::dot(mesh.normals[i], mesh.normals[i]);
            report.bad_normals += std::abs(length2 - 1.0F) < 1e-2F ? 0 : 1;
        }
    }
    return report;
}

} // namespace alpenglow::prt
