// Gaunt coefficients of the lowest orders at compile time, from the exact integrals of monomials over the sphere.
#pragma once

#include "tables.hpp"

namespace alpenglow::sh::detail {

// The integral of x^a y^b z^c: zero unless all are even, else 4 pi (a-1)!! (b-1)!! (c-1)!! / (a+b+c+1)!!.
constexpr double monomial_integral(int a, int b, int c) {
    if (a % 2 != 0 || b % 2 != 0 || c % 2 != 0) {
        return 0.0;
    }
    double value = 4.0 * std::numbers::pi;
    for (const int e : {a, b, c}) {
        for (int i = e - 1; i > 1; i -= 2) {
            value *= i;
        }
    }
    for (int i = a + b + c + 1; i > 1; i -= 2) {
        value /= i;
    }
    return value;
}

struct Monomial {
    int a, b, c;
    double factor;
};

// Basis functions of order 3 as sums of monomials, with the normalisation of eq. 3 .. 5 of the deringing paper.
struct Polynomial {
    Monomial terms[3] = {};
    int count = 0;
};

constexpr Polynomial basis_polynomial(int i) {
    const double k0 = basis_tables.seed[0], k1 = basis_tables.a[1][0] * basis_tables.seed[0];
    const double k20 = 0.5 * constexpr_sqrt(5.0) * k0, k2 = basis_tables.seed[2];
    switch (i) {
    case 0:
        return {{{0, 0, 0, k0}}, 1};
    case 1:
        return {{{0, 1, 0, -k1}}, 1};
    case 2:
        return {{{0, 0, 1, k1}}, 1};
    case 3:
        return {{{1, 0, 0, -k1}}, 1};
    case 4:
        return {{{1, 1, 0, 2.0 * k2}}, 1};
    case 5:
        return {{{0, 1, 1, -2.0 * k2}}, 1};
    case 6:
        return {{{0, 0, 2, 2.0 * k20}, {2, 0, 0, -k20}, {0, 2, 0, -k20}}, 3};
    case 7:
        return {{{1, 0, 1, -2.0 * k2}}, 1};
    default:
        return {{{2, 0, 0, k2}, {0, 2, 0, -k2}}, 2};
    }
}

constexpr double gaunt(int i, int j, int k) {
    const Polynomial f = basis_polynomial(i), g = basis_polynomial(j), h = basis_polynomial(k);
    double sum = 0.0;
    for (int a = 0; a < f.count; ++a) {
        for (int b = 0; b < g.count; ++b) {
            for (int c = 0; c < h.count; ++c) {
                const Monomial &p = f.terms[a], &q = g.terms[b], &r = h.terms[c];
                sum += p.factor * q.factor * r.factor *
                       monomial_integral(p.a + q.a + r.a, p.b + q.b + r.b, p.c + q.c + r.c);
            }
        }
    }
    return sum < 1e-9 && sum > -1e-9 ? 0.0 : sum;
}

struct GauntTable3 {
    double value[9][9][9] = {};
};

constexpr GauntTable3 make_gaunt_table_3() {
    GauntTable3 t;
    for (int i = 0; i < 9; ++i) {
        for (int j = 0; j < 9; ++j) {
            for (int k = 0; k < 9; ++k) {
                t.value[i][j][k] = gaunt(i, j, k);
            }
        }
    }
    return t;
}

inline constexpr GauntTable3 gaunt_table_3 = make_gaunt_table_3();

} // namespace alpenglow::sh::detail
