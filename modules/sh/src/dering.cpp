#include <alpenglow/sh/dering.hpp>

#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/window.hpp>
#include <alpenglow/sh/zonal.hpp>

#include "quadratic.hpp"
#include "tables.hpp"
#include "window_path.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::sh {
namespace {

double band_norm(int l, std::span<const double> f) {
    double sum = 0.0;
    for (int m = -l; m <= l; ++m) {
        sum = std::hypot(sum, f[static_cast<std::size_t>(index(l, m))]);
    }
    return sum;
}

// ---- Branch and bound on the faces of a cube
// --------------------------------------------------------------------------

struct Cell {
    int face;
    double u, v, half; // centre and half width on the face, -1 .. 1
};

glm::dvec3 cube_direction(int face, double u, double v) {
    const double s = face % 2 != 0 ? -1.0 : 1.0;
    const glm::dvec3 d = face < 2 ? glm::dvec3(s, u, v) : face < 4 ? glm::dvec3(u, s, v) : glm::dvec3(u, v, s);
    return glm::normalize(d);
}

// The largest angle from the centre to a corner.
double cell_radius(const Cell& cell, const glm::dvec3& centre) {
    double chord = 0.0;
    for (const double su : {-1.0, 1.0}) {
        for (const double sv : {-1.0, 1.0}) {
            const glm::dvec3 corner = cube_direction(cell.face, cell.u + su * cell.half, cell.v + sv * cell.half);
            chord = std::max(chord, glm::length(corner - centre));
        }
    }
    return 2.0 * std::asin(std::min(0.5 * chord, 1.0));
}

struct Search {
    Minimum best;
    bool complete = true;
};

// Lowers best.value until no cell can hold anything below best.value - tolerance, or, with `floor`, until it is known
// whether anything is below the floor.
Search branch_and_bound(int order, std::span<const double> f, double tolerance, const Cap& cap, const double* floor) {
    double slope = 0.0, curvature = 0.0;
    for (int l = 1; l < order; ++l) {
        const double sup = std::sqrt((2.0 * l + 1.0) / (4.0 * pi)) * band_norm(l, f);
        slope += l * sup;
        curvature += static_cast<double>(l) * l * sup;
    }
    constexpr std::size_t most_cells = 400'000;
    const double cap_angle = std::acos(std::clamp(cap.cos_angle, -1.0, 1.0));
    const bool whole = cap.cos_angle <= -1.0;
    std::vector<Cell> cells, next;
    const int initial = 2 * order;
    for (int face = 0; face < 6; ++face) {
        for (int i = 0; i < initial; ++i) {
            for (int j = 0; j < initial; ++j) {
                cells.push_back(
                    {face, (2.0 * i + 1.0) / initial - 1.0, (2.0 * j + 1.0) / initial - 1.0, 1.0 / initial});
            }
        }
    }
    Search search;
    Minimum& best = search.best;
    best.value = std::numeric_limits<double>::infinity();
    if (!whole) {
        best.direction = cap.axis;
        best.value = evaluate(order, f, cap.axis);
    }
    double dropped = std::numeric_limits<double>::infinity(); // the least bound of cells let go
    std::size_t seen = 0;
    while (!cells.empty()) {
        next.clear();
        // Values of this level first: a good upper bound drops more.
        struct Bounded {
            Cell cell;
            double bound;
        };
        std::vector<Bounded> level;
        level.reserve(cells.size());
        for (const Cell& cell : cells) {
            const glm::dvec3 centre = cube_direction(cell.face, cell.u, cell.v);
            const double radius = cell_radius(cell, centre);
            const double value = evaluate(order, f, centre);
            double bound = value - 0.5 * curvature * radius * radius;
            bool inside = true;
            if (!whole) {
                const double angle = std::atan2(glm::length(glm::cross(centre, cap.axis)), glm::dot(centre, cap.axis));
                if (angle - radius > cap_angle) {
                    continue;
                }
                inside = angle <= cap_angle;
                if (angle + radius > cap_angle) {
                    bound = value - slope * radius; // the minimum may be on the rim, where the gradient need not vanish
                }
            }
            if (inside && value < best.value) {
                best.value = value;
                best.direction = centre;
            }
            level.push_back({cell, bound});
        }
        seen += cells.size();
        if (floor != nullptr && best.value < *floor) {
            break;
        }
        const double needed = floor != nullptr ? *floor : best.value - tolerance;
        const bool full = seen > most_cells;
        for (const Bounded& b : level) {
            if (b.bound >= needed || full) {
                dropped = std::min(dropped, b.bound);
                continue;
            }
            const double half = 0.5 * b.cell.half;
            for (const double su : {-half, half}) {
                for (const double sv : {-half, half}) {
                    next.push_back({b.cell.face, b.cell.u + su, b.cell.v + sv, half});
                }
            }
        }
        search.complete = !full;
        std::swap(cells, next);
    }
    best.lower_bound = std::min(dropped, best.value);
    return search;
}

// ---- The paper's bound
// -------------------------------------------------------------------------------------------------

// a z^2 + b z + c with the amplitude q of the |m| = 1 pair, in the frame of the optimal linear direction.
struct PaperBound {
    double a = 0.0, b = 0.0, c_mean = 0.0, c_quadratic = 0.0, q = 0.0;
};

PaperBound paper_terms(std::span<const double> f) noexcept {
    const glm::dvec3 d = optimal_linear_direction(f);
    // A frame around d (Duff et al. 2017): no case where it degenerates.
    const double sign = std::copysign(1.0, d.z);
    const double k = -1.0 / (sign + d.z), xy = d.x * d.y * k;
    const glm::dvec3 u(1.0 + sign * d.x * d.x * k, sign * xy, -sign * d.x), v(xy, sign + d.y * d.y * k, -d.y);
    const double k0 = detail::basis_tables.poly[0][0][0], k1 = detail::basis_tables.poly[1][0][0];
    const double k2 = detail::basis_tables.seed[2], k20 = -detail::basis_tables.poly[2][0][0];
    const auto form = [&](const glm::dvec3& p, const glm::dvec3& r) {
        return (-k20 * f[6] + k2 * f[8]) * p.x * r.x + (-k20 * f[6] - k2 * f[8]) * p.y * r.y +
               2.0 * k20 * f[6] * p.z * r.z + k2 * f[4] * (p.x * r.y + p.y * r.x) -
               k2 * f[5] * (p.y * r.z + p.z * r.y) - k2 * f[7] * (p.x * r.z + p.z * r.x);
    };
    const double zz = form(d, d);                                              // 2 k20 f6'
    const double q2 = std::hypot(0.5 * (form(u, u) - form(v, v)), form(u, v)); // k2 sqrt(f4'^2 + f8'^2)
    PaperBound p;
    p.q = 2.0 * std::hypot(form(u, d), form(v, d)); // 2 k2 sqrt(f5'^2 + f7'^2)
    p.b = k1 * (-f[3] * d.x - f[1] * d.y + f[2] * d.z);
    p.a = 1.5 * zz + q2;
    p.c_mean = k0 * f[0];
    p.c_quadratic = -0.5 * zz - q2;
    return p;
}

double paper_minimum(const PaperBound& p, double w1, double w2) noexcept {
    const double a = w2 * p.a, b = w1 * p.b, c = p.c_mean + w2 * p.c_quadratic, q = w2 * p.q;
    // Without the |m| = 1 pair (sections 2.3.1 and 2.3.2).
    double least = std::min(a + b + c, a - b + c);
    if (a > 0.0 && std::abs(b) < 2.0 * a) {
        least = std::min(least, c - 0.25 * b * b / a);
    }
    if (least - 0.5 * q >= 0.0 || q == 0.0) {
        return least - 0.5 * q; // the early out: the pair adds at least -q / 2
    }
    least = std::numeric_limits<double>::infinity();
    // Newton, made safe: in z = cos(t) the function is smooth up to the poles. Each half has at most two minima;
    // eighths of a right angle bracket them, and a Newton step that leaves its bracket is replaced by a bisection.
    constexpr double step = pi / 16.0;
    for (int i = 8; i < 16; ++i) {
        const auto value = [&](double t) { return (a * std::cos(t) + b + q * std::sin(t)) * std::cos(t) + c; };
        const auto slope = [&](double t) { return -a * std::sin(2.0 * t) - b * std::sin(t) + q * std::cos(2.0 * t); };
        double low = i * step, high = low + step, t = 0.5 * (low + high);
        least = std::min({least, value(low), value(high)});
        if (!(slope(low) < 0.0 && slope(high) > 0.0)) {
            continue;
        }
        for (int iteration = 0; iteration < 40; ++iteration) {
            const double g = slope(t);
            (g < 0.0 ? low : high) = t;
            const double bend = -2.0 * a * std::cos(2.0 * t) - b * std::cos(t) - 2.0 * q * std::sin(2.0 * t);
            const double newton = bend > 0.0 ? t - g / bend : low;
            const double after = newton > low && newton < high ? newton : 0.5 * (low + high);
            if (std::abs(after - t) < 1e-15) {
                break;
            }
            t = after;
        }
        least = std::min(least, value(t));
    }
    return least;
}

// ---- The search for a window
// -------------------------------------------------------------------------------------------

constexpr double paper_end = 6.0 / 7.0;

// Band factors of the signal that must not be negative.
std::array<double, max_order> signal_factors(Signal signal) {
    std::array<double, max_order> s{};
    for (int l = 0; l < max_order; ++l) {
        s[static_cast<std::size_t>(l)] = signal == Signal::irradiance ? cosine_factor(l) / pi : 1.0;
    }
    return s;
}

double strength_by_paper(std::span<const double> f) {
    const PaperBound terms = paper_terms(f);
    const double floor = -dering_tolerance * terms.c_mean;
    const auto fits = [&](double t) {
        std::array<double, 3> w;
        family_factors(WindowFamily::sloan, t, 3, w);
        return paper_minimum(terms, w[1], w[2]) >= floor;
    };
    if (fits(0.0)) {
        return 0.0;
    }
    if (!fits(paper_end)) {
        return paper_end;
    }
    // Binary search over the columns, then between two of them.
    int low = 0, high = 6;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        (fits(middle / 7.0) ? high : low) = middle;
    }
    double a = low / 7.0, b = high / 7.0;
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (a + b);
        (fits(middle) ? b : a) = middle;
    }
    return b;
}

double strength_exact(int order, std::span<const double> f, const DeringOptions& options) {
    const double mean = f[0] * detail::basis_tables.poly[0][0][0];
    // Irradiance has no third band.
    const bool quadratic =
        (order <= 3 || (order == 4 && options.signal == Signal::irradiance)) && options.cap.cos_angle <= -1.0;
    const double floor = -(quadratic ? dering_tolerance : 1e-4) * mean;
    std::array<double, 9> padded_f{};
    std::copy_n(f.begin(), std::min<std::size_t>(9, f.size()), padded_f.begin());
    const detail::Quadratic q = detail::diagonalise(padded_f);
    std::vector<double> windowed(f.begin(), f.end());
    if (options.family == WindowFamily::blend) {
        // Linear in the factor: one minimum of the part without mean tells.
        windowed[0] = 0.0;
        const double least =
            quadratic ? detail::minimise(q, 1.0, 1.0).dual - q.c
                      : branch_and_bound(order, windowed, 1e-5 * mean, options.cap, nullptr).best.lower_bound;
        return mean + least >= floor ? 0.0 : 1.0 + mean / least;
    }
    const auto fits = [&](double t) {
        std::array<double, max_order> w{};
        family_factors(options.family, t, order, w);
        if (quadratic) {
            return detail::minimise(q, order > 1 ? w[1] : 0.0, order > 2 ? w[2] : 0.0).dual >= (t > 0.0 ? 0.0 : floor);
        }
        apply_window(order, w, f, std::span<double>(windowed));
        const Search search = branch_and_bound(order, windowed, 0.0, options.cap, &floor);
        return search.complete && search.best.value >= floor;
    };
    if (fits(0.0)) {
        return 0.0;
    }
    double low = 0.0, high = 1.0;
    for (int i = 0; i < (quadratic ? 50 : 14); ++i) {
        const double middle = 0.5 * (low + high);
        (fits(middle) ? high : low) = middle;
    }
    return high;
}

template <class Real>
void apply_factors(int order, const Dering& dering, std::span<const Real> channels, std::span<Real> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(channels.size() % count == 0 && out.size() >= channels.size());
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const int l = static_cast<int>(std::sqrt(static_cast<double>(i % count) + 0.5));
        const Real factor = static_cast<Real>(dering.factors[static_cast<std::size_t>(l)]);
        out[i] = factor == Real(0) ? Real(0) : factor * channels[i];
    }
}

} // namespace

void family_factors(WindowFamily family, double t, int order, std::span<double> factors) noexcept {
    assert(order >= 1 && order <= max_order && factors.size() >= static_cast<std::size_t>(order) && t >= 0.0 &&
           t <= 1.0);
    switch (family) {
    case WindowFamily::hann:
        return window_factors(Window::hann, 1.0 / std::max(t, 1e-300), order, factors);
    case WindowFamily::sinc:
        return window_factors(Window::sinc, 1.0 / std::max(t, 1e-300), order, factors);
    case WindowFamily::sinc4:
        return window_factors(Window::sinc4, 1.0 / std::max(t, 1e-300), order, factors);
    default:
        break;
    }
    assert(family != WindowFamily::sloan || order <= 4);
    for (int l = 0; l < order; ++l) {
        double& factor = factors[static_cast<std::size_t>(l)];
        if (l == 0) {
            factor = 1.0;
        } else if (family == WindowFamily::blend) {
            factor = 1.0 - t;
        } else if (family == WindowFamily::gauss) {
            factor = std::pow(1.0 - t, 0.5 * l * (l + 1.0));
        } else {
            const double x = t * (detail::sloan_columns - 1);
            const int column = std::min(static_cast<int>(x), detail::sloan_columns - 2);
            const double* row = detail::sloan_table[std::min(l, 3) - 1];
            factor = row[column] + (x - column) * (row[column + 1] - row[column]);
        }
    }
}

Minimum quadratic_minimum(std::span<const double> f) noexcept {
    assert(f.size() >= 9);
    const detail::Quadratic q = detail::diagonalise(f);
    const detail::QuadraticMinimum m = detail::minimise(q, 1.0, 1.0);
    Minimum result;
    result.direction = glm::dvec3(0.0);
    for (int i = 0; i < 3; ++i) {
        result.direction += m.n[i] * glm::dvec3(q.axes[i][0], q.axes[i][1], q.axes[i][2]);
    }
    result.direction = glm::normalize(result.direction);
    result.value = evaluate(3, f, result.direction);
    result.lower_bound = std::min(m.dual, result.value);
    return result;
}

Minimum certified_minimum(int order, std::span<const double> f, double tolerance, const Cap& cap) {
    assert(order >= 1 && order <= max_order && f.size() >= static_cast<std::size_t>(coefficient_count(order)));
    return branch_and_bound(order, f, tolerance, cap, nullptr).best;
}

double paper_bound(std::span<const double> f) noexcept {
    assert(f.size() >= 9);
    return paper_minimum(paper_terms(f), 1.0, 1.0);
}

Dering find_window(int order, std::span<const double> channels, const DeringOptions& options) {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && channels.size() % count == 0 && !channels.empty());
    assert(options.method == DeringMethod::exact || order <= 3);
    Dering result;
    const std::array<double, max_order> signal = signal_factors(options.signal);
    std::array<double, max_coefficients> f{};
    for (std::size_t first = 0; first < channels.size() && result.outcome != DeringOutcome::not_finite;
         first += count) {
        double largest = 0.0;
        bool finite = true;
        for (std::size_t i = 0; i < count; ++i) {
            finite = finite && std::isfinite(channels[first + i]);
            largest = std::max(largest, std::abs(channels[first + i]));
        }
        if (!finite) {
            result.outcome = DeringOutcome::not_finite;
            break;
        }
        if (largest == 0.0) {
            continue; // a dark channel asks for nothing
        }
        if (channels[first] <= 0.0) {
            result.outcome = DeringOutcome::dark;
            continue;
        }
        if (result.outcome == DeringOutcome::dark) {
            continue;
        }
        // Scaled by a power of two to the order of 1, which changes no digit.
        int exponent = 0;
        static_cast<void>(std::frexp(largest, &exponent));
        f.fill(0.0);
        for (int l = 0; l < order; ++l) {
            for (int m = -l; m <= l; ++m) {
                const auto i = static_cast<std::size_t>(index(l, m));
                f[i] = signal[static_cast<std::size_t>(l)] * std::ldexp(channels[first + i], -exponent);
            }
        }
        if (f[0] == 0.0) { // an average lost against the rest even in double
            result.outcome = DeringOutcome::dark;
            continue;
        }
        const std::span<const double> used(f.data(), std::max<std::size_t>(count, 9));
        const double strength =
            options.method == DeringMethod::paper ? strength_by_paper(used) : strength_exact(order, used, options);
        if (strength > result.strength) {
            result.strength = strength;
            result.outcome = DeringOutcome::windowed;
        }
    }
    if (result.outcome == DeringOutcome::dark || result.outcome == DeringOutcome::not_finite) {
        result.strength = 1.0;
        return result;
    }
    family_factors(options.method == DeringMethod::paper ? WindowFamily::sloan : options.family, result.strength, order,
                   result.factors);
    return result;
}

void apply_dering(int order, const Dering& dering, std::span<const double> channels, std::span<double> out) noexcept {
    apply_factors<double>(order, dering, channels, out);
}
void apply_dering(int order, const Dering& dering, std::span<const float> channels, std::span<float> out) noexcept {
    apply_factors<float>(order, dering, channels, out);
}

DeringPair dering_apart(std::span<const double> direct, std::span<const double> indirect, std::span<double> out,
                        const DeringOptions& options) {
    assert(direct.size() == indirect.size() && out.size() >= direct.size() && direct.size() % 9 == 0);
    std::vector<double> punctual(direct.begin(), direct.end());
    for (std::size_t i = 0; i < punctual.size(); ++i) {
        punctual[i] *= punctual_window[i % 9 == 0 ? 0 : i % 9 < 4 ? 1 : 2];
    }
    DeringPair pair{find_window(3, punctual, options), find_window(3, indirect, options)};
    std::vector<double> rest(indirect.size());
    apply_dering(3, pair.direct, punctual, std::span<double>(punctual));
    apply_dering(3, pair.indirect, indirect, std::span<double>(rest));
    for (std::size_t i = 0; i < rest.size(); ++i) {
        out[i] = punctual[i] + rest[i];
    }
    return pair;
}

} // namespace alpenglow::sh
