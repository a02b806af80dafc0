#include <alpenglow/probes/capture.hpp>

#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/project.hpp>

#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::probes {

namespace {

glm::dvec3 face_direction(int face, double u, double v) {
    switch (face) {
    case 0:
        return {1.0, -v, -u};
    case 1:
        return {-1.0, -v, u};
    case 2:
        return {u, 1.0, v};
    case 3:
        return {u, -1.0, -v};
    case 4:
        return {u, -v, 1.0};
    default:
        return {-u, -v, -1.0};
    }
}

double edge_coordinate(double texel, int edge) {
    return 2.0 * texel / edge - 1.0;
}

// Solid angle of the face from its centre to (u, v).
double corner_angle(double u, double v) {
    return std::atan2(u * v, std::sqrt(u * u + v * v + 1.0));
}

struct CubeSamples {
    std::vector<glm::dvec3> directions;
    std::vector<double> weights;
};

CubeSamples make_samples(int edge) {
    CubeSamples samples;
    for (int face = 0; face < 6; ++face) {
        for (int row = 0; row < edge; ++row) {
            for (int column = 0; column < edge; ++column) {
                samples.directions.push_back(glm::normalize(
                    face_direction(face, edge_coordinate(column + 0.5, edge), edge_coordinate(row + 0.5, edge))));
                const double u0 = edge_coordinate(column, edge);
                const double u1 = edge_coordinate(column + 1, edge);
                const double v0 = edge_coordinate(row, edge);
                const double v1 = edge_coordinate(row + 1, edge);
                samples.weights.push_back(corner_angle(u0, v0) - corner_angle(u0, v1) - corner_angle(u1, v0) +
                                          corner_angle(u1, v1));
            }
        }
    }
    return samples;
}

} // namespace

glm::vec3 texel_direction(int face, int column, int row, int edge) noexcept {
    assert(face >= 0 && face < 6 && edge > 0);
    return glm::vec3(
        glm::normalize(face_direction(face, edge_coordinate(column + 0.5, edge), edge_coordinate(row + 0.5, edge))));
}

void capture_probe(const glm::vec3& point_m, int order, const RenderFace& render, std::span<glm::vec3> out) {
    constexpr int edge = capture_size * capture_supersampling;
    constexpr auto texels = static_cast<std::size_t>(edge * edge);
    static const CubeSamples samples = make_samples(edge);
    std::vector<glm::vec3> face(texels);
    std::vector<glm::dvec3> values(6 * texels);
    for (int f = 0; f < 6; ++f) {
        render(point_m, f, edge, face);
        std::copy(face.begin(), face.end(), values.begin() + f * static_cast<std::ptrdiff_t>(texels));
    }
    std::array<glm::dvec3, sh::max_coefficients> coefficients{};
    sh::project_samples(order, samples.directions, values, samples.weights, coefficients);
    for (std::size_t i = 0; i < static_cast<std::size_t>(sh::coefficient_count(order)); ++i) {
        out[i] = glm::vec3(coefficients[i]);
    }
}

} // namespace alpenglow::probes
