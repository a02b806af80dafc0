#include <alpenglow/sh/product.hpp>

#include <alpenglow/sh/project.hpp>

#include "matrix_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace alpenglow::sh {
namespace {

std::vector<GauntEntry> make_gaunt_table(int order) {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    const SphereQuadrature q = sphere_quadrature(3 * (order - 1));
    const std::size_t points = q.weights.size();
    // basis[i * points + p]
    std::vector<double> basis(count * points);
    for (std::size_t p = 0; p < points; ++p) {
        std::array<double, max_coefficients> y;
        evaluate_basis(order, q.directions[p], y);
        for (std::size_t i = 0; i < count; ++i) {
            basis[i * points + p] = y[i];
        }
    }
    std::vector<GauntEntry> table;
    std::vector<double> pair(points);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i; j < count; ++j) {
            for (std::size_t p = 0; p < points; ++p) {
                pair[p] = q.weights[p] * basis[i * points + p] * basis[j * points + p];
            }
            for (std::size_t k = j; k < count; ++k) {
                double sum = 0.0;
                for (std::size_t p = 0; p < points; ++p) {
                    sum += pair[p] * basis[k * points + p];
                }
                // The smallest true coefficient up to order 8 is above 1e-3; rounding is below 1e-14.
                if (std::abs(sum) > 1e-9) {
                    table.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j),
                                     static_cast<std::uint8_t>(k), sum});
                }
            }
        }
    }
    return table;
}

// Calls f(i, j, k, G) for every ordered triple of one table entry.
template <class F>
void for_permutations(const GauntEntry& e, F&& f) {
    const std::size_t i = e.i, j = e.j, k = e.k;
    f(i, j, k);
    if (i != j) {
        f(j, i, k);
    }
    if (j != k) {
        f(i, k, j);
        f(k, i, j);
    }
    if (i != k && i != j) {
        f(j, k, i);
        if (j != k) {
            f(k, j, i);
        }
    }
}

template <class Real>
void multiply(int order, std::span<const Real> f, std::span<const Real> g, std::span<Real> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(f.size() >= count && g.size() >= count && out.size() >= count);
    std::fill_n(out.begin(), count, Real(0));
    for (const GauntEntry& e : gaunt_table(order)) {
        const Real value = static_cast<Real>(e.value);
        for_permutations(e, [&](std::size_t a, std::size_t b, std::size_t c) { out[c] += value * f[a] * g[b]; });
    }
}

detail::MatrixTerms make_matrix_terms(int order) {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    struct Term {
        std::size_t row;
        float factor;
    };
    std::vector<std::vector<Term>> sums(count * count);
    for (const GauntEntry& e : gaunt_table(order)) {
        for_permutations(e, [&](std::size_t a, std::size_t b, std::size_t c) {
            sums[c * count + b].push_back({a, static_cast<float>(e.value)});
        });
    }
    detail::MatrixTerms terms;
    for (std::size_t row = 0; row < count; ++row) {
        for (std::size_t column = row; column < count; ++column) {
            for (const Term& term : sums[row * count + column]) {
                terms.rows.push_back(term.row);
                terms.factors.push_back(term.factor);
            }
            terms.entries.push_back({row, column, terms.rows.size()});
        }
    }
    return terms;
}

} // namespace

const detail::MatrixTerms& detail::matrix_terms(int order) {
    static const std::array<MatrixTerms, max_order> tables{
        make_matrix_terms(1), make_matrix_terms(2), make_matrix_terms(3), make_matrix_terms(4),
        make_matrix_terms(5), make_matrix_terms(6), make_matrix_terms(7), make_matrix_terms(8)};
    return tables[static_cast<std::size_t>(order - 1)];
}

std::span<const GauntEntry> gaunt_table(int order) {
    assert(order >= 1 && order <= max_order);
    switch (order) {
    case 1: {
        static const auto table = make_gaunt_table(1);
        return table;
    }
    case 2: {
        static const auto table = make_gaunt_table(2);
        return table;
    }
    case 3: {
        static const auto table = make_gaunt_table(3);
        return table;
    }
    case 4: {
        static const auto table = make_gaunt_table(4);
        return table;
    }
    case 5: {
        static const auto table = make_gaunt_table(5);
        return table;
    }
    case 6: {
        static const auto table = make_gaunt_table(6);
        return table;
    }
    case 7: {
        static const auto table = make_gaunt_table(7);
        return table;
    }
    default: {
        static const auto table = make_gaunt_table(8);
        return table;
    }
    }
}

void product(int order, std::span<const double> f, std::span<const double> g, std::span<double> out) noexcept {
    multiply<double>(order, f, g, out);
}
void product(int order, std::span<const float> f, std::span<const float> g, std::span<float> out) noexcept {
    multiply<float>(order, f, g, out);
}

void product_matrix(int order, std::span<const double> f, std::span<double> matrix) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(f.size() >= count && matrix.size() >= count * count);
    std::fill_n(matrix.begin(), count * count, 0.0);
    for (const GauntEntry& e : gaunt_table(order)) {
        for_permutations(e,
                         [&](std::size_t a, std::size_t b, std::size_t c) { matrix[c * count + b] += e.value * f[a]; });
    }
}

double triple_product(int order, std::span<const double> f, std::span<const double> g,
                      std::span<const double> h) noexcept {
    assert(f.size() >= static_cast<std::size_t>(coefficient_count(order)) && g.size() >= f.size() &&
           h.size() >= f.size());
    double sum = 0.0;
    for (const GauntEntry& e : gaunt_table(order)) {
        for_permutations(e, [&](std::size_t a, std::size_t b, std::size_t c) { sum += e.value * f[a] * g[b] * h[c]; });
    }
    return sum;
}

} // namespace alpenglow::sh
