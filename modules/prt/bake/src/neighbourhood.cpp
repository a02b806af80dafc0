#include <alpenglow/prt/bake_neighbourhood.hpp>

#include "directions.hpp"
#include "hemisphere.hpp"
#include "scene.hpp"
#include "ticker.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/prt/hash.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {
constexpr std::size_t grain = 16;
}

Grid grid_around(const Mesh& mesh, const glm::uvec3& size, float beside, float above, float below) {
    const Bounds box = bounds(mesh);
    const glm::vec3 half = 0.5F * (box.high - box.low);
    const float width = std::max({half.x, half.y, 1e-6F});
    const glm::vec3 low = box.low - width * glm::vec3(beside, beside, below);
    const glm::vec3 high = box.high + width * glm::vec3(beside, beside, above);
    return {size, low, (high - low) / glm::vec3(glm::max(size, glm::uvec3(2)) - 1U)};
}

namespace {

std::size_t point_count(const Grid& grid) {
    return std::size_t{grid.size.x} * grid.size.y * grid.size.z;
}

Status check(const Grid& grid, const NeighbourhoodSettings& s) {
    if (s.order < 1 || s.order > 6 || s.out_order < 2 || s.out_order > 6 || s.rays < 16 ||
        s.rays > (std::size_t{1} << 24U)) {
        return Error{"order " + std::to_string(s.order) + ", out_order " + std::to_string(s.out_order) + ", rays " +
                         std::to_string(s.rays),
                     "neighbourhood settings", "1 .. 6, 2 .. 6, 16 .. 16777216"};
    }
    const std::size_t count = point_count(grid);
    if (count == 0 || count > (std::size_t{1} << 28U) ||
        !(grid.step_m.x > 0.0F && grid.step_m.y > 0.0F && grid.step_m.z > 0.0F)) {
        return Error{std::to_string(grid.size.x) + " x " + std::to_string(grid.size.y) + " x " +
                         std::to_string(grid.size.z) + " points",
                     "neighbourhood grid", "1 to 2^28 points with positive steps"};
    }
    return Ok{};
}

std::uint64_t settings_hash(const Grid& grid, const NeighbourhoodSettings& s) {
    Hasher hasher;
    const auto add = [&](const auto& value) { hasher.add(std::as_bytes(std::span(&value, 1))); };
    add(grid);
    add(s.order);
    add(s.out_order);
    add(s.rays);
    add(s.bounce);
    add(s.default_albedo);
    add(s.seed);
    return hasher.digest();
}

} // namespace

Result<FieldPart> bake_neighbourhood_part(const Mesh& mesh, const Grid& grid, const NeighbourhoodSettings& s,
                                          std::size_t first, std::size_t count) {
    if (const Status status = check(grid, s); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    assert(first + count <= point_count(grid));
    const Result<Scene> scene = Scene::build(mesh, s.threads);
    if (!scene) {
        return scene.error();
    }
    Bake surface;
    if (s.bounce) {
        BakeSettings settings;
        settings.order = s.order;
        settings.transport = Transport::interreflected;
        settings.default_albedo = s.default_albedo;
        settings.seed = s.seed;
        settings.threads = s.threads;
        Result<Bake> baked = bake(mesh, settings);
        if (!baked) {
            return baked.error();
        }
        surface = std::move(*baked);
    }
    FieldPart part;
    part.kind = TransferKind::neighbourhood;
    part.input_hash = mesh_hash(mesh);
    part.settings_hash = settings_hash(grid, s);
    part.first = first;
    part.count = count;
    const auto columns = static_cast<std::size_t>(s.order * s.order);
    const auto rows = static_cast<std::size_t>(s.out_order * s.out_order);
    const std::size_t width = rows * columns;
    part.values.resize(count * width);

    const std::vector<glm::dvec3> exact = fibonacci_sphere(s.rays);
    const std::vector<glm::vec3> directions(exact.begin(), exact.end());
    std::vector<CoefficientRow> y(directions.size());
    std::array<double, sh::max_coefficients> values{};
    for (std::size_t k = 0; k < directions.size(); ++k) {
        sh::evaluate_basis(std::max(s.order, s.out_order), exact[k], values);
        for (std::size_t i = 0; i < row_floats && i < values.size(); ++i) {
            y[k].values[i] = static_cast<float>(values[i]);
        }
    }
    part.inside.assign(count, 0);
    const double cpu = process_cpu_seconds();
    Ticker ticker(s.progress, "rays", 0.0, 1.0, count);
    parallel_for(
        count, grain,
        [&](std::size_t begin, std::size_t end) {
            std::vector<SceneHit> hits(directions.size());
            std::array<CoefficientRow, 36> sum;
            std::array<float, 36> leaving{};
            const float weight = static_cast<float>(4.0 * pi / static_cast<double>(directions.size()));
            for (std::size_t k_point = begin; k_point < end && !ticker.cancelled(); ++k_point) {
                const std::size_t p = first + k_point;
                const glm::vec3 at =
                    grid.origin_m + grid.step_m * glm::vec3(static_cast<float>(p % grid.size.x),
                                                            static_cast<float>(p / grid.size.x % grid.size.y),
                                                            static_cast<float>(p / grid.size.x / grid.size.y));
                scene->intersect(at, directions, hits.data());
                // Blocked directions are few: their sum is taken off the identity, which free points then have exactly.
                sum.fill(CoefficientRow{});
                std::size_t blocked = 0;
                std::size_t backs = 0;
                for (std::size_t k = 0; k < hits.size(); ++k) {
                    if (hits[k].triangle == SceneHit::none) {
                        continue;
                    }
                    ++blocked;
                    backs += hits[k].back ? 1 : 0;
                    std::copy_n(y[k].values.begin(), columns, leaving.begin());
                    if (s.bounce && !hits[k].back) {
                        const glm::uvec3& t = mesh.triangles[hits[k].triangle];
                        const float bary[3] = {1.0F - hits[k].u - hits[k].v, hits[k].u, hits[k].v};
                        for (int c = 0; c < 3; ++c) {
                            const float albedo =
                                mesh.albedo.empty() ? s.default_albedo
                                                    : glm::dot(mesh.albedo[t[c]], glm::vec3(0.2126F, 0.7152F, 0.0722F));
                            const std::span<const float> m = surface.field.point(t[c]);
                            for (std::size_t j = 0; j < columns; ++j) {
                                leaving[j] -= bary[c] * albedo * m[j];
                            }
                        }
                    }
                    for (std::size_t i = 0; i < rows; ++i) {
                        for (std::size_t j = 0; j < columns; ++j) {
                            sum[i].values[j] += y[k].values[i] * leaving[j];
                        }
                    }
                }
                const std::span<float> m(part.values.data() + k_point * width, width);
                for (std::size_t i = 0; i < rows; ++i) {
                    for (std::size_t j = 0; j < columns; ++j) {
                        m[i * columns + j] = (i == j ? 1.0F : 0.0F) - weight * sum[i].values[j];
                    }
                }
                part.inside[k_point] = 2 * backs > directions.size() ? 1 : 0;
                if (blocked == directions.size()) { // closed in: exactly dark but for what bounces
                    if (!s.bounce) {
                        std::fill(m.begin(), m.end(), 0.0F);
                    }
                }
                ticker.done(1);
            }
        },
        s.threads);
    if (ticker.cancelled()) {
        return Error{"cancelled", "bake", ""};
    }
    part.rays = count * directions.size();
    part.cpu_s = process_cpu_seconds() - cpu;
    return part;
}

Result<Bake> bake_neighbourhood(const Mesh& mesh, const Grid& grid, const NeighbourhoodSettings& s) {
    const double start = wall_seconds();
    if (const Status status = check(grid, s); !status) {
        return status.error();
    }
    Result<FieldPart> part = bake_neighbourhood_part(mesh, grid, s, 0, point_count(grid));
    if (!part) {
        return part.error();
    }
    std::vector<FieldPart> parts;
    parts.push_back(std::move(part).value());
    Result<Bake> baked = finish_neighbourhood(mesh, grid, s, std::move(parts));
    if (baked) {
        baked->report.wall_s = wall_seconds() - start;
    }
    return baked;
}

Result<Bake> finish_neighbourhood(const Mesh& mesh, const Grid& grid, const NeighbourhoodSettings& s,
                                  std::vector<FieldPart> parts) {
    const double start = wall_seconds();
    if (const Status status = check(grid, s); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    const std::size_t count = point_count(grid);
    Bake result;
    TransferField& field = result.field;
    field.kind = TransferKind::neighbourhood;
    field.order = s.order;
    field.out_order = s.out_order;
    field.count = count;
    field.grid = grid;
    field.mesh_hash = mesh_hash(mesh);
    const std::size_t width = field.width();
    Result<FieldPart> all = joined(std::move(parts), field.kind, field.mesh_hash, settings_hash(grid, s), count, width);
    if (!all) {
        return all.error();
    }
    if (all->inside.size() != count) {
        return Error{std::to_string(all->inside.size()) + " marks of the inside", "parts", std::to_string(count)};
    }
    field.values = std::move(all->values);
    BakeReport& report = result.report;
    report.mesh = *valid;
    report.points = count;
    report.shadow_rays = all->rays;
    report.rays_cpu_s = all->cpu_s;
    report.inside_points = static_cast<std::size_t>(std::count(all->inside.begin(), all->inside.end(), 1));
    if (report.inside_points == count) {
        return Error{"all " + std::to_string(count) + " points lie inside the mesh", "neighbourhood grid",
                     "points around the mesh"};
    }
    // Fill the inside from its border inwards.
    std::vector<std::uint8_t> hole = std::move(all->inside);
    for (bool again = report.inside_points > 0; again;) {
        again = false;
        std::vector<std::uint8_t> next = hole;
        for (std::size_t p = 0; p < count; ++p) {
            if (hole[p] == 0) {
                continue;
            }
            const glm::ivec3 c(static_cast<int>(p % grid.size.x), static_cast<int>(p / grid.size.x % grid.size.y),
                               static_cast<int>(p / grid.size.x / grid.size.y));
            std::vector<double> sum(width, 0.0);
            int found = 0;
            for (int axis = 0; axis < 3; ++axis) {
                for (const int side : {-1, 1}) {
                    glm::ivec3 q = c;
                    q[axis] += side;
                    if (q[axis] < 0 || q[axis] >= static_cast<int>(grid.size[axis])) {
                        continue;
                    }
                    const std::size_t at = static_cast<std::size_t>(q.x) +
                                           grid.size.x * (static_cast<std::size_t>(q.y) +
                                                          std::size_t{grid.size.y} * static_cast<std::size_t>(q.z));
                    if (hole[at] != 0) {
                        continue;
                    }
                    ++found;
                    for (std::size_t k = 0; k < width; ++k) {
                        sum[k] += static_cast<double>(field.point(at)[k]);
                    }
                }
            }
            if (found > 0) {
                for (std::size_t k = 0; k < width; ++k) {
                    field.point(p)[k] = static_cast<float>(sum[k] / found);
                }
                next[p] = 0;
                again = true;
            }
        }
        hole = std::move(next);
    }
    report.wall_s = wall_seconds() - start;
    return result;
}

} // namespace alpenglow::prt
