#include <alpenglow/prt/bake.hpp>

#include "directions.hpp"
#include "hemisphere.hpp"
#include "points.hpp"
#include "scene.hpp"
#include "settings.hpp"
#include "ticker.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/core/quiet.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {

constexpr std::size_t grain = 64;

constexpr int most_reflections = 32;

// Everything that tracing needs, made once for a bake.
class Tracer {
public:
    Tracer(const Mesh& mesh, const BakeSettings& settings, const Scene& scene)
        : mesh_(mesh), settings_(settings), scene_(scene), hemisphere_(settings),
          mirrors_(std::find(mesh.mirror.begin(), mesh.mirror.end(), 1) != mesh.mirror.end()) {
        for (const glm::dvec3& d : fibonacci_hemisphere(settings.gather_rays)) {
            gather_.emplace_back(d);
        }
        if (mirrors_) {
            for (const glm::dvec3& d : fibonacci_hemisphere(settings.rays)) {
                fine_.emplace_back(d);
            }
        }
    }

    struct Scratch {
        Hemisphere::Scratch hemisphere;
        std::vector<glm::vec3> directions;
        std::vector<SceneHit> hits;
    };

    [[nodiscard]] double unoccluded_norm() const { return hemisphere_.unoccluded_norm(); }

    // Direct light of point `i`: order^2 values to `out`.
    HemisphereResult direct(const Point& point, std::size_t i, std::span<float> out, Scratch& scratch) const {
        HemisphereResult result;
        const glm::mat3 frame = frame_of(point, i, 0);
        const int order = settings_.order;
        std::array<float, row_floats> bounced{};
        if (!mirrors_) {
            result = hemisphere_.trace(scene_, point.origin_m, frame, i, scratch.hemisphere);
        } else {
            result = direct_with_mirrors(point, frame, bounced, scratch);
        }
        const sh::Rotation rotation(order, glm::dmat3(frame));
        rotation.apply(std::span<const float>(result.transfer.values), out);
        for (std::size_t k = 0; k < out.size(); ++k) {
            out[k] += bounced[k];
        }
        return result;
    }

    // The first surfaces that light bounces off: appends to `hits` one entry for every ray that meets the mesh
    // (triangle none where it meets a back, which is dark). Returns how many.
    std::uint32_t gather(const Point& point, std::size_t i, std::vector<GatherHit>& hits, std::size_t& backs,
                         Scratch& scratch) const {
        const glm::mat3 frame = frame_of(point, i, 1);
        scratch.directions.resize(gather_.size());
        scratch.hits.resize(gather_.size());
        for (std::size_t k = 0; k < gather_.size(); ++k) {
            scratch.directions[k] = frame * gather_[k];
        }
        scene_.intersect(point.origin_m, scratch.directions, scratch.hits.data());
        std::uint32_t count = 0;
        for (std::size_t k = 0; k < gather_.size(); ++k) {
            SceneHit hit = scratch.hits[k];
            if (mirrors_) {
                glm::vec3 direction = scratch.directions[k];
                follow(point.origin_m, direction, hit);
            }
            if (hit.triangle == SceneHit::none) {
                continue;
            }
            ++count;
            backs += hit.back ? 1 : 0;
            const auto fixed = [](float x) {
                return static_cast<std::uint16_t>(std::lround(std::clamp(x, 0.0F, 1.0F) * 65535.0F));
            };
            hits.push_back(hit.back ? GatherHit{SceneHit::none, 0, 0}
                                    : GatherHit{hit.triangle, fixed(hit.u), fixed(hit.v)});
        }
        return count;
    }

    // True where most of what a point sees are backs.
    bool inside(const Point& point, std::size_t i, Scratch& scratch) const {
        constexpr std::size_t probes = 16;
        const glm::mat3 frame = frame_of(point, i, 2);
        scratch.directions.clear();
        for (std::size_t k = 0; k < probes; ++k) {
            scratch.directions.push_back(frame * glm::vec3(cosine_direction((static_cast<double>(k % 4) + 0.5) / 4.0,
                                                                            (static_cast<double>(k / 4) + 0.5) / 4.0)));
        }
        scratch.hits.resize(probes);
        scene_.intersect(point.origin_m, scratch.directions, scratch.hits.data());
        std::size_t backs = 0;
        for (const SceneHit& hit : scratch.hits) {
            backs += hit.triangle != SceneHit::none && hit.back ? 1 : 0;
        }
        return 2 * backs > probes;
    }

private:
    [[nodiscard]] glm::mat3 frame_of(const Point& point, std::size_t i, std::uint64_t use) const {
        const double turn = uniform(mix(settings_.seed) + use, i);
        return frame_about(point.normal, static_cast<float>(two_pi * turn));
    }

    // Follows a ray off mirrors until it meets something else or escapes; false if it was lost between mirrors.
    bool follow(glm::vec3 origin, glm::vec3& direction, SceneHit& hit) const {
        for (int bounce = 0; bounce < most_reflections; ++bounce) {
            if (hit.triangle == SceneHit::none || mesh_.mirror[hit.triangle] == 0 || hit.back) {
                return true;
            }
            const glm::uvec3& t = mesh_.triangles[hit.triangle];
            const glm::vec3& a = mesh_.positions[t.x];
            const glm::vec3& b = mesh_.positions[t.y];
            const glm::vec3& c = mesh_.positions[t.z];
            const float w = 1.0F - hit.u - hit.v;
            const glm::vec3 geometric = glm::normalize(glm::cross(b - a, c - a));
            glm::vec3 normal = geometric;
            if (!mesh_.normals.empty()) { // smooth mirrors: the interpolated normal focuses, facets do not
                const glm::vec3 smooth =
                    w * mesh_.normals[t.x] + hit.u * mesh_.normals[t.y] + hit.v * mesh_.normals[t.z];
                const float length = glm::length(smooth);
                if (length > 0.5F) {
                    normal = smooth / length;
                }
            }
            glm::vec3 reflected = direction - 2.0F * glm::dot(direction, normal) * normal;
            if (glm::dot(reflected, geometric) <= 0.0F) {
                reflected = direction - 2.0F * glm::dot(direction, geometric) * geometric;
            }
            origin = w * a + hit.u * b + hit.v * c;
            origin += geometric * (1e-4F * hit.distance_m + 2e-6F * glm::length(origin));
            direction = reflected;
            scene_.intersect(origin, std::span(&direction, 1), &hit);
        }
        hit = SceneHit{};
        return false;
    }

    HemisphereResult direct_with_mirrors(const Point& point, const glm::mat3& frame, std::span<float> bounced,
                                         Scratch& scratch) const {
        HemisphereResult result;
        const int order = settings_.order;
        const auto n = static_cast<std::size_t>(order * order);
        scratch.directions.resize(fine_.size());
        scratch.hits.resize(fine_.size());
        for (std::size_t k = 0; k < fine_.size(); ++k) {
            scratch.directions[k] = frame * fine_[k];
        }
        scene_.intersect(point.origin_m, scratch.directions, scratch.hits.data());
        std::array<float, sh::max_coefficients> y{};
        const float weight = 1.0F / static_cast<float>(fine_.size());
        std::size_t blocked = 0;
        for (std::size_t k = 0; k < fine_.size(); ++k) {
            SceneHit& hit = scratch.hits[k];
            if (hit.triangle == SceneHit::none) {
                sh::evaluate_basis(order, fine_[k], y);
                for (std::size_t i = 0; i < n; ++i) {
                    result.transfer.values[i] += weight * y[i];
                }
                continue;
            }
            glm::vec3 direction = scratch.directions[k];
            const bool found = follow(point.origin_m, direction, hit);
            if (found && hit.triangle == SceneHit::none) {
                sh::evaluate_basis(order, direction, y);
                for (std::size_t i = 0; i < n; ++i) {
                    bounced[i] += weight * y[i];
                }
            } else {
                ++blocked;
            }
        }
        result.visibility = 1.0 - static_cast<double>(blocked) * static_cast<double>(weight);
        const double p = result.visibility;
        result.variance = 2.0 * p * (1.0 - p) * static_cast<double>(n) / (4.0 * pi) *
                          std::pow(static_cast<double>(fine_.size()), -1.5);
        result.rays = fine_.size();
        return result;
    }

    const Mesh& mesh_;
    const BakeSettings& settings_;
    const Scene& scene_;
    Hemisphere hemisphere_;
    bool mirrors_;
    std::vector<glm::vec3> gather_;
    std::vector<glm::vec3> fine_; // with mirrors only
};

Result<BakePart> trace_part(const std::vector<Point>& points, const Tracer& tracer, const BakeSettings& settings,
                            std::size_t first, std::size_t count, double progress_to) {
    BakePart part;
    part.first = first;
    part.count = count;
    const auto n = static_cast<std::size_t>(settings.order * settings.order);
    part.direct.resize(count * n);
    part.visibility.resize(count);
    part.variance.resize(count);
    const bool bounces = settings.transport == Transport::interreflected;
    part.hit_counts.resize(bounces ? count : 0);

    struct Chunk {
        std::vector<GatherHit> hits;
        std::uint64_t shadow_rays = 0;
        std::uint64_t gather_rays = 0;
        std::size_t inside = 0;
        double cpu_s = 0.0;
        double tracing_s = 0.0;
    };
    // What reading the clock twice adds to what lies between.
    double clock_s = 0.0;
    if (settings.measure_tracer) {
        constexpr int readings = 2000;
        for (int i = 0; i < readings; ++i) {
            const double start = thread_cpu_seconds();
            clock_s += (thread_cpu_seconds() - start) / readings;
        }
    }
    std::vector<Chunk> chunks((count + grain - 1) / grain);
    std::atomic<std::size_t> hit_bytes{0};
    std::atomic<bool> dropped{false};
    Ticker ticker(settings.progress, "rays", 0.0, progress_to, count);
    parallel_for(
        count, grain,
        [&](std::size_t begin, std::size_t end) {
            if (ticker.cancelled()) {
                return;
            }
            const double start = thread_cpu_seconds();
            Chunk& chunk = chunks[begin / grain];
            Tracer::Scratch scratch;
            for (std::size_t k = begin; k < end && !ticker.cancelled(); ++k) {
                const std::size_t i = first + k;
                const Point& point = points[i];
                const std::span<float> out(part.direct.data() + k * n, n);
                if (point.normal == glm::vec3(0.0F)) {
                    continue;
                }
                if (settings.transport == Transport::unshadowed) {
                    unshadowed(settings.order, point.normal, out);
                    part.visibility[k] = 1.0F;
                    continue;
                }
                const HemisphereResult result = tracer.direct(point, i, out, scratch);
                part.visibility[k] = static_cast<float>(result.visibility);
                part.variance[k] = static_cast<float>(result.variance);
                chunk.shadow_rays += result.rays;
                chunk.tracing_s += result.tracing_s - clock_s * static_cast<double>(result.batches);
                if (bounces && result.visibility < 1.0) {
                    std::size_t backs = 0;
                    part.hit_counts[k] = tracer.gather(point, i, chunk.hits, backs, scratch);
                    chunk.gather_rays += settings.gather_rays;
                    chunk.inside += 2 * backs > settings.gather_rays ? 1 : 0;
                } else if (result.visibility < 0.5) {
                    chunk.inside += tracer.inside(point, i, scratch) ? 1 : 0;
                }
                ticker.done(1);
            }
            if (bounces) {
                const std::size_t bytes =
                    hit_bytes.fetch_add(chunk.hits.size() * sizeof(GatherHit)) + chunk.hits.size() * sizeof(GatherHit);
                if (bytes > settings.memory_bytes / 2) { // the joined copy wants as much again
                    dropped.store(true);
                }
                if (dropped.load()) {
                    std::vector<GatherHit>().swap(chunk.hits);
                }
            }
            chunk.cpu_s = thread_cpu_seconds() - start;
        },
        settings.threads);
    if (ticker.cancelled()) {
        return Error{"cancelled", "bake", ""};
    }
    std::size_t hits = 0;
    for (const Chunk& chunk : chunks) {
        hits += chunk.hits.size();
        part.shadow_rays += chunk.shadow_rays;
        part.gather_rays += chunk.gather_rays;
        part.inside_points += chunk.inside;
        part.cpu_s += chunk.cpu_s;
        part.tracing_cpu_s += chunk.tracing_s;
    }
    if (!dropped.load()) {
        part.hits.reserve(hits);
        for (Chunk& chunk : chunks) {
            part.hits.insert(part.hits.end(), chunk.hits.begin(), chunk.hits.end());
            std::vector<GatherHit>().swap(chunk.hits);
        }
    }
    return part;
}

// Gives the hits of any points: kept ones, or traced again.
class HitSource {
public:
    HitSource(const BakePart& part, const std::vector<Point>& points, const Tracer* tracer)
        : part_(part), points_(points), tracer_(tracer), offsets_(part.count + 1, 0) {
        std::partial_sum(part.hit_counts.begin(), part.hit_counts.end(), offsets_.begin() + 1,
                         [](std::uint64_t sum, std::uint64_t count) { return sum + count; });
    }
    [[nodiscard]] bool kept() const { return part_.hits.size() == offsets_.back(); }

    struct Scratch {
        Tracer::Scratch tracer;
        std::vector<GatherHit> hits;
    };
    [[nodiscard]] std::span<const GatherHit> of(std::size_t i, Scratch& scratch) const {
        if (kept()) {
            return std::span(part_.hits).subspan(offsets_[i], part_.hit_counts[i]);
        }
        scratch.hits.clear();
        if (part_.hit_counts[i] > 0) {
            std::size_t backs = 0;
            tracer_->gather(points_[i], i, scratch.hits, backs, scratch.tracer);
        }
        return scratch.hits;
    }

private:
    const BakePart& part_;
    const std::vector<Point>& points_;
    const Tracer* tracer_;
    std::vector<std::uint64_t> offsets_;
};

struct Corner {
    unsigned vertex;
    float weight;
};
std::array<Corner, 3> corners(const Mesh& mesh, const GatherHit& hit) {
    const glm::uvec3& t = mesh.triangles[hit.triangle];
    const float u = static_cast<float>(hit.u) / 65535.0F;
    const float v = static_cast<float>(hit.v) / 65535.0F;
    return {{{t.x, 1.0F - u - v}, {t.y, u}, {t.z, v}}};
}

// One bounce: to[i] = (1 - visibility) mean over hits of albedo_q from_q, [point][channel][coefficient].
bool bounce(const Mesh& mesh, const BakeSettings& settings, const HitSource& source, std::span<const float> visibility,
            int channels, std::span<const float> from, std::span<float> to, Ticker& ticker) {
    const auto n = static_cast<std::size_t>(settings.order * settings.order);
    const std::size_t width = n * static_cast<std::size_t>(channels);
    parallel_for(
        visibility.size(), grain,
        [&](std::size_t begin, std::size_t end) {
            if (ticker.cancelled()) {
                return;
            }
            HitSource::Scratch scratch;
            for (std::size_t i = begin; i < end; ++i) {
                const std::span<float> sum = to.subspan(i * width, width);
                std::fill(sum.begin(), sum.end(), 0.0F);
                const std::span<const GatherHit> hits = source.of(i, scratch);
                for (const GatherHit& hit : hits) {
                    if (hit.triangle == SceneHit::none) {
                        continue;
                    }
                    const std::array<Corner, 3> corner = corners(mesh, hit);
                    glm::vec3 albedo(settings.default_albedo);
                    if (!mesh.albedo.empty()) {
                        albedo = corner[0].weight * mesh.albedo[corner[0].vertex] +
                                 corner[1].weight * mesh.albedo[corner[1].vertex] +
                                 corner[2].weight * mesh.albedo[corner[2].vertex];
                    }
                    if (channels == 1) {
                        albedo = glm::vec3(glm::dot(albedo, glm::vec3(0.2126F, 0.7152F, 0.0722F)));
                    }
                    for (const Corner& c : corner) {
                        const float* m = from.data() + c.vertex * width;
                        for (int channel = 0; channel < channels; ++channel) {
                            const float w = c.weight * albedo[channel];
                            const std::size_t at = static_cast<std::size_t>(channel) * n;
                            for (std::size_t k = 0; k < n; ++k) {
                                sum[at + k] += w * m[at + k];
                            }
                        }
                    }
                }
                if (!hits.empty()) {
                    const float scale = (1.0F - visibility[i]) / static_cast<float>(hits.size());
                    for (float& value : sum) {
                        value *= scale;
                    }
                }
            }
            ticker.done(end - begin);
        },
        settings.threads);
    return !ticker.cancelled();
}

// White furnace: albedo 1, light 1 from everywhere. Every point that light can reach must come to 1.
void furnace(const Mesh& mesh, const BakeSettings& settings, const HitSource& source, std::span<const float> visibility,
             const std::vector<Point>& points, BakeReport& report) {
    std::vector<float> level(visibility.begin(), visibility.end());
    std::vector<float> next(level.size());
    for (int iteration = 0; iteration < 400; ++iteration) {
        parallel_for(
            level.size(), 4 * grain,
            [&](std::size_t begin, std::size_t end) {
                HitSource::Scratch scratch;
                for (std::size_t i = begin; i < end; ++i) {
                    float sum = 0.0F;
                    const std::span<const GatherHit> hits = source.of(i, scratch);
                    for (const GatherHit& hit : hits) {
                        if (hit.triangle != SceneHit::none) {
                            for (const Corner& c : corners(mesh, hit)) {
                                sum += c.weight * level[c.vertex];
                            }
                        }
                    }
                    next[i] = visibility[i];
                    if (!hits.empty()) {
                        next[i] += (1.0F - visibility[i]) * sum / static_cast<float>(hits.size());
                    }
                }
            },
            settings.threads);
        float change = 0.0F;
        for (std::size_t i = 0; i < level.size(); ++i) {
            change = std::max(change, std::abs(next[i] - level[i]));
        }
        level.swap(next);
        if (change < 1e-5F) {
            break;
        }
    }
    double sum = 0.0;
    std::size_t lit = 0;
    report.furnace_worst = 1.0;
    for (std::size_t i = 0; i < level.size(); ++i) {
        if (points[i].normal == glm::vec3(0.0F) || !(visibility[i] > 0.0F)) {
            continue;
        }
        const double value = static_cast<double>(level[i]);
        sum += value;
        ++lit;
        if (std::abs(value - 1.0) > std::abs(report.furnace_worst - 1.0)) {
            report.furnace_worst = value;
        }
    }
    report.furnace_mean = lit > 0 ? sum / static_cast<double>(lit) : 0.0;
}

// Everything after the rays. `points` are the mesh's vertices.
Result<Bake> join(const Mesh& mesh, const BakeSettings& settings, const MeshReport& mesh_report,
                  const std::vector<Point>& points, const BakePart& part, const Tracer* tracer,
                  double unoccluded_norm) {
    Bake result;
    BakeReport& report = result.report;
    report.mesh = mesh_report;
    report.points = part.count;
    report.shadow_rays = part.shadow_rays;
    report.gather_rays = part.gather_rays;
    report.inside_points = part.inside_points;
    report.rays_cpu_s = part.cpu_s;
    report.tracing_cpu_s = part.tracing_cpu_s;

    TransferField& field = result.field;
    field.kind = TransferKind::mesh;
    field.order = settings.order;
    const bool bounces = settings.transport == Transport::interreflected;
    field.channels = bounces && settings.colour ? 3 : 1;
    field.count = part.count;
    field.mesh_hash = mesh_hash(mesh);
    const auto n = static_cast<std::size_t>(settings.order * settings.order);
    const std::size_t width = field.width();
    field.values.resize(part.count * width);
    for (std::size_t i = 0; i < part.count; ++i) {
        for (std::size_t k = 0; k < width; ++k) {
            field.values[i * width + k] = part.direct[i * n + k % n];
        }
    }
    if (bounces) {
        const double start = process_cpu_seconds();
        const HitSource source(part, points, tracer);
        report.hits_kept = source.kept();
        const auto mean_dc = [&](std::span<const float> values) {
            double sum = 0.0;
            for (std::size_t i = 0; i < part.count; ++i) {
                for (std::size_t c = 0; c < width; c += n) {
                    sum += static_cast<double>(values[i * width + c]);
                }
            }
            return sum;
        };
        const double direct = mean_dc(field.values);
        std::vector<float> from = field.values;
        std::vector<float> to(from.size());
        for (int b = 1; b <= settings.max_bounces && direct > 0.0; ++b) {
            Ticker ticker(settings.progress, "bounces", 0.9, 1.0, part.count);
            if (!bounce(mesh, settings, source, part.visibility, field.channels, from, to, ticker)) {
                return Error{"cancelled", "bake", ""};
            }
            for (std::size_t i = 0; i < to.size(); ++i) {
                field.values[i] += to[i];
            }
            report.bounce_energy.push_back(mean_dc(to) / direct);
            from.swap(to);
            if (report.bounce_energy.back() < settings.stop_energy) {
                break;
            }
        }
        if (report.hits_kept) {
            furnace(mesh, settings, source, part.visibility, points, report);
        }
        report.bounces_cpu_s = process_cpu_seconds() - start;
    }
    double variance = 0.0;
    std::size_t baked = 0;
    for (std::size_t i = 0; i < part.count; ++i) {
        if (points[i].normal == glm::vec3(0.0F)) {
            continue;
        }
        ++baked;
        variance += static_cast<double>(part.variance[i]);
        const auto m = field.point(i);
        report.dark_points += std::all_of(m.begin(), m.end(), [](float x) { return x == 0.0F; }) ? 1 : 0;
    }
    if (baked == 0) {
        return Error{"no vertex has a surface to bake (" + std::to_string(mesh_report.isolated_vertices) +
                         " isolated, the others only on mirrors)",
                     "mesh", "one vertex of a triangle with area that is not a mirror"};
    }
    if (10 * part.inside_points >= 9 * baked) {
        return Error{std::to_string(part.inside_points) + " of " + std::to_string(baked) +
                         " points lie inside geometry: they see the backs of triangles",
                     "mesh", "triangles counter-clockwise seen from outside, normals outwards"};
    }
    report.estimated_rms = std::sqrt(variance / static_cast<double>(baked)) / unoccluded_norm;
    return result;
}

double unoccluded_norm(int order) {
    std::array<float, sh::max_coefficients> m{};
    unshadowed(order, glm::vec3(0.0F, 0.0F, 1.0F), m);
    double sum = 0.0;
    for (const float x : m) {
        sum += static_cast<double>(x) * static_cast<double>(x);
    }
    return std::sqrt(sum);
}

} // namespace

void unshadowed(int order, const glm::vec3& normal, std::span<float> out) noexcept {
    std::array<double, sh::max_coefficients> y{};
    sh::evaluate_basis(order, glm::dvec3(normal), y);
    for (int l = 0; l < order; ++l) {
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            const auto at = static_cast<std::size_t>(i);
            out[at] = static_cast<float>(y[at] * sh::cosine_factor(l) / pi);
        }
    }
}

ShardRange shard_range(std::size_t count, std::size_t shard, std::size_t shards) noexcept {
    assert(shard >= 1 && shard <= shards);
    const std::size_t base = count / shards;
    const std::size_t rest = count % shards;
    const std::size_t first = (shard - 1) * base + std::min(shard - 1, rest);
    return {first, first + base + (shard <= rest ? 1 : 0)};
}

Result<BakePart> bake_part(const Mesh& mesh, const BakeSettings& settings, std::size_t first, std::size_t count) {
    if (const Status status = check(settings); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    assert(first + count <= mesh.positions.size());
    const Result<Scene> scene = Scene::build(mesh, settings.threads);
    if (!scene) {
        return scene.error();
    }
    const std::vector<Point> points = vertex_points(mesh);
    const Tracer tracer(mesh, settings, *scene);
    Result<BakePart> part = trace_part(points, tracer, settings, first, count, 1.0);
    if (part) {
        part->mesh_hash = mesh_hash(mesh);
        part->settings_hash = settings_hash(settings);
    }
    return part;
}

Result<Bake> finish(const Mesh& mesh, const BakeSettings& settings, std::vector<BakePart> parts) {
    if (const Status status = check(settings); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    std::sort(parts.begin(), parts.end(), [](const BakePart& a, const BakePart& b) { return a.first < b.first; });
    const std::uint64_t hash = mesh_hash(mesh);
    const std::uint64_t wanted = settings_hash(settings);
    BakePart all;
    for (BakePart& part : parts) {
        const std::string where =
            "part of vertices " + std::to_string(part.first) + " .. " + std::to_string(part.first + part.count);
        if (part.mesh_hash != hash) {
            return Error{"was baked for another mesh", where, "mesh hash " + std::to_string(hash)};
        }
        if (part.settings_hash != wanted) {
            return Error{"was baked with other settings", where, "the same settings for all parts"};
        }
        if (part.first != all.count) {
            return Error{"vertices " + std::to_string(all.count) + " .. " + std::to_string(part.first) +
                             (part.first > all.count ? " are missing" : " are there twice"),
                         where, "parts that cover every vertex once"};
        }
        const auto append = [](auto& to, auto& from) {
            if (to.empty()) {
                to = std::move(from);
            } else {
                to.insert(to.end(), from.begin(), from.end());
                from = {};
            }
        };
        all.count += part.count;
        all.shadow_rays += part.shadow_rays;
        all.gather_rays += part.gather_rays;
        all.inside_points += part.inside_points;
        all.cpu_s += part.cpu_s;
        all.tracing_cpu_s += part.tracing_cpu_s;
        append(all.direct, part.direct);
        append(all.visibility, part.visibility);
        append(all.variance, part.variance);
        append(all.hit_counts, part.hit_counts);
        append(all.hits, part.hits);
    }
    if (all.count != mesh.positions.size()) {
        return Error{"parts cover " + std::to_string(all.count) + " vertices", "merge",
                     std::to_string(mesh.positions.size())};
    }
    const std::vector<Point> points = vertex_points(mesh);
    const std::uint64_t hits = std::accumulate(all.hit_counts.begin(), all.hit_counts.end(), std::uint64_t{0});
    if (hits == all.hits.size()) {
        return join(mesh, settings, *valid, points, all, nullptr, unoccluded_norm(settings.order));
    }
    const Result<Scene> scene = Scene::build(mesh, settings.threads); // some part dropped its hits: trace again
    if (!scene) {
        return scene.error();
    }
    all.hits.clear();
    const Tracer tracer(mesh, settings, *scene);
    return join(mesh, settings, *valid, points, all, &tracer, unoccluded_norm(settings.order));
}

Result<Bake> bake(const Mesh& mesh, const BakeSettings& settings) {
    const double start = wall_seconds();
    if (const Status status = check(settings); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    const Result<Scene> scene = Scene::build(mesh, settings.threads);
    if (!scene) {
        return scene.error();
    }
    const std::vector<Point> points = vertex_points(mesh);
    const Tracer tracer(mesh, settings, *scene);
    const bool bounces = settings.transport == Transport::interreflected;
    const Result<BakePart> part = trace_part(points, tracer, settings, 0, points.size(), bounces ? 0.9 : 1.0);
    if (!part) {
        return part.error();
    }
    Result<Bake> result = join(mesh, settings, *valid, points, *part, &tracer, tracer.unoccluded_norm());
    if (result) {
        result->report.wall_s = wall_seconds() - start;
    }
    return result;
}

Result<Bake> bake_points(const Mesh& mesh, const BakePoints& where, const BakeSettings& settings) {
    const double start = wall_seconds();
    if (where.positions_m.size() != where.normals.size() || where.positions_m.empty()) {
        return Error{std::to_string(where.positions_m.size()) + " positions, " + std::to_string(where.normals.size()) +
                         " normals",
                     "bake points", "as many normals as positions, one or more"};
    }
    const bool bounces = settings.transport == Transport::interreflected;
    Bake vertices;
    if (bounces) { // light that the mesh itself sends on
        Result<Bake> solved = bake(mesh, settings);
        if (!solved) {
            return solved;
        }
        vertices = std::move(*solved);
    } else if (const Status status = check(settings); !status) {
        return status.error();
    }
    const Result<MeshReport> valid = validate(mesh);
    if (!valid) {
        return valid.error();
    }
    const Result<Scene> scene = Scene::build(mesh, settings.threads);
    if (!scene) {
        return scene.error();
    }
    const Bounds box = bounds(mesh);
    const float lift = 1e-5F * glm::length(box.high - box.low);
    std::vector<Point> points(where.normals.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const float length = glm::length(where.normals[i]);
        if (length > 0.5F && std::isfinite(length) && std::isfinite(glm::dot(where.positions_m[i], glm::vec3(1.0F)))) {
            const glm::vec3 normal = where.normals[i] / length;
            points[i] = {where.positions_m[i] + lift * normal, normal};
        }
    }
    const Tracer tracer(mesh, settings, *scene);
    const Result<BakePart> part = trace_part(points, tracer, settings, 0, points.size(), bounces ? 0.9 : 1.0);
    if (!part) {
        return part.error();
    }
    BakeSettings direct_only = settings;
    direct_only.max_bounces = 0;
    BakePart direct = *part;
    direct.hits.clear();
    direct.hit_counts.clear();
    if (bounces) {
        direct_only.transport = Transport::shadowed;
    }
    Result<Bake> result = join(mesh, direct_only, *valid, points, direct, &tracer, tracer.unoccluded_norm());
    if (!result) {
        return result;
    }
    result->field.kind = TransferKind::texels;
    if (bounces) {
        const int channels = vertices.field.channels;
        const std::size_t width = vertices.field.width();
        std::vector<float> gathered(points.size() * width);
        Ticker ticker(settings.progress, "bounces", 0.9, 1.0, points.size());
        const HitSource source(*part, points, &tracer);
        if (!bounce(mesh, settings, source, part->visibility, channels, vertices.field.values, gathered, ticker)) {
            return Error{"cancelled", "bake", ""};
        }
        const std::vector<float> direct_values = std::move(result->field.values);
        const auto n = static_cast<std::size_t>(settings.order * settings.order);
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < width; ++k) {
                gathered[i * width + k] += direct_values[i * n + k % n];
            }
        }
        result->field.channels = channels;
        result->field.values = std::move(gathered);
        result->report.bounce_energy = vertices.report.bounce_energy;
        result->report.furnace_mean = vertices.report.furnace_mean;
        result->report.furnace_worst = vertices.report.furnace_worst;
    }
    result->report.wall_s = wall_seconds() - start;
    return result;
}

std::string BakeReport::text() const {
    std::array<char, 1024> buffer{};
    std::array<char, 64> furnace{"not measured"};
    if (is_number(furnace_mean)) {
        std::snprintf(furnace.data(), furnace.size(), "mean %.4f, worst %.4f", furnace_mean, furnace_worst);
    } else if (!hits_kept) {
        std::snprintf(furnace.data(), furnace.size(), "not measured: hits were not kept");
    }
    const double rate = rays_cpu_s > 0.0 ? static_cast<double>(shadow_rays + gather_rays) / rays_cpu_s : 0.0;
    std::snprintf(buffer.data(), buffer.size(),
                  "vertices               %zu\n"
                  "triangles              %zu\n"
                  "degenerate triangles   %zu\n"
                  "isolated vertices      %zu\n"
                  "mended normals         %zu\n"
                  "points                 %zu\n"
                  "dark points            %zu\n"
                  "points inside geometry %zu\n"
                  "shadow rays            %llu\n"
                  "gather rays            %llu\n"
                  "rays per CPU second    %.3g\n"
                  "estimated RMS error    %.3g\n"
                  "white furnace          %s\n"
                  "CPU seconds            %.2f rays, %.2f bounces\n"
                  "wall seconds           %.2f\n"
                  "bounces                %zu",
                  mesh.vertices, mesh.triangles, mesh.degenerate_triangles, mesh.isolated_vertices, mesh.bad_normals,
                  points, dark_points, inside_points, static_cast<unsigned long long>(shadow_rays),
                  static_cast<unsigned long long>(gather_rays), rate, estimated_rms, furnace.data(), rays_cpu_s,
                  bounces_cpu_s, wall_s, bounce_energy.size());
    std::string out(buffer.data());
    for (std::size_t b = 0; b < bounce_energy.size(); ++b) {
        std::snprintf(buffer.data(), buffer.size(), "%s%.3g", b == 0 ? ", energy " : ", ", bounce_energy[b]);
        out += buffer.data();
    }
    return out + "\n";
}

} // namespace alpenglow::prt
