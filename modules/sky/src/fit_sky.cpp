#include <alpenglow/sky/fit_sky.hpp>

#include "fit_normaliser.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

// Parameter for a Chebyshev variable in -1 .. 1.
double parameter(const FitAxis& axis, double x) {
    const double t = 0.5 * (x + 1.0);
    switch (axis.map) {
    case FitMap::half_tangent: {
        const double low = std::tan(0.5 * axis.low);
        const double high = std::tan(0.5 * axis.high);
        return 2.0 * std::atan(low + (high - low) * t);
    }
    case FitMap::log_offset:
        return axis.offset +
               std::exp(std::log(axis.low - axis.offset) * (1.0 - t) + std::log(axis.high - axis.offset) * t);
    case FitMap::linear:
        break;
    }
    return axis.low + (axis.high - axis.low) * t;
}

double node(int i, int count) {
    return std::cos(pi * (i + 0.5) / count);
}

// A tensor of `functions` values a node; the nodes' indices run with the last axis fastest.
struct Grid {
    std::vector<int> sizes;
    std::size_t functions = 0;
    std::vector<double> values;

    [[nodiscard]] std::size_t nodes() const {
        return std::accumulate(sizes.begin(), sizes.end(), std::size_t{1},
                               [](std::size_t a, int b) { return a * static_cast<std::size_t>(b); });
    }
    [[nodiscard]] std::vector<int> indices(std::size_t flat) const {
        std::vector<int> out(sizes.size());
        for (std::size_t a = sizes.size(); a-- > 0;) {
            out[a] = static_cast<int>(flat % static_cast<std::size_t>(sizes[a]));
            flat /= static_cast<std::size_t>(sizes[a]);
        }
        return out;
    }
};

// Values at Chebyshev nodes -> Chebyshev coefficients, an axis at a time.
Grid transformed(Grid grid) {
    std::size_t inner = grid.functions;
    for (std::size_t a = grid.sizes.size(); a-- > 0;) {
        const int n = grid.sizes[a];
        const auto count = static_cast<std::size_t>(n);
        const std::size_t outer = grid.values.size() / (inner * count);
        std::vector<double> out(grid.values.size(), 0.0);
        for (std::size_t o = 0; o < outer; ++o) {
            for (int k = 0; k < n; ++k) {
                for (int i = 0; i < n; ++i) {
                    const double w = std::cos(pi * k * (i + 0.5) / n) * (k == 0 ? 1.0 : 2.0) / n;
                    const double* from = grid.values.data() + (o * count + static_cast<std::size_t>(i)) * inner;
                    double* to = out.data() + (o * count + static_cast<std::size_t>(k)) * inner;
                    for (std::size_t f = 0; f < inner; ++f) {
                        to[f] += w * from[f];
                    }
                }
            }
        }
        grid.values = std::move(out);
        inner *= count;
    }
    return grid;
}

// Product of Chebyshev polynomials of the given degrees at a node.
double product(const Grid& grid, const std::vector<int>& degrees, const std::vector<int>& at) {
    double w = 1.0;
    for (std::size_t a = 0; a < degrees.size(); ++a) {
        w *= std::cos(pi * degrees[a] * (at[a] + 0.5) / grid.sizes[a]);
    }
    return w;
}

} // namespace

Result<SkyFitPart> fit_sky_box(const SkyFitBox& box, FitNormaliser normaliser, int bands, const SkyBlackBox& sky,
                               SkyFitReport& report) {
    const std::size_t axes = box.axes.size();
    if (axes < 1 || axes > max_fit_axes || box.nodes.size() != axes) {
        return Error{"axes are " + std::to_string(axes), "sky fit", "1 to 4 axes and a node count for each"};
    }
    for (std::size_t a = 0; a < axes; ++a) {
        if (!(box.axes[a].low < box.axes[a].high) || box.nodes[a] < 2 || box.nodes[a] > 64) {
            return Error{"axis " + std::to_string(a) + " has an empty range or a bad node count", "sky fit",
                         "low < high, 2 to 64 nodes"};
        }
    }
    Grid grid;
    grid.sizes = box.nodes;
    grid.functions = static_cast<std::size_t>(3 * bands * (bands + 1) / 2);
    const std::size_t nodes = grid.nodes();
    grid.values.resize(nodes * grid.functions);
    std::vector<double> least(nodes);
    parallel_for(nodes, 4, [&](std::size_t begin, std::size_t end) {
        std::vector<glm::dvec3> c(static_cast<std::size_t>(bands * bands));
        std::vector<double> p(axes);
        for (std::size_t n = begin; n < end; ++n) {
            const std::vector<int> at = grid.indices(n);
            for (std::size_t a = 0; a < axes; ++a) {
                p[a] = parameter(box.axes[a], node(at[a], grid.sizes[a]));
            }
            least[n] = sky(p, bands, c);
            double* to = grid.values.data() + n * grid.functions;
            for (int l = 0; l < bands; ++l) {
                for (int m = 0; m <= l; ++m) {
                    const glm::dvec3& value = c[static_cast<std::size_t>(l * (l + 1) + m)];
                    *to++ = value.x;
                    *to++ = value.y;
                    *to++ = value.z;
                }
            }
        }
    });
    for (std::size_t n = 0; n < nodes; ++n) {
        if (!(least[n] > 0.0) || !std::isfinite(grid.values[n * grid.functions])) {
            return Error{"the black box returned a sky without light", "sky fit",
                         "finite coefficients, least luminance > 0"};
        }
    }

    SkyFitPart part;
    part.axes = box.axes;
    // Divide the normaliser out.
    std::vector<double> factor(nodes, 1.0);
    if (normaliser == FitNormaliser::preetham) {
        for (std::size_t n = 0; n < nodes; ++n) {
            const std::vector<int> at = grid.indices(n);
            const double theta = parameter(box.axes[0], node(at[0], grid.sizes[0]));
            const double turbidity = parameter(box.axes[1], node(at[1], grid.sizes[1]));
            factor[n] = PreethamNormaliser<double>::of(turbidity)(std::sin(theta), std::cos(theta));
        }
    } else if (normaliser == FitNormaliser::exponent) {
        Grid logs;
        logs.sizes = grid.sizes;
        logs.functions = 1;
        for (std::size_t n = 0; n < nodes; ++n) {
            const double* c = grid.values.data() + n * grid.functions;
            logs.values.push_back(std::log(luminance(glm::dvec3(c[0], c[1], c[2]))));
        }
        const Grid terms = transformed(logs);
        for (std::size_t k = 0; k < nodes; ++k) {
            // A coarse one is enough: what it leaves, the fit takes up.
            if (std::abs(terms.values[k]) > 0.02) {
                for (const int d : terms.indices(k)) {
                    part.log_degrees.push_back(static_cast<std::uint8_t>(d));
                }
                part.log_terms.push_back(static_cast<float>(terms.values[k]));
            }
        }
        for (std::size_t n = 0; n < nodes; ++n) {
            const std::vector<int> at = grid.indices(n);
            double exponent = 0.0;
            for (std::size_t i = 0; i < part.log_terms.size(); ++i) {
                const std::vector<int> d(part.log_degrees.begin() + static_cast<std::ptrdiff_t>(i * axes),
                                         part.log_degrees.begin() + static_cast<std::ptrdiff_t>((i + 1) * axes));
                exponent += static_cast<double>(part.log_terms[i]) * product(grid, d, at);
            }
            factor[n] = std::exp(exponent);
        }
    }
    for (std::size_t n = 0; n < nodes; ++n) {
        for (std::size_t f = 0; f < grid.functions; ++f) {
            grid.values[n * grid.functions + f] /= factor[n];
        }
        least[n] /= factor[n];
    }

    // Rows in order of their size; drop from the smallest while the error allows.
    const Grid rows = transformed(grid);
    std::vector<double> size(nodes);
    for (std::size_t r = 0; r < nodes; ++r) {
        for (std::size_t f = 0; f < grid.functions; ++f) {
            const double c = rows.values[r * grid.functions + f];
            size[r] += c * c;
        }
    }
    std::vector<std::size_t> order(nodes);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return size[a] != size[b] ? size[a] < size[b] : a < b; });
    std::vector<bool> kept(nodes, true);
    std::vector<double> residual(nodes * grid.functions, 0.0);
    std::vector<double> trial(residual.size());
    // E_mean relative to what is allowed: fewer bands hold to less, since they are what is asked for most.
    const auto allowance = [&](std::size_t functions) { return functions <= 18 ? 0.4 : functions <= 45 ? 0.6 : 1.0; };
    const auto errors = [&](const std::vector<double>& difference, SkyFitReport& out) {
        double strictest = 0.0;
        out.worst_e_mean = out.worst_e_max = out.mean_e_mean = 0.0;
        for (std::size_t n = 0; n < nodes; ++n) {
            for (std::size_t q = 0; q < 3; ++q) {
                double squares = 0.0;
                double sum = 0.0;
                for (std::size_t f = q; f < grid.functions; f += 3) {
                    const double d = difference[n * grid.functions + f];
                    squares += d * d;
                    sum += std::abs(d);
                    if (f + 3 >= grid.functions || f / 3 == 5 || f / 3 == 14) {
                        strictest = std::max(strictest, std::sqrt(squares) / least[n] / allowance(f + 1));
                    }
                }
                const double e_mean = std::sqrt(squares) / least[n];
                out.worst_e_mean = std::max(out.worst_e_mean, e_mean);
                out.worst_e_max = std::max(out.worst_e_max, sum / least[n]);
                out.mean_e_mean += e_mean / (3.0 * static_cast<double>(nodes));
            }
        }
        return strictest;
    };
    for (const std::size_t r : order) {
        trial = residual;
        const std::vector<int> degrees = rows.indices(r);
        const double* row = rows.values.data() + r * grid.functions;
        for (std::size_t n = 0; n < nodes; ++n) {
            const double w = product(grid, degrees, grid.indices(n));
            for (std::size_t f = 0; f < grid.functions; ++f) {
                trial[n * grid.functions + f] += w * row[f];
            }
        }
        if (errors(trial, report) > box.max_e_mean) {
            break;
        }
        residual.swap(trial);
        kept[r] = false;
    }
    errors(residual, report);
    report.samples = nodes;
    report.rows = 0;
    for (std::size_t r = 0; r < nodes; ++r) { // flat order sorts by the first axis
        if (!kept[r]) {
            continue;
        }
        ++report.rows;
        for (const int d : rows.indices(r)) {
            part.degrees.push_back(static_cast<std::uint8_t>(d));
        }
        for (std::size_t f = 0; f < grid.functions; ++f) {
            part.rows.push_back(static_cast<float>(rows.values[r * grid.functions + f]));
        }
    }
    return part;
}

FitError fit_error(const SkyFit& fit, std::span<const double> parameters, int bands, const SkyBlackBox& sky) {
    const auto count = static_cast<std::size_t>(bands * bands);
    std::vector<glm::dvec3> want(count);
    std::vector<glm::dvec3> got(count);
    const double least = sky(parameters, bands, want);
    evaluate_fit(fit, parameters, bands, got);
    glm::dvec3 squares(0.0);
    glm::dvec3 sums(0.0);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 d = got[i] - want[i];
        squares += d * d;
        sums += glm::abs(d);
    }
    return {std::sqrt(std::max({squares.x, squares.y, squares.z})) / least, std::max({sums.x, sums.y, sums.z}) / least};
}

SkyBlackBox preetham_black_box(int elevations, int azimuths) {
    return [elevations, azimuths](std::span<const double> p, int bands, std::span<glm::dvec3> c) {
        project_preetham(p[0], p[1], bands, {elevations, azimuths}, c);
        const double theta = std::clamp(p[0], 0.0, 0.5 * pi);
        const auto sky = make_preetham(glm::dvec3(std::sin(theta), 0.0, std::max(std::cos(theta), 0.0)), p[1]);
        double least = std::numeric_limits<double>::max();
        for (int i = 0; i <= 32; ++i) {
            for (int j = 0; j <= 24; ++j) {
                const double z = i / 32.0;
                const double a = pi * j / 24.0;
                const double r = std::sqrt(1.0 - z * z);
                least = std::min(least, luminance_chromaticity(sky, glm::dvec3(r * std::cos(a), r * std::sin(a), z)).x);
            }
        }
        return least;
    };
}

} // namespace alpenglow::sky
