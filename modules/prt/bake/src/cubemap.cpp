#include <alpenglow/prt/bake_cubemap.hpp>

#include "directions.hpp"
#include "hemisphere.hpp"
#include "points.hpp"
#include "scene.hpp"
#include "settings.hpp"
#include "ticker.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {

constexpr std::size_t grain = 16;

// Face 2 axis + (negative ? 1 : 0); the direction of face coordinates (a, b) has 1 or -1 on `axis`.
glm::dvec3 face_direction(std::size_t face, double a, double b) {
    const auto axis = static_cast<int>(face / 2);
    glm::dvec3 d(0.0);
    d[axis] = face % 2 == 0 ? 1.0 : -1.0;
    d[(axis + 1) % 3] = a;
    d[(axis + 2) % 3] = b;
    return d;
}

// Solid angle of the rectangle from the face's centre to (a, b).
double corner_angle(double a, double b) {
    return std::atan2(a * b, std::sqrt(a * a + b * b + 1.0));
}

struct Cube {
    explicit Cube(std::size_t resolution_, int order) : resolution(resolution_) {
        std::array<double, sh::max_coefficients> y{};
        for (std::size_t face = 0; face < 6; ++face) {
            for (std::size_t texel = 0; texel < resolution * resolution; ++texel) {
                const double step = 2.0 / static_cast<double>(resolution);
                const double a = -1.0 + step * (static_cast<double>(texel % resolution) + 0.5);
                const double b = -1.0 + step * (static_cast<double>(texel / resolution) + 0.5);
                const double h = step / 2.0;
                const double angle = corner_angle(a + h, b + h) - corner_angle(a - h, b + h) -
                                     corner_angle(a + h, b - h) + corner_angle(a - h, b - h);
                const glm::dvec3 d = glm::normalize(face_direction(face, a, b));
                sh::evaluate_basis(order, d, y);
                directions.emplace_back(d);
                CoefficientRow& row = rows.emplace_back();
                for (std::size_t i = 0; i < static_cast<std::size_t>(order * order); ++i) {
                    row.values[i] = static_cast<float>(y[i] * angle / pi);
                }
                solid_angle.push_back(static_cast<float>(angle));
            }
        }
    }

    std::size_t resolution;
    std::vector<glm::vec3> directions;
    std::vector<CoefficientRow> rows; // y times solid angle over pi
    std::vector<float> solid_angle;
};

struct Buffers {
    std::vector<float> depth;            // distance along the unnormalised face direction
    std::vector<std::uint32_t> triangle; // SceneHit::none where nothing is
};

// Draws one triangle (corners relative to the eye) into all faces. A texel's direction d hits it if it is on the inner
// side of the three planes through the eye and an edge (Olano and Greer 1997): no clipping is needed.
void draw(const Cube& cube, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, std::uint32_t id,
          Buffers& out) {
    const glm::vec3 edge[3] = {glm::cross(b, c), glm::cross(c, a), glm::cross(a, b)};
    const float volume = glm::dot(a, edge[0]);
    if (volume == 0.0F) {
        return; // seen edge-on
    }
    const float sign = volume > 0.0F ? 1.0F : -1.0F;
    const auto n = static_cast<float>(cube.resolution);
    for (std::size_t face = 0; face < 6; ++face) {
        const auto axis = static_cast<int>(face / 2);
        const float side = face % 2 == 0 ? 1.0F : -1.0F;
        const float w[3] = {side * a[axis], side * b[axis], side * c[axis]};
        if (w[0] <= 0.0F && w[1] <= 0.0F && w[2] <= 0.0F) {
            continue;
        }
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        std::size_t x0 = 0;
        std::size_t x1 = cube.resolution;
        std::size_t y0 = 0;
        std::size_t y1 = cube.resolution;
        if (w[0] > 0.0F && w[1] > 0.0F && w[2] > 0.0F) {
            const auto range = [&](int at, std::size_t& low, std::size_t& high) {
                const float p[3] = {a[at] / w[0], b[at] / w[1], c[at] / w[2]};
                const float smallest = std::clamp(std::min({p[0], p[1], p[2]}), -1.0F, 1.0F);
                const float largest = std::clamp(std::max({p[0], p[1], p[2]}), -1.0F, 1.0F);
                low = static_cast<std::size_t>(std::max(0.0F, std::floor((smallest + 1.0F) * 0.5F * n - 0.5F)));
                high = static_cast<std::size_t>(std::min(n, std::ceil((largest + 1.0F) * 0.5F * n + 0.5F)));
            };
            range(u, x0, x1);
            range(v, y0, y1);
        }
        const float step = 2.0F / n;
        for (std::size_t y = y0; y < y1; ++y) {
            for (std::size_t x = x0; x < x1; ++x) {
                glm::vec3 d(0.0F);
                d[axis] = side;
                d[u] = -1.0F + step * (static_cast<float>(x) + 0.5F);
                d[v] = -1.0F + step * (static_cast<float>(y) + 0.5F);
                const float e0 = sign * glm::dot(d, edge[0]);
                const float e1 = sign * glm::dot(d, edge[1]);
                const float e2 = sign * glm::dot(d, edge[2]);
                if (e0 < 0.0F || e1 < 0.0F || e2 < 0.0F) {
                    continue;
                }
                const float sum = e0 + e1 + e2;
                if (!(sum > 0.0F)) {
                    continue;
                }
                const float t = std::abs(volume) / sum;
                const std::size_t texel = (face * cube.resolution + y) * cube.resolution + x;
                if (t < out.depth[texel]) {
                    out.depth[texel] = t;
                    out.triangle[texel] = id;
                }
            }
        }
    }
}

std::size_t texel_of(const Cube& cube, const glm::vec3& d) {
    const glm::vec3 size = glm::abs(d);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t face = 2 * static_cast<std::size_t>(axis) + (d[axis] > 0.0F ? 0 : 1);
    const auto place = [&](float p) {
        const float at = (p / size[axis] + 1.0F) * 0.5F * static_cast<float>(cube.resolution);
        return std::min(cube.resolution - 1, static_cast<std::size_t>(std::max(at, 0.0F)));
    };
    return (face * cube.resolution + place(d[(axis + 2) % 3])) * cube.resolution + place(d[(axis + 1) % 3]);
}

// What the texels around one point say, into its place of the part.
class Integrator {
public:
    Integrator(const Mesh& mesh, const BakeSettings& settings, const Cube& cube)
        : mesh_(mesh), settings_(settings), cube_(cube), n_(static_cast<std::size_t>(settings.order * settings.order)) {
        for (const glm::dvec3& d : fibonacci_hemisphere(settings.gather_rays)) {
            gather_.emplace_back(d);
        }
    }

    // `k`: the point's place in the part; hits of its gather directions are appended. True where most of them are
    // backs.
    bool operator()(const Point& point, std::span<const std::uint32_t> triangles, std::size_t k, BakePart& part,
                    std::vector<GatherHit>& hits) const {
        const std::span<float> out(part.direct.data() + k * n_, n_);
        // As rays do: the smaller of the two sums.
        CoefficientRow blocked;
        CoefficientRow visible;
        double blocked_part = 0.0;
        double whole = 0.0;
        for (std::size_t texel = 0; texel < cube_.directions.size(); ++texel) {
            const float cosine = glm::dot(cube_.directions[texel], point.normal);
            if (cosine <= 0.0F) {
                continue;
            }
            const double share = static_cast<double>(cosine * cube_.solid_angle[texel]) / pi;
            whole += share;
            const bool hit = triangles[texel] != no_triangle;
            blocked_part += hit ? share : 0.0;
            CoefficientRow& sum = hit ? blocked : visible;
            const CoefficientRow& row = cube_.rows[texel];
            for (std::size_t i = 0; i < n_; ++i) {
                sum.values[i] += cosine * row.values[i];
            }
        }
        blocked_part /= whole;
        part.visibility[k] = static_cast<float>(1.0 - blocked_part);
        unshadowed(settings_.order, point.normal, out);
        for (std::size_t i = 0; i < n_; ++i) {
            out[i] = blocked_part > 0.5 ? visible.values[i] : out[i] - blocked.values[i];
        }
        const double p = 1.0 - blocked_part;
        part.variance[k] = static_cast<float>(2.0 * p * (1.0 - p) * static_cast<double>(n_) / (4.0 * pi) *
                                              std::pow(static_cast<double>(cube_.directions.size()) / 2.0, -1.5));
        if (part.hit_counts.empty() || blocked_part == 0.0) {
            return false;
        }
        const glm::mat3 frame =
            frame_about(point.normal, static_cast<float>(two_pi * uniform(mix(settings_.seed) + 1, part.first + k)));
        std::size_t backs = 0;
        for (const glm::vec3& local : gather_) {
            const glm::vec3 d = frame * local;
            const std::uint32_t t = triangles[texel_of(cube_, d)];
            if (t == no_triangle) {
                continue;
            }
            ++part.hit_counts[k];
            // Where the direction meets the texel's triangle, or comes nearest to.
            const glm::uvec3& corner = mesh_.triangles[t];
            const glm::vec3 a = mesh_.positions[corner.x] - point.origin_m;
            const glm::vec3 b = mesh_.positions[corner.y] - point.origin_m;
            const glm::vec3 c = mesh_.positions[corner.z] - point.origin_m;
            if (glm::dot(glm::cross(b - a, c - a), d) > 0.0F) {
                hits.push_back({SceneHit::none, 0, 0});
                ++backs;
                continue;
            }
            glm::vec3 weight(glm::dot(d, glm::cross(b, c)), glm::dot(d, glm::cross(c, a)),
                             glm::dot(d, glm::cross(a, b)));
            weight = glm::max(glm::dot(weight, glm::vec3(1.0F)) < 0.0F ? -weight : weight, glm::vec3(0.0F));
            const float sum = glm::dot(weight, glm::vec3(1.0F));
            weight = sum > 0.0F ? weight / sum : glm::vec3(1.0F / 3.0F);
            const auto fixed = [](float x) { return static_cast<std::uint16_t>(std::lround(x * 65535.0F)); };
            hits.push_back({t, fixed(weight.y), fixed(weight.z)});
        }
        return 2 * backs > gather_.size();
    }

private:
    const Mesh& mesh_;
    const BakeSettings& settings_;
    const Cube& cube_;
    std::size_t n_;
    std::vector<glm::vec3> gather_;
};

// All triangles around one point.
void draw_all(const Mesh& mesh, const Cube& cube, const Point& point, Buffers& buffers) {
    buffers.depth.assign(cube.directions.size(), std::numeric_limits<float>::max());
    buffers.triangle.assign(cube.directions.size(), no_triangle);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::uvec3& corner = mesh.triangles[t];
        const glm::vec3 a = mesh.positions[corner.x] - point.origin_m;
        const glm::vec3 b = mesh.positions[corner.y] - point.origin_m;
        const glm::vec3 c = mesh.positions[corner.z] - point.origin_m;
        if (glm::dot(a, point.normal) <= 0.0F && glm::dot(b, point.normal) <= 0.0F &&
            glm::dot(c, point.normal) <= 0.0F) {
            continue; // below the horizon
        }
        draw(cube, a, b, c, static_cast<std::uint32_t>(t), buffers);
    }
}

} // namespace

// Without a rasteriser each point is drawn by the thread that sums it up.
Result<BakePart> bake_part_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution,
                                   std::size_t first, std::size_t count, const CubeRasteriser& rasteriser,
                                   std::size_t batch) {
    if (const Status status = check(settings); !status) {
        return status.error();
    }
    if (resolution < 4 || resolution > 128) {
        return Error{std::to_string(resolution), "cube map resolution", "4 .. 128"};
    }
    if (std::find(mesh.mirror.begin(), mesh.mirror.end(), 1) != mesh.mirror.end()) {
        return Error{"mesh has mirrors", "cube map bake", "a ray-traced bake"};
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    assert(first + count <= mesh.positions.size() && batch > 0);
    const std::vector<Point> points = vertex_points(mesh);
    const Cube cube(resolution, settings.order);
    const Integrator integrate(mesh, settings, cube);
    BakePart part;
    part.first = first;
    part.count = count;
    part.mesh_hash = mesh_hash(mesh);
    part.settings_hash = settings_hash(settings);
    const bool bounces = settings.transport == Transport::interreflected;
    part.direct.resize(count * static_cast<std::size_t>(settings.order * settings.order));
    part.visibility.resize(count);
    part.variance.resize(count);
    part.hit_counts.resize(bounces ? count : 0);
    std::vector<std::size_t> traced; // places of the points that want their surroundings
    for (std::size_t k = 0; k < count; ++k) {
        const Point& point = points[first + k];
        if (point.normal == glm::vec3(0.0F)) {
            continue;
        }
        if (settings.transport == Transport::unshadowed) {
            unshadowed(settings.order, point.normal,
                       std::span(part.direct).subspan(k * static_cast<std::size_t>(settings.order * settings.order)));
            part.visibility[k] = 1.0F;
            continue;
        }
        traced.push_back(k);
    }
    Ticker ticker(settings.progress, "cube maps", 0.0, bounces ? 0.9 : 1.0, traced.size());
    const std::size_t texels = cube.directions.size();
    const double cpu = process_cpu_seconds();
    const std::size_t at_once = rasteriser ? std::min(batch, traced.size()) : traced.size();
    std::vector<std::uint32_t> triangles(rasteriser ? at_once * texels : 0);
    std::vector<glm::vec3> eyes;
    for (std::size_t from = 0; from < traced.size(); from += at_once) {
        const std::size_t here = std::min(at_once, traced.size() - from);
        if (rasteriser) {
            eyes.clear();
            for (std::size_t i = 0; i < here; ++i) {
                eyes.push_back(points[first + traced[from + i]].origin_m);
            }
            if (const Status drawn = rasteriser(eyes, std::span(triangles).first(here * texels)); !drawn) {
                return drawn.error();
            }
        }
        std::vector<std::vector<GatherHit>> hits((here + grain - 1) / grain);
        std::vector<std::size_t> inside(hits.size(), 0);
        parallel_for(
            here, grain,
            [&](std::size_t begin, std::size_t end) {
                Buffers buffers;
                for (std::size_t i = begin; i < end && !ticker.cancelled(); ++i) {
                    const std::size_t k = traced[from + i];
                    const Point& point = points[first + k];
                    std::span<const std::uint32_t> seen;
                    if (rasteriser) {
                        seen = std::span(triangles).subspan(i * texels, texels);
                    } else {
                        draw_all(mesh, cube, point, buffers);
                        seen = buffers.triangle;
                    }
                    inside[begin / grain] += integrate(point, seen, k, part, hits[begin / grain]) ? 1 : 0;
                    ticker.done(1);
                }
            },
            settings.threads);
        if (ticker.cancelled()) {
            return Error{"cancelled", "bake", ""};
        }
        for (std::size_t chunk = 0; chunk < hits.size(); ++chunk) {
            part.hits.insert(part.hits.end(), hits[chunk].begin(), hits[chunk].end());
            part.inside_points += inside[chunk];
        }
    }
    part.cpu_s = process_cpu_seconds() - cpu;
    return part;
}

Result<BakePart> bake_part_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution,
                                   std::size_t first, std::size_t count) {
    return bake_part_cubemap(mesh, settings, resolution, first, count, {}, 1);
}

Result<Bake> bake_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution) {
    const double start = wall_seconds();
    Result<BakePart> part = bake_part_cubemap(mesh, settings, resolution, 0, mesh.positions.size());
    if (!part) {
        return part.error();
    }
    std::vector<BakePart> parts;
    parts.push_back(std::move(*part));
    Result<Bake> baked = finish(mesh, settings, std::move(parts));
    if (baked) {
        baked->report.wall_s = wall_seconds() - start;
    }
    return baked;
}

} // namespace alpenglow::prt
