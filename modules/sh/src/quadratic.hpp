// Order 3 as c + b.n + n^T A n, and its minimum over unit n.
#pragma once

#include <span>

namespace alpenglow::sh::detail {

// Diagonalised: f(n) = c + sum_i (beta_i n_i + lambda_i n_i^2), lambda ascending, in an orthonormal frame axes[i] (x,
// y, z).
struct Quadratic {
    double c = 0.0;
    double beta[3] = {};
    double lambda[3] = {};
    double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};

// From nine coefficients. The trace is in lambda: they sum to zero.
Quadratic diagonalise(std::span<const double> f) noexcept;

struct QuadraticMinimum {
    double dual = 0.0; // a lower bound for any mu; at the solution the minimum itself
    double n[3] = {};  // the minimiser in the frame
};

// Minimum of c + w1 beta.n + w2 lambda.n^2.
QuadraticMinimum minimise(const Quadratic& q, double w1, double w2) noexcept;

} // namespace alpenglow::sh::detail
