#include <alpenglow/prt/texels.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::prt {

Result<BakePoints> lightmap_points(const Mesh& mesh, std::size_t width, std::size_t height) {
    if (mesh.texcoords.size() != mesh.positions.size() || mesh.positions.empty()) {
        return Error{std::to_string(mesh.texcoords.size()) + " texture coordinates", "mesh", "one a vertex"};
    }
    if (width < 1 || height < 1 || width > 16384 || height > 16384) {
        return Error{std::to_string(width) + " x " + std::to_string(height), "lightmap size", "1 .. 16384"};
    }
    if (mesh.normals.size() != mesh.positions.size()) {
        return Error{std::to_string(mesh.normals.size()) + " normals", "mesh", "one a vertex: call compute_normals"};
    }
    BakePoints points;
    points.positions_m.resize(width * height, glm::vec3(0.0F));
    points.normals.resize(width * height, glm::vec3(0.0F));
    std::size_t covered = 0;
    const glm::dvec2 size(static_cast<double>(width), static_cast<double>(height));
    for (const glm::uvec3& t : mesh.triangles) {
        if (t.x >= mesh.positions.size() || t.y >= mesh.positions.size() || t.z >= mesh.positions.size()) {
            continue;
        }
        const glm::dvec2 a = glm::dvec2(mesh.texcoords[t.x]) * size;
        const glm::dvec2 b = glm::dvec2(mesh.texcoords[t.y]) * size;
        const glm::dvec2 c = glm::dvec2(mesh.texcoords[t.z]) * size;
        const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if (!(std::abs(area) > 0.0) || !std::isfinite(area)) {
            continue;
        }
        const auto first = [](double low) { return static_cast<std::size_t>(std::max(0.0, std::floor(low - 0.5))); };
        const auto last = [](double high, std::size_t limit) {
            return high < 0.0 ? std::size_t{0} : std::min(limit, static_cast<std::size_t>(std::min(high, 1e9) + 1.0));
        };
        for (std::size_t y = first(std::min({a.y, b.y, c.y})); y < last(std::max({a.y, b.y, c.y}), height); ++y) {
            for (std::size_t x = first(std::min({a.x, b.x, c.x})); x < last(std::max({a.x, b.x, c.x}), width); ++x) {
                const glm::dvec2 p(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
                const double u = ((p.x - a.x) * (c.y - a.y) - (c.x - a.x) * (p.y - a.y)) / area;
                const double v = ((b.x - a.x) * (p.y - a.y) - (p.x - a.x) * (b.y - a.y)) / area;
                if (u < -1e-9 || v < -1e-9 || u + v > 1.0 + 1e-9) {
                    continue;
                }
                const auto fu = static_cast<float>(u);
                const auto fv = static_cast<float>(v);
                const glm::vec3 normal =
                    (1.0F - fu - fv) * mesh.normals[t.x] + fu * mesh.normals[t.y] + fv * mesh.normals[t.z];
                if (!(glm::length(normal) > 1e-6F)) {
                    continue;
                }
                points.positions_m[y * width + x] =
                    (1.0F - fu - fv) * mesh.positions[t.x] + fu * mesh.positions[t.y] + fv * mesh.positions[t.z];
                points.normals[y * width + x] = glm::normalize(normal);
                ++covered;
            }
        }
    }
    if (covered == 0) {
        return Error{"no texel is covered by a triangle", "mesh texture coordinates", "charts within 0 .. 1"};
    }
    return points;
}

void dilate(TransferField& field, const BakePoints& points, std::size_t width, std::size_t rings) {
    assert(points.normals.size() == field.count && field.count % width == 0);
    const std::size_t height = field.count / width;
    std::vector<std::uint8_t> filled(field.count);
    for (std::size_t i = 0; i < field.count; ++i) {
        filled[i] = points.normals[i] == glm::vec3(0.0F) ? 0 : 1;
    }
    for (std::size_t ring = 0; ring < rings; ++ring) {
        const std::vector<std::uint8_t> before = filled;
        for (std::size_t i = 0; i < field.count; ++i) {
            if (before[i] != 0) {
                continue;
            }
            std::vector<float> sum(field.width(), 0.0F);
            float found = 0.0F;
            for (std::size_t k = 0; k < 9; ++k) {
                const std::size_t x = i % width + k % 3;
                const std::size_t y = i / width + k / 3;
                if (x < 1 || y < 1 || x > width || y > height || before[(y - 1) * width + x - 1] == 0) {
                    continue;
                }
                found += 1.0F;
                const std::span<const float> m = field.point((y - 1) * width + x - 1);
                for (std::size_t c = 0; c < sum.size(); ++c) {
                    sum[c] += m[c];
                }
            }
            if (found > 0.0F) {
                for (std::size_t c = 0; c < sum.size(); ++c) {
                    field.point(i)[c] = sum[c] / found;
                }
                filled[i] = 1;
            }
        }
    }
}

} // namespace alpenglow::prt
