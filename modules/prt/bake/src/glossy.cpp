#include <alpenglow/prt/bake_glossy.hpp>

#include "directions.hpp"
#include "hemisphere.hpp"
#include "points.hpp"
#include "scene.hpp"
#include "ticker.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/prt/hash.hpp>
#include <alpenglow/prt/lobe.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/irradiance.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {

constexpr std::size_t grain = 16;

struct Directions {
    std::vector<glm::vec3> d;
    std::vector<CoefficientRow> y;
};

Directions sphere_directions(std::size_t count, int order) {
    Directions set;
    std::array<double, sh::max_coefficients> y{};
    for (const glm::dvec3& d : fibonacci_sphere(count)) {
        sh::evaluate_basis(order, d, y);
        set.d.emplace_back(d);
        CoefficientRow& row = set.y.emplace_back();
        for (std::size_t i = 0; i < static_cast<std::size_t>(order * order); ++i) {
            row.values[i] = static_cast<float>(y[i]);
        }
    }
    return set;
}

Status check(const GlossySettings& s) {
    if (s.order < 1 || s.order > 6 || s.out_order < 2 || s.out_order > 6) {
        return Error{"order " + std::to_string(s.order) + ", out_order " + std::to_string(s.out_order),
                     "glossy settings", "1 .. 6 and 2 .. 6"};
    }
    if (s.rays < 16 || s.gather_rays < 1 || s.rays > (std::size_t{1} << 24U) || s.gather_rays > s.rays * 64) {
        return Error{std::to_string(s.rays) + " rays, " + std::to_string(s.gather_rays) + " gather rays",
                     "glossy settings", "16 .. 16777216 and 1 or more"};
    }
    if (!(s.default_albedo >= 0.0F && s.specular >= 0.0F && s.default_albedo + s.specular <= 1.0F &&
          s.phong_exponent >= 0.0F)) {
        return Error{"albedo " + std::to_string(s.default_albedo) + ", specular " + std::to_string(s.specular),
                     "glossy settings", "0 or more, together at most 1"};
    }
    return Ok{};
}

std::uint64_t settings_hash(const GlossySettings& s) {
    Hasher hasher;
    const auto add = [&](const auto& value) { hasher.add(std::as_bytes(std::span(&value, 1))); };
    add(s.transport);
    add(s.order);
    add(s.out_order);
    add(s.rays);
    add(s.gather_rays);
    add(s.max_bounces);
    add(s.stop_energy);
    add(s.default_albedo);
    add(s.specular);
    add(s.phong_exponent);
    add(s.seed);
    return hasher.digest();
}

} // namespace

Result<FieldPart> bake_glossy_part(const Mesh& mesh, const GlossySettings& s, std::size_t first, std::size_t count) {
    if (const Status status = check(s); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    const Result<Scene> scene = Scene::build(mesh, s.threads);
    if (!scene) {
        return scene.error();
    }
    assert(first + count <= mesh.positions.size());
    const std::vector<Point> points = vertex_points(mesh);
    FieldPart part;
    part.kind = TransferKind::glossy;
    part.input_hash = mesh_hash(mesh);
    part.settings_hash = settings_hash(s);
    part.first = first;
    part.count = count;
    const auto columns = static_cast<std::size_t>(s.order * s.order);
    const auto rows = static_cast<std::size_t>(s.out_order * s.out_order);
    const std::size_t width = rows * columns;
    part.values.resize(count * width);

    const int top_order = std::max(s.order, s.out_order);
    const Directions set = sphere_directions(s.rays, top_order);
    std::vector<std::uint64_t> rays((count + grain - 1) / grain, 0);
    std::vector<std::size_t> dark(rays.size(), 0);
    std::vector<double> cpu(rays.size(), 0.0);
    const bool bounces = s.transport == Transport::interreflected;
    Ticker ticker(s.progress, "rays", 0.0, bounces ? 0.5 : 1.0, count);
    parallel_for(
        count, grain,
        [&](std::size_t begin, std::size_t end) {
            const double begin_s = thread_cpu_seconds();
            std::vector<glm::vec3> directions;
            std::vector<std::uint32_t> which;
            std::vector<std::uint8_t> hit;
            std::array<CoefficientRow, 36> sum;
            for (std::size_t k_point = begin; k_point < end && !ticker.cancelled(); ++k_point) {
                const std::size_t p = first + k_point;
                if (points[p].normal == glm::vec3(0.0F)) {
                    continue;
                }
                directions.clear();
                which.clear();
                for (std::size_t k = 0; k < set.d.size(); ++k) {
                    if (glm::dot(set.d[k], points[p].normal) > 0.0F) {
                        directions.push_back(set.d[k]);
                        which.push_back(static_cast<std::uint32_t>(k));
                    }
                }
                hit.assign(directions.size(), 0);
                if (s.transport != Transport::unshadowed) {
                    scene->occluded(points[p].origin_m, directions, hit.data());
                    rays[begin / grain] += directions.size();
                }
                sum.fill(CoefficientRow{});
                for (std::size_t k = 0; k < hit.size(); ++k) {
                    if (hit[k] != 0) {
                        continue;
                    }
                    const CoefficientRow& y = set.y[which[k]];
                    for (std::size_t i = 0; i < rows; ++i) {
                        for (std::size_t j = 0; j < columns; ++j) {
                            sum[i].values[j] += y.values[i] * y.values[j];
                        }
                    }
                }
                const float weight = static_cast<float>(4.0 * pi / static_cast<double>(set.d.size()));
                const std::span<float> m(part.values.data() + k_point * width, width);
                for (std::size_t i = 0; i < rows; ++i) {
                    for (std::size_t j = 0; j < columns; ++j) {
                        m[i * columns + j] = weight * sum[i].values[j];
                    }
                }
                dark[begin / grain] += m[0] == 0.0F ? 1 : 0;
                ticker.done(1);
            }
            cpu[begin / grain] = thread_cpu_seconds() - begin_s;
        },
        s.threads);
    if (ticker.cancelled()) {
        return Error{"cancelled", "bake", ""};
    }
    for (std::size_t c = 0; c < rays.size(); ++c) {
        part.rays += rays[c];
        part.dark_points += dark[c];
        part.cpu_s += cpu[c];
    }
    return part;
}

Result<Bake> bake_glossy(const Mesh& mesh, const GlossySettings& s) {
    const double start = wall_seconds();
    Result<FieldPart> part = bake_glossy_part(mesh, s, 0, mesh.positions.size());
    if (!part) {
        return part.error();
    }
    std::vector<FieldPart> parts;
    parts.push_back(std::move(part).value());
    Result<Bake> baked = finish_glossy(mesh, s, std::move(parts));
    if (baked) {
        baked->report.wall_s = wall_seconds() - start;
    }
    return baked;
}

Result<Bake> finish_glossy(const Mesh& mesh, const GlossySettings& s, std::vector<FieldPart> parts) {
    const double start = wall_seconds();
    if (const Status status = check(s); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    const std::vector<Point> points = vertex_points(mesh);
    Bake result;
    TransferField& field = result.field;
    field.kind = TransferKind::glossy;
    field.order = s.order;
    field.out_order = s.out_order;
    field.count = points.size();
    field.mesh_hash = mesh_hash(mesh);
    const std::size_t width = field.width();
    const auto columns = static_cast<std::size_t>(s.order * s.order);
    const auto rows = static_cast<std::size_t>(s.out_order * s.out_order);
    Result<FieldPart> all = joined(std::move(parts), field.kind, field.mesh_hash, settings_hash(s), field.count, width);
    if (!all) {
        return all.error();
    }
    field.values = std::move(all->values);
    BakeReport& report = result.report;
    report.mesh = *valid;
    report.points = field.count;
    report.shadow_rays = all->rays;
    report.dark_points = all->dark_points;
    report.rays_cpu_s = all->cpu_s;
    if (s.transport != Transport::interreflected) {
        report.wall_s = wall_seconds() - start;
        return result;
    }

    const Result<Scene> scene = Scene::build(mesh, s.threads);
    if (!scene) {
        return scene.error();
    }

    // Bounces: what leaves the surfaces that a point sees (the paper's second glossy rule, with a diffuse part beside
    // the lobe). The hits stay the same from bounce to bounce; they are traced again rather than kept.
    const Directions gather = sphere_directions(s.gather_rays, std::max(s.out_order, 1));
    std::array<float, 6> lobe{};
    phong_kernel(static_cast<double>(s.phong_exponent), std::span(lobe).first(static_cast<std::size_t>(s.out_order)));
    std::vector<float> from = field.values;
    std::vector<float> to(from.size());
    const auto energy = [&](const std::vector<float>& values) {
        double sum = 0.0;
        for (std::size_t p = 0; p < field.count; ++p) {
            sum += static_cast<double>(values[p * width]);
        }
        return sum;
    };
    const double direct = energy(from);
    const double bounces_start = process_cpu_seconds();
    for (int b = 1; b <= s.max_bounces && direct > 0.0; ++b) {
        Ticker bounce_ticker(s.progress, "bounces", 0.5, 1.0, field.count);
        parallel_for(
            field.count, grain,
            [&](std::size_t begin, std::size_t end) {
                std::vector<glm::vec3> directions;
                std::vector<std::uint32_t> which;
                std::vector<SceneHit> hits;
                std::array<float, sh::max_coefficients> y_normal{};
                std::array<float, sh::max_coefficients> y_reflected{};
                std::array<float, 36> leaving{};
                for (std::size_t p = begin; p < end && !bounce_ticker.cancelled(); ++p) {
                    const std::span<float> m(to.data() + p * width, width);
                    std::fill(m.begin(), m.end(), 0.0F);
                    if (points[p].normal == glm::vec3(0.0F)) {
                        continue;
                    }
                    directions.clear();
                    which.clear();
                    for (std::size_t k = 0; k < gather.d.size(); ++k) {
                        if (glm::dot(gather.d[k], points[p].normal) > 0.0F) {
                            directions.push_back(gather.d[k]);
                            which.push_back(static_cast<std::uint32_t>(k));
                        }
                    }
                    hits.resize(directions.size());
                    scene->intersect(points[p].origin_m, directions, hits.data());
                    const float weight = static_cast<float>(4.0 * pi / static_cast<double>(gather.d.size()));
                    for (std::size_t k = 0; k < hits.size(); ++k) {
                        const SceneHit& hit = hits[k];
                        if (hit.triangle == SceneHit::none || hit.back) {
                            continue;
                        }
                        const glm::uvec3& t = mesh.triangles[hit.triangle];
                        const float bary[3] = {1.0F - hit.u - hit.v, hit.u, hit.v};
                        glm::vec3 normal(0.0F);
                        float albedo = 0.0F;
                        for (int c = 0; c < 3; ++c) {
                            normal += bary[c] * points[t[c]].normal;
                            albedo += bary[c] * (mesh.albedo.empty() ? s.default_albedo
                                                                     : glm::dot(mesh.albedo[t[c]],
                                                                                glm::vec3(0.2126F, 0.7152F, 0.0722F)));
                        }
                        const float length = glm::length(normal);
                        if (!(length > 1e-6F)) {
                            continue;
                        }
                        normal /= length;
                        albedo = std::min(albedo, 1.0F - s.specular);
                        const glm::vec3 to_viewer = -directions[k];
                        sh::evaluate_basis(s.out_order, normal, y_normal);
                        sh::evaluate_basis(s.out_order,
                                           glm::normalize(2.0F * glm::dot(to_viewer, normal) * normal - to_viewer),
                                           y_reflected);
                        leaving.fill(0.0F);
                        for (int l = 0; l < s.out_order; ++l) {
                            const auto diffuse = static_cast<float>(sh::cosine_factor(l) / pi) * albedo;
                            const float glossy = s.specular * lobe[static_cast<std::size_t>(l)];
                            for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                                const auto at = static_cast<std::size_t>(i);
                                const float w = diffuse * y_normal[at] + glossy * y_reflected[at];
                                for (int c = 0; c < 3; ++c) {
                                    const float* row = from.data() + t[c] * width + at * columns;
                                    const float scale = w * bary[c];
                                    for (std::size_t j = 0; j < columns; ++j) {
                                        leaving[j] += scale * row[j];
                                    }
                                }
                            }
                        }
                        const CoefficientRow& y = gather.y[which[k]];
                        for (std::size_t i = 0; i < rows; ++i) {
                            const float scale = weight * y.values[i];
                            for (std::size_t j = 0; j < columns; ++j) {
                                m[i * columns + j] += scale * leaving[j];
                            }
                        }
                    }
                    bounce_ticker.done(1);
                }
            },
            s.threads);
        if (bounce_ticker.cancelled()) {
            return Error{"cancelled", "bake", ""};
        }
        for (std::size_t i = 0; i < to.size(); ++i) {
            field.values[i] += to[i];
        }
        report.gather_rays += field.count * s.gather_rays / 2;
        report.bounce_energy.push_back(energy(to) / direct);
        from.swap(to);
        if (report.bounce_energy.back() < s.stop_energy) {
            break;
        }
    }
    report.bounces_cpu_s = process_cpu_seconds() - bounces_start;
    report.wall_s = wall_seconds() - start;
    return result;
}

} // namespace alpenglow::prt
