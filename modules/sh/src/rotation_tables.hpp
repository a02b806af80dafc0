// Ivanic and Ruedenberg's recursion (1996, with the 1998 corrections): constants, and one step of it, usable at compile
// time. In the basis without Condon-Shortley phase.
#pragma once

#include "tables.hpp"

namespace alpenglow::sh::detail {

struct RecursionWeights {
    double u, v, w;
};

constexpr int absolute(int i) {
    return i < 0 ? -i : i;
}

constexpr RecursionWeights recursion_weights(int l, int m, int n) {
    const int am = absolute(m);
    const double denominator = absolute(n) == l ? 2.0 * l * (2.0 * l - 1.0) : static_cast<double>((l + n) * (l - n));
    return {constexpr_sqrt((l + m) * (l - m) / denominator),
            0.5 * constexpr_sqrt((m == 0 ? 2.0 : 1.0) * (l + am - 1) * (l + am) / denominator) * (m == 0 ? -1.0 : 1.0),
            m == 0 ? 0.0 : -0.5 * constexpr_sqrt((l - am - 1) * (l - am) / denominator)};
}

constexpr int band_offset(int l) {
    return l * (4 * l * l - 1) / 3;
}

// Element (m, n) of band l >= 2, from band l-1 (rows of 2l-1) and the direction matrix r[i+1][j+1] in the axis order
// y, z, x, which is the order of band 1.
class RecursionStep {
public:
    constexpr RecursionStep(const double (&r)[3][3], const double* previous, int l)
        : r_(r), previous_(previous), l_(l) {}

    constexpr double element(int m, int n, const RecursionWeights& k) const {
        double sum = 0.0;
        if (k.u != 0.0) {
            sum += k.u * p(0, m, n);
        }
        if (k.v != 0.0) {
            sum += k.v * v(m, n);
        }
        if (k.w != 0.0) {
            sum += k.w * (m > 0 ? p(1, m + 1, n) + p(-1, -m - 1, n) : p(1, m - 1, n) - p(-1, -m + 1, n));
        }
        return sum;
    }

private:
    constexpr double at(int m, int n) const { return previous_[(m + l_ - 1) * (2 * l_ - 1) + n + l_ - 1]; }
    constexpr double r(int i, int j) const { return r_[i + 1][j + 1]; }
    constexpr double p(int i, int m, int n) const {
        if (n == l_) {
            return r(i, 1) * at(m, l_ - 1) - r(i, -1) * at(m, -l_ + 1);
        }
        if (n == -l_) {
            return r(i, 1) * at(m, -l_ + 1) + r(i, -1) * at(m, l_ - 1);
        }
        return r(i, 0) * at(m, n);
    }
    constexpr double v(int m, int n) const {
        constexpr double sqrt2 = 1.4142135623730951;
        if (m == 0) {
            return p(1, 1, n) + p(-1, -1, n);
        }
        if (m > 0) {
            return m == 1 ? sqrt2 * p(1, 0, n) : p(1, m - 1, n) - p(-1, -m + 1, n);
        }
        return m == -1 ? sqrt2 * p(-1, 0, n) : p(1, m + 1, n) + p(-1, -m - 1, n);
    }

    const double (&r_)[3][3];
    const double* previous_;
    int l_;
};

struct RecursionTables {
    RecursionWeights weights[band_offset(max_order)] = {};
};

constexpr RecursionTables make_recursion_tables() {
    RecursionTables t;
    for (int l = 1, i = 1; l < max_order; ++l) {
        for (int m = -l; m <= l; ++m) {
            for (int n = -l; n <= l; ++n, ++i) {
                t.weights[i] = recursion_weights(l, m, n);
            }
        }
    }
    return t;
}

inline constexpr RecursionTables recursion_tables = make_recursion_tables();

// Fills elements[0 .. band_offset(order)) with the blocks of all bands, in the basis with phase.
constexpr void rotation_blocks(int order, const double (&r)[3][3], double* elements) {
    elements[0] = 1.0;
    for (int l = 1; l < order; ++l) {
        const RecursionStep step(r, elements + band_offset(l - 1), l);
        int i = band_offset(l);
        for (int m = -l; m <= l; ++m) {
            for (int n = -l; n <= l; ++n, ++i) {
                elements[i] = l == 1 ? r[m + 1][n + 1] : step.element(m, n, recursion_tables.weights[i]);
            }
        }
    }
    for (int l = 1, i = 1; l < order; ++l) {
        for (int m = -l; m <= l; ++m) {
            for (int n = -l; n <= l; ++n, ++i) {
                elements[i] = (m + n) % 2 != 0 ? -elements[i] : elements[i];
            }
        }
    }
}

// The reflection y <-> z, exact zeros where it has them.
struct SwapTables {
    double element[band_offset(max_order)] = {};
};

constexpr SwapTables make_swap_tables() {
    SwapTables t;
    const double r[3][3] = {{0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
    rotation_blocks(max_order, r, t.element);
    for (double& e : t.element) {
        e = e < 1e-12 && e > -1e-12 ? 0.0 : e;
    }
    return t;
}

inline constexpr SwapTables swap_tables = make_swap_tables();

} // namespace alpenglow::sh::detail
