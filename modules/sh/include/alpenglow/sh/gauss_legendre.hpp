// Gauss-Legendre quadrature on [-1, 1].
#pragma once

#include <vector>

namespace alpenglow::sh {

// n nodes, from +1 down to -1, and their weights: exact for polynomials up to degree 2n - 1.
void gauss_legendre(int n, std::vector<double>& nodes, std::vector<double>& weights);

} // namespace alpenglow::sh
