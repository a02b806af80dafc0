#include "hemisphere.hpp"

#include "directions.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <cmath>

namespace alpenglow::prt {
namespace {

// out = frame * in.
void turn(const glm::mat3& frame, const DirectionList& in, DirectionList& out) {
    const std::size_t count = in.size();
    out.resize(count);
    const float* x = in.x.data();
    const float* y = in.y.data();
    const float* z = in.z.data();
    for (glm::length_t c = 0; c < 3; ++c) {
        float* to = (c == 0 ? out.x : c == 1 ? out.y : out.z).data();
        const float a = frame[0][c];
        const float b = frame[1][c];
        const float d = frame[2][c];
        for (std::size_t i = 0; i < count; ++i) {
            to[i] = a * x[i] + b * y[i] + d * z[i];
        }
    }
}

} // namespace

Hemisphere::Hemisphere(const BakeSettings& settings)
    : sampling_(settings.sampling), order_(settings.order),
      coefficients_(static_cast<std::size_t>(settings.order * settings.order)), padded_((coefficients_ + 7) / 8 * 8),
      rays_(std::max<std::size_t>(settings.rays, 1)), max_error_(settings.max_error), seed_(settings.seed),
      measure_(settings.measure_tracer) {
    std::array<float, row_floats> zonal{};
    unshadowed(order_, glm::vec3(0.0F, 0.0F, 1.0F), zonal);
    double norm2 = 0.0;
    for (std::size_t i = 0; i < coefficients_; ++i) {
        unoccluded_.values[i] = zonal[i];
        norm2 += static_cast<double>(zonal[i]) * static_cast<double>(zonal[i]);
    }
    unoccluded_norm_ = std::sqrt(norm2);

    std::array<double, sh::max_coefficients> y{};
    if (sampling_ == Sampling::fibonacci) {
        for (const glm::dvec3& d : fibonacci_hemisphere(rays_)) {
            sh::evaluate_basis(order_, d, y);
            directions_.push_back(glm::vec3(d));
            CoefficientRow& row = rows_.emplace_back();
            for (std::size_t i = 0; i < coefficients_; ++i) {
                row.values[i] = static_cast<float>(y[i]);
            }
        }
    }
    if (sampling_ != Sampling::adaptive) {
        return;
    }
    // Eight times as many cells on the finest grid as on the one whose nodes are all shot, which finds what there is.
    std::size_t rings = 4;
    for (; rings <= 8 || (2 * rings * rings <= rays_ && rings <= 256); rings *= 2) {
        Level& level = levels_.emplace_back();
        level.rings = rings;
        level.sectors = 2 * rings;
        if (rings <= 8 || 2 * rings * rings <= rays_ / 8) {
            detect_ = levels_.size() - 1;
        }
        const std::size_t cells = level.rings * level.sectors;
        for (std::size_t k = 0; k <= 8 * rings; ++k) {
            // The last ring stands a little above the horizon, where a ray cannot graze a plane that it starts on.
            const double u = std::min(static_cast<double>(k) / static_cast<double>(8 * rings), 1.0 - 1e-5);
            level.radial.emplace_back(std::sqrt(u), std::sqrt(1.0 - u));
        }
        for (std::size_t k = 0; k <= 8 * level.sectors; ++k) {
            const double phi = two_pi * static_cast<double>(k) / static_cast<double>(8 * level.sectors);
            level.azimuth.emplace_back(std::cos(phi), std::sin(phi));
        }
        const bool first = levels_.size() == 1;
        for (std::size_t at = 0; at <= rings * level.sectors + level.sectors - 1; ++at) {
            const std::size_t i = at / level.sectors;
            const std::size_t j = at % level.sectors;
            const bool pole_again = i == 0 && !(first && j == 0);
            if (!pole_again && (first || i % 2 != 0 || j % 2 != 0)) {
                level.fresh.push_back(static_cast<std::uint32_t>(at));
                level.fresh_directions.push_back(level.direction(8 * i, 8 * j));
            }
        }
        constexpr std::size_t points = 6; // a side of a cell
        for (std::size_t cell = 0; cell < cells; ++cell) {
            std::array<double, row_floats> mean{};
            std::array<double, row_floats> slope_u{};
            std::array<double, row_floats> slope_v{};
            for (std::size_t k = 0; k < points * points; ++k) {
                const double su = (static_cast<double>(k % points) + 0.5) / points;
                const double sv = (static_cast<double>(k / points) + 0.5) / points;
                const double u = (static_cast<double>(cell / level.sectors) + su) / static_cast<double>(rings);
                const double phi =
                    two_pi * (static_cast<double>(cell % level.sectors) + sv) / static_cast<double>(level.sectors);
                const double r = std::sqrt(u);
                sh::evaluate_basis(order_, glm::dvec3(r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0 - u)), y);
                for (std::size_t i = 0; i < coefficients_; ++i) {
                    const double value = y[i] / static_cast<double>(points * points * cells);
                    mean[i] += value;
                    slope_u[i] += 12.0 * (su - 0.5) * value;
                    slope_v[i] += 12.0 * (sv - 0.5) * value;
                }
            }
            CoefficientRow& m = level.integral.emplace_back();
            CoefficientRow& du = level.slope_u.emplace_back();
            CoefficientRow& dv = level.slope_v.emplace_back();
            for (std::size_t i = 0; i < coefficients_; ++i) {
                m.values[i] = static_cast<float>(mean[i]);
                du.values[i] = static_cast<float>(slope_u[i]);
                dv.values[i] = static_cast<float>(slope_v[i]);
            }
            if (cell % level.sectors == 0) {
                level.before.emplace_back();
            }
            level.before.push_back(level.before.back());
            add(level.before.back(), m);
        }
    }
}

HemisphereResult Hemisphere::trace(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                   std::uint64_t stream, Scratch& scratch) const {
    return sampling_ == Sampling::adaptive ? trace_contours(scene, origin, frame, scratch)
                                           : trace_list(scene, origin, frame, stream, scratch);
}

HemisphereResult Hemisphere::trace_list(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                        std::uint64_t stream, Scratch& scratch) const {
    const bool fixed = sampling_ == Sampling::fibonacci;
    DirectionList& drawn = scratch.local;
    drawn.resize(0);
    if (!fixed) {
        const auto strata = static_cast<std::size_t>(std::floor(std::sqrt(static_cast<double>(rays_)) + 1e-9));
        const std::size_t count = sampling_ == Sampling::stratified ? strata * strata : rays_;
        const std::uint64_t seed = mix(seed_ ^ mix(stream));
        for (std::size_t i = 0; i < count; ++i) {
            double x = uniform(seed, 2 * i);
            double v = uniform(seed, 2 * i + 1);
            if (sampling_ == Sampling::stratified) {
                x = (static_cast<double>(i % strata) + x) / static_cast<double>(strata);
                v = (static_cast<double>(i / strata) + v) / static_cast<double>(strata);
            }
            drawn.push_back(glm::vec3(cosine_direction(x, v)));
        }
    }
    const DirectionList& local = fixed ? directions_ : drawn;
    const std::size_t count = local.size();
    scratch.hit.resize(count);
    turn(frame, local, scratch.directions);
    HemisphereResult result;
    ask(scene, origin, scratch, count, result);

    std::size_t blocked = 0;
    for (std::size_t i = 0; i < count; ++i) {
        blocked += scratch.hit[i];
    }
    // The smaller of the two sets is summed: the visible directions as they are, or the blocked ones, which come off
    // the open hemisphere's closed form. A free point is exact, a closed-in one exactly dark.
    const bool sum_visible = 2 * blocked > count;
    CoefficientRow sum;
    std::array<float, sh::max_coefficients> y{};
    for (std::size_t i = 0; i < count; ++i) {
        if ((scratch.hit[i] == 0) != sum_visible) {
            continue;
        }
        if (fixed) {
            add(sum, rows_[i]);
        } else {
            sh::evaluate_basis(order_, glm::vec3(local.x[i], local.y[i], local.z[i]), y);
            for (std::size_t k = 0; k < coefficients_; ++k) {
                sum.values[k] += y[k];
            }
        }
    }
    const float weight = 1.0F / static_cast<float>(count);
    for (std::size_t i = 0; i < coefficients_; ++i) {
        result.transfer.values[i] =
            sum_visible ? weight * sum.values[i] : unoccluded_.values[i] - weight * sum.values[i];
    }
    result.visibility = 1.0 - static_cast<double>(blocked) / static_cast<double>(count);
    // Independent samples: |y|^2 averages to coefficients / 4 pi. Stratified and spiral sets do better, by about the
    // fourth root of their number in the error; the constants were fitted on the figure of the benchmark.
    const double p = result.visibility;
    double variance = p * (1.0 - p) * static_cast<double>(coefficients_) / (4.0 * pi) / static_cast<double>(count);
    if (sampling_ != Sampling::random) {
        variance *= 2.0 / std::sqrt(static_cast<double>(count));
    }
    result.variance = variance;
    return result;
}

void Hemisphere::ask(const Scene& scene, const glm::vec3& origin, Scratch& scratch, std::size_t count,
                     HemisphereResult& result) const {
    const double start = measure_ ? thread_cpu_seconds() : 0.0;
    scene.occluded(origin, scratch.directions.x.data(), scratch.directions.y.data(), scratch.directions.z.data(), 1,
                   count, scratch.hit.data());
    if (measure_) {
        result.tracing_s += thread_cpu_seconds() - start;
    }
    result.rays += count;
    ++result.batches;
}

void Hemisphere::shoot(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame, const DirectionList& local,
                       Scratch& scratch, HemisphereResult& result) const {
    const std::size_t count = local.size();
    turn(frame, local, scratch.directions);
    scratch.hit.resize(count);
    ask(scene, origin, scratch, count, result);
}

// Contours of the blocked part, marching squares: an edge whose ends differ is halved three times to find where, a cell
// whose corners differ is cut along the lines between its crossings.
Hemisphere::Coverage Hemisphere::integrate(const Level& level, const Scene& scene, const glm::vec3& origin,
                                           const glm::mat3& frame, Scratch& scratch, HemisphereResult& result) const {
    const std::size_t rings = level.rings;
    const std::size_t sectors = level.sectors;
    const std::vector<std::uint8_t>& node = scratch.node;
    Coverage coverage;
    const auto blocked_nodes = static_cast<std::size_t>(std::count(node.begin(), node.end(), std::uint8_t{1}));
    coverage.kind = 2 * blocked_nodes > node.size() ? 0 : 1;
    if (blocked_nodes == 0 || blocked_nodes == node.size()) {
        return coverage; // all of one kind: nothing of the other
    }
    const auto next = [&](std::size_t j) { return j + 1 == sectors ? 0 : j + 1; };
    // Rings of one kind, as most are: 0 or 1, and 2 for mixed ones.
    std::array<std::uint8_t, 257> ring_kind{};
    for (std::size_t i = 0; i <= rings; ++i) {
        unsigned sum = 0;
        for (std::size_t j = 0; j < sectors; ++j) {
            sum += node[i * sectors + j];
        }
        ring_kind[i] = sum == 0 ? 0 : sum == sectors ? 1 : 2;
    }
    const auto uniform_ring = [&](std::size_t i) { return ring_kind[i] != 2 && ring_kind[i] == ring_kind[i + 1]; };
    scratch.crossings.clear();
    const std::size_t edges = (rings + 1) * sectors; // angular edges are numbered behind the radial ones
    for (std::size_t i = 0; i <= rings; ++i) {
        if (ring_kind[i] != 2 && (i == rings || uniform_ring(i))) {
            continue;
        }
        for (std::size_t j = 0; j < sectors; ++j) {
            const std::size_t at = i * sectors + j;
            if (i < rings && node[at] != node[at + sectors]) {
                scratch.crossings.push_back({static_cast<std::uint32_t>(at), 0, 8, node[at] != 0});
            }
            if (node[at] != node[i * sectors + next(j)]) {
                scratch.crossings.push_back({static_cast<std::uint32_t>(edges + at), 0, 8, node[at] != 0});
            }
        }
    }
    for (int halving = 0; halving < 3 && !scratch.crossings.empty(); ++halving) {
        scratch.local.resize(0);
        for (const Scratch::Crossing& c : scratch.crossings) {
            const auto middle = static_cast<std::size_t>((c.low + c.high) / 2);
            const std::size_t at = c.edge < edges ? c.edge : c.edge - edges;
            const std::size_t u = 8 * (at / sectors);
            const std::size_t v = 8 * (at % sectors);
            scratch.local.push_back(c.edge < edges ? level.direction(u + middle, v) : level.direction(u, v + middle));
        }
        shoot(scene, origin, frame, scratch.local, scratch, result);
        for (std::size_t k = 0; k < scratch.crossings.size(); ++k) {
            Scratch::Crossing& c = scratch.crossings[k];
            const auto middle = static_cast<std::uint8_t>((c.low + c.high) / 2);
            ((scratch.hit[k] != 0) == c.low_blocked ? c.low : c.high) = middle;
        }
    }
    scratch.radial_crossing.resize(edges);
    scratch.angular_crossing.resize(edges);
    for (const Scratch::Crossing& c : scratch.crossings) {
        const float at = static_cast<float>(c.low + c.high) / 16.0F;
        if (c.edge < edges) {
            scratch.radial_crossing[c.edge] = at;
        } else {
            scratch.angular_crossing[c.edge - edges] = at;
        }
    }

    // Diagonal corners can be joined through the middle or not: one ray there says.
    scratch.asked.clear();
    scratch.local.resize(0);
    for (std::size_t i = 0; i < rings; ++i) {
        if (uniform_ring(i)) {
            continue;
        }
        for (std::size_t j = 0; j < sectors; ++j) {
            const std::size_t a = i * sectors + j;
            const std::size_t d = i * sectors + next(j);
            if (node[a] == node[d + sectors] && node[d] == node[a + sectors] && node[a] != node[d]) {
                scratch.asked.push_back(static_cast<std::uint32_t>(a));
                scratch.local.push_back(level.direction(8 * i + 4, 8 * j + 4));
            }
        }
    }
    if (!scratch.asked.empty()) {
        shoot(scene, origin, frame, scratch.local, scratch, result);
    }
    std::size_t answer = 0;

    const double measure = 1.0 / static_cast<double>(rings * sectors);
    for (std::size_t i = 0; i < rings; ++i) {
        if (uniform_ring(i)) {
            if (ring_kind[i] == coverage.kind) {
                add(coverage.sum, level.before[i * (sectors + 1) + sectors]);
                coverage.part += measure * static_cast<double>(sectors);
            }
            continue;
        }
        for (std::size_t j = 0; j < sectors; ++j) {
            const std::size_t a = i * sectors + j;
            const std::size_t d = i * sectors + next(j);
            // Corners around the cell: (u, v) = (0, 0), (1, 0), (1, 1), (0, 1).
            const std::uint8_t corner[4] = {node[a], node[a + sectors], node[d + sectors], node[d]};
            const int blocked = corner[0] + corner[1] + corner[2] + corner[3];
            if (blocked == 0 || blocked == 4) {
                if (corner[0] != coverage.kind) {
                    continue;
                }
                // A run of covered cells at once.
                const std::size_t from = j;
                while (j + 1 < sectors && node[i * sectors + next(j + 1)] == coverage.kind &&
                       node[(i + 1) * sectors + next(j + 1)] == coverage.kind) {
                    ++j;
                }
                const CoefficientRow* before = level.before.data() + i * (sectors + 1);
                for (std::size_t k = 0; k < padded_; ++k) {
                    coverage.sum.values[k] += before[j + 1].values[k] - before[from].values[k];
                }
                coverage.part += measure * static_cast<double>(j + 1 - from);
                continue;
            }
            const CoefficientRow& whole = level.integral[a];
            // The polygon of the corners of one kind. Of a saddle's two kinds, the one that the middle joins.
            std::uint8_t kind = 1;
            if (blocked == 2 && corner[0] == corner[2]) {
                kind = scratch.hit[answer++];
            }
            const float cut[4] = {scratch.radial_crossing[a], scratch.angular_crossing[a + sectors],
                                  scratch.radial_crossing[d], scratch.angular_crossing[a]};
            std::array<glm::vec2, 8> polygon;
            std::size_t points = 0;
            constexpr glm::vec2 place[4] = {{0.0F, 0.0F}, {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}};
            for (std::size_t k = 0; k < 4; ++k) {
                if (corner[k] == kind) {
                    polygon[points++] = place[k];
                }
                if (corner[k] != corner[(k + 1) % 4]) {
                    // Sides 2 and 3 run against the direction in which their crossings are measured.
                    polygon[points++] = k == 0   ? glm::vec2(cut[0], 0.0F)
                                        : k == 1 ? glm::vec2(1.0F, cut[1])
                                        : k == 2 ? glm::vec2(cut[2], 1.0F)
                                                 : glm::vec2(0.0F, cut[3]);
                }
            }
            float area = 0.0F;
            glm::vec2 moment(0.0F); // about the cell's middle
            for (std::size_t k = 0; k < points; ++k) {
                const glm::vec2 p = polygon[k] - 0.5F;
                const glm::vec2 q = polygon[(k + 1) % points] - 0.5F;
                const float cross = p.x * q.y - p.y * q.x;
                area += 0.5F * cross;
                moment += (p + q) * (cross / 6.0F);
            }
            const CoefficientRow& du = level.slope_u[a];
            const CoefficientRow& dv = level.slope_v[a];
            if (kind != coverage.kind) { // the rest of the cell
                area = 1.0F - area;
                moment = -moment;
            }
            for (std::size_t k = 0; k < padded_; ++k) {
                coverage.sum.values[k] += area * whole.values[k] + moment.x * du.values[k] + moment.y * dv.values[k];
            }
            coverage.part += measure * static_cast<double>(area);
        }
    }
    return coverage;
}

HemisphereResult Hemisphere::trace_contours(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                            Scratch& scratch) const {
    HemisphereResult result;
    const double budget = max_error_ * max_error_ * unoccluded_norm_ * unoccluded_norm_;
    const auto transfer = [&](const Coverage& coverage, CoefficientRow& out) {
        for (std::size_t i = 0; i < coefficients_; ++i) {
            out.values[i] =
                coverage.kind == 0 ? coverage.sum.values[i] : unoccluded_.values[i] - coverage.sum.values[i];
        }
        result.visibility = std::clamp(coverage.kind == 0 ? coverage.part : 1.0 - coverage.part, 0.0, 1.0);
    };
    for (std::size_t depth = 0; depth < levels_.size(); ++depth) {
        const Level& level = levels_[depth];
        const std::size_t sectors = level.sectors;
        scratch.coarser.swap(scratch.node);
        scratch.node.assign((level.rings + 1) * sectors, 0);
        if (depth > 0) {
            // The coarser grid's nodes, and where not all others are shot below, those between take after them.
            const Level& last = levels_[depth - 1];
            const std::size_t fill = depth <= detect_ ? 1 : 2;
            for (std::size_t i = 0; i <= level.rings; i += 3 - fill) {
                const std::uint8_t* from = scratch.coarser.data() + i / 2 * last.sectors;
                std::uint8_t* to = scratch.node.data() + i * sectors;
                for (std::size_t j = 0; j < last.sectors; ++j) {
                    to[2 * j] = from[j];
                    to[2 * j + 1] = from[j];
                }
            }
        }
        if (depth <= detect_) {
            shoot(scene, origin, frame, level.fresh_directions, scratch, result);
            for (std::size_t k = 0; k < level.fresh.size(); ++k) {
                scratch.node[level.fresh[k]] = scratch.hit[k];
            }
        } else {
            const Level& last = levels_[depth - 1];
            const std::vector<std::uint8_t>& old = scratch.coarser;
            const auto mixed = [&](std::size_t ring, std::size_t sector) {
                if (ring >= last.rings) {
                    return false;
                }
                const std::size_t a = ring * last.sectors + sector % last.sectors;
                const std::size_t d = ring * last.sectors + (sector + 1) % last.sectors;
                return old[a] != old[d] || old[a] != old[a + last.sectors] || old[d] != old[d + last.sectors];
            };
            scratch.asked.clear();
            scratch.local.resize(0);
            for (std::size_t k = 0; k < level.fresh.size(); ++k) {
                const std::size_t i = level.fresh[k] / sectors;
                const std::size_t j = level.fresh[k] % sectors;
                if (mixed(i / 2, j / 2) || (i % 2 == 0 && mixed(i / 2 - 1, j / 2)) ||
                    (j % 2 == 0 && mixed(i / 2, j / 2 + last.sectors - 1))) {
                    scratch.asked.push_back(level.fresh[k]);
                    scratch.local.push_back(level.direction(8 * i, 8 * j));
                }
            }
            if (!scratch.asked.empty()) {
                shoot(scene, origin, frame, scratch.local, scratch, result);
                for (std::size_t k = 0; k < scratch.asked.size(); ++k) {
                    scratch.node[scratch.asked[k]] = scratch.hit[k];
                }
            }
        }
        for (std::size_t j = 1; j < sectors; ++j) {
            scratch.node[j] = scratch.node[0];
        }
        if (depth + 1 < detect_) {
            continue; // only finds; the two grids that are compared come after
        }
        const CoefficientRow before = result.transfer;
        transfer(integrate(level, scene, origin, frame, scratch, result), result.transfer);
        if (depth < detect_) {
            continue;
        }
        // Halving the grid leaves about 0.4 of what it changed.
        double change = 0.0;
        for (std::size_t i = 0; i < coefficients_; ++i) {
            const double d = static_cast<double>(result.transfer.values[i]) - static_cast<double>(before.values[i]);
            change += d * d;
        }
        // What both grids missed they do not tell: points whose contours a grid of so many cells cuts are off by about
        // this much more, in the benchmark's scenes.
        const double cells = static_cast<double>(level.rings * sectors);
        const double missed = 0.04 * result.visibility * (1.0 - result.visibility) *
                              static_cast<double>(coefficients_) / (4.0 * pi) * std::pow(cells, -1.5);
        result.variance = 0.16 * change + missed;
        if (result.variance <= budget) {
            break;
        }
    }
    return result;
}

} // namespace alpenglow::prt
