#include "hemisphere.hpp"

#include "directions.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

namespace alpenglow::prt {
namespace {

constexpr std::size_t finest = 64; // a row of the finest grid is one word

using Bitmap = std::array<std::uint64_t, finest>; // row by row, bit = column

void add(CoefficientRow& sum, const CoefficientRow& row) noexcept {
    for (std::size_t i = 0; i < row_floats; ++i) {
        sum.values[i] += row.values[i];
    }
}

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

// Cells that differ from one of their four neighbours.
Bitmap edges(const Bitmap& map, std::size_t size) {
    Bitmap marked{};
    const std::uint64_t all = size == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << size) - 1;
    for (std::size_t r = 0; r < size; ++r) {
        const std::uint64_t row = map[r];
        const std::uint64_t sideways = (row ^ (row >> 1U)) & (all >> 1U);
        marked[r] |= sideways | (sideways << 1U);
        if (r + 1 < size) {
            const std::uint64_t down = row ^ map[r + 1];
            marked[r] |= down;
            marked[r + 1] |= down;
        }
    }
    return marked;
}

// Every bit twice.
std::uint64_t spread(std::uint64_t x) {
    x &= 0xFFFFFFFFU;
    x = (x | (x << 16U)) & 0x0000FFFF0000FFFFULL;
    x = (x | (x << 8U)) & 0x00FF00FF00FF00FFULL;
    x = (x | (x << 4U)) & 0x0F0F0F0F0F0F0F0FULL;
    x = (x | (x << 2U)) & 0x3333333333333333ULL;
    x = (x | (x << 1U)) & 0x5555555555555555ULL;
    return x | (x << 1U);
}

} // namespace

Hemisphere::Hemisphere(const BakeSettings& settings)
    : sampling_(settings.sampling), order_(settings.order),
      coefficients_(static_cast<std::size_t>(settings.order * settings.order)),
      rays_(std::max<std::size_t>(settings.rays, 1)), max_error_(settings.max_error), seed_(settings.seed) {
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
    if (sampling_ == Sampling::adaptive) {
        // Two refinements: what is thinner than half a cell of the first grid can be missed.
        std::size_t size = 8;
        while (size < finest && size * size * 4 <= rays_) {
            size *= 2;
        }
        const std::size_t coarsest = std::min(size, std::max<std::size_t>(16, size / 2));
        // The finest cells by 4 x 4 points, the others as sums of theirs: all levels integrate to the same.
        std::vector<std::array<double, row_floats>> exact(size * size);
        constexpr std::size_t points = 4;
        for (std::size_t cell = 0; cell < size * size; ++cell) {
            for (std::size_t k = 0; k < points * points; ++k) {
                const double x = (static_cast<double>(cell % size) + (static_cast<double>(k % points) + 0.5) / points) /
                                 static_cast<double>(size);
                const double v = (static_cast<double>(cell / size) + (static_cast<double>(k / points) + 0.5) / points) /
                                 static_cast<double>(size);
                sh::evaluate_basis(order_, cosine_direction(x, v), y);
                for (std::size_t i = 0; i < coefficients_; ++i) {
                    exact[cell][i] += y[i] / static_cast<double>(points * points * size * size);
                }
            }
        }
        for (;; size /= 2) {
            Level level;
            level.size = size;
            for (std::size_t cell = 0; cell < size * size; ++cell) {
                level.directions.push_back(
                    glm::vec3(cosine_direction((static_cast<double>(cell % size) + 0.5) / static_cast<double>(size),
                                               (static_cast<double>(cell / size) + 0.5) / static_cast<double>(size))));
                CoefficientRow& row = level.integral.emplace_back();
                double sum = 0.0;
                for (std::size_t i = 0; i < coefficients_; ++i) {
                    row.values[i] = static_cast<float>(exact[cell][i]);
                    sum += exact[cell][i] * exact[cell][i];
                }
                level.norm2.push_back(static_cast<float>(sum));
            }
            levels_.insert(levels_.begin(), std::move(level));
            if (size == coarsest) {
                break;
            }
            std::vector<std::array<double, row_floats>> coarser(size * size / 4);
            for (std::size_t cell = 0; cell < size * size; ++cell) {
                std::array<double, row_floats>& parent = coarser[cell / size / 2 * (size / 2) + cell % size / 2];
                for (std::size_t i = 0; i < row_floats; ++i) {
                    parent[i] += exact[cell][i];
                }
            }
            exact = std::move(coarser);
        }
    }
}

HemisphereResult Hemisphere::trace(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                   std::uint64_t stream, Scratch& scratch) const {
    return sampling_ == Sampling::adaptive ? trace_grid(scene, origin, frame, scratch)
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
    const double start = thread_cpu_seconds();
    scene.occluded(origin, scratch.directions.x.data(), scratch.directions.y.data(), scratch.directions.z.data(), 1,
                   count, scratch.hit.data());
    const double tracing_s = thread_cpu_seconds() - start;

    std::size_t blocked = 0;
    for (std::size_t i = 0; i < count; ++i) {
        blocked += scratch.hit[i];
    }
    // The sum over the smaller set; the other follows from the closed form, so that a free point is exact and a
    // closed-in one is exactly dark.
    const bool sum_visible = 2 * blocked > count;
    HemisphereResult result;
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
    result.rays = count;
    result.tracing_s = tracing_s;
    return result;
}

HemisphereResult Hemisphere::trace_grid(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                        Scratch& scratch) const {
    HemisphereResult result;
    Bitmap blocked{};
    const auto shoot = [&](const DirectionList& local) {
        const std::size_t count = local.size();
        turn(frame, local, scratch.directions);
        scratch.hit.resize(count);
        const double start = thread_cpu_seconds();
        scene.occluded(origin, scratch.directions.x.data(), scratch.directions.y.data(), scratch.directions.z.data(), 1,
                       count, scratch.hit.data());
        result.tracing_s += thread_cpu_seconds() - start;
        result.rays += count;
    };

    const std::size_t coarsest = levels_.front().size;
    shoot(levels_.front().directions);
    for (std::size_t r = 0; r < coarsest; ++r) {
        for (std::size_t c = 0; c < coarsest; ++c) {
            blocked[r] |= std::uint64_t{scratch.hit[r * coarsest + c]} << c;
        }
    }
    const double budget = max_error_ * max_error_ * unoccluded_norm_ * unoccluded_norm_;
    std::size_t deepest = 0;
    for (;; ++deepest) {
        const Level& level = levels_[deepest];
        const Bitmap marked = edges(blocked, level.size);
        // An edge that crosses a cell leaves an error of variance 1/12 of the cell; half the marked cells are crossed.
        result.variance = 0.0;
        scratch.cells.clear();
        for (std::size_t r = 0; r < level.size; ++r) {
            for (std::uint64_t bits = marked[r]; bits != 0; bits &= bits - 1) {
                const std::size_t cell = r * level.size + static_cast<std::size_t>(std::countr_zero(bits));
                scratch.cells.push_back(static_cast<std::uint32_t>(cell));
                result.variance += static_cast<double>(level.norm2[cell]) / 24.0;
            }
        }
        if (deepest + 1 == levels_.size() || result.variance <= budget) {
            break;
        }
        // Each marked cell becomes four; the others pass on what they are.
        const std::size_t parents = scratch.cells.size();
        const std::size_t size = 2 * level.size;
        for (std::size_t i = 0; i < parents; ++i) {
            const std::size_t cell = scratch.cells[i];
            const std::size_t child = 2 * (cell / level.size) * size + 2 * (cell % level.size);
            scratch.cells[i] = static_cast<std::uint32_t>(child);
            scratch.cells.push_back(static_cast<std::uint32_t>(child + 1));
            scratch.cells.push_back(static_cast<std::uint32_t>(child + size));
            scratch.cells.push_back(static_cast<std::uint32_t>(child + size + 1));
        }
        for (std::size_t r = level.size; r-- > 0;) {
            const std::uint64_t row = spread(blocked[r]);
            blocked[2 * r] = row;
            blocked[2 * r + 1] = row;
        }
        const Level& finer = levels_[deepest + 1];
        scratch.local.resize(scratch.cells.size());
        for (std::size_t i = 0; i < scratch.cells.size(); ++i) {
            scratch.local.x[i] = finer.directions.x[scratch.cells[i]];
            scratch.local.y[i] = finer.directions.y[scratch.cells[i]];
            scratch.local.z[i] = finer.directions.z[scratch.cells[i]];
        }
        shoot(scratch.local);
        for (std::size_t i = 0; i < scratch.cells.size(); ++i) {
            const std::size_t cell = scratch.cells[i];
            const std::uint64_t bit = std::uint64_t{1} << (cell % size);
            std::uint64_t& row = blocked[cell / size];
            row = scratch.hit[i] != 0 ? row | bit : row & ~bit;
        }
    }

    std::size_t total = 0;
    const Level& level = levels_[deepest];
    for (std::size_t r = 0; r < level.size; ++r) {
        total += static_cast<std::size_t>(std::popcount(blocked[r]));
    }
    const std::size_t cells = level.size * level.size;
    // As in trace_list: sum the smaller set.
    const bool sum_visible = 2 * total > cells;
    if (sum_visible) {
        const std::uint64_t all = level.size == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << level.size) - 1;
        for (std::size_t r = 0; r < level.size; ++r) {
            blocked[r] ^= all;
        }
    }
    // Top down: a coarse cell whose fine cells agree is one addition.
    CoefficientRow sum;
    const auto collect = [&](const auto& self, std::size_t depth, std::size_t row, std::size_t column) -> void {
        const std::size_t scale = level.size / levels_[depth].size;
        const std::uint64_t mask = (scale == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << scale) - 1)
                                   << (column * scale);
        bool none = true;
        bool full = true;
        for (std::size_t r = row * scale; r < (row + 1) * scale; ++r) {
            none = none && (blocked[r] & mask) == 0;
            full = full && (blocked[r] & mask) == mask;
        }
        if (none) {
            return;
        }
        if (full) {
            add(sum, levels_[depth].integral[row * levels_[depth].size + column]);
            return;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            self(self, depth + 1, 2 * row + k / 2, 2 * column + k % 2);
        }
    };
    const std::size_t scale = level.size / coarsest;
    for (std::size_t r = 0; r < coarsest; ++r) {
        std::uint64_t any = 0;
        for (std::size_t k = 0; k < scale; ++k) {
            any |= blocked[r * scale + k];
        }
        for (; any != 0;) {
            const std::size_t c = static_cast<std::size_t>(std::countr_zero(any)) / scale;
            collect(collect, 0, r, c);
            const std::size_t end = (c + 1) * scale;
            any = end >= 64 ? 0 : any & (~std::uint64_t{0} << end);
        }
    }
    for (std::size_t i = 0; i < coefficients_; ++i) {
        result.transfer.values[i] = sum_visible ? sum.values[i] : unoccluded_.values[i] - sum.values[i];
    }
    result.visibility = 1.0 - static_cast<double>(total) / static_cast<double>(cells);
    return result;
}

} // namespace alpenglow::prt
