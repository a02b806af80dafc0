#include <alpenglow/sh/gauss_legendre.hpp>

#include <alpenglow/core/constants.hpp>

#include <cmath>

namespace alpenglow::sh {

// Nodes and weights of Gauss-Legendre quadrature on [-1, 1]: Newton on P_n from the usual cosine guess.
void gauss_legendre(int n, std::vector<double>& nodes, std::vector<double>& weights) {
    nodes.resize(static_cast<std::size_t>(n));
    weights.resize(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
        double x = std::cos(pi * (i + 0.75) / (n + 0.5));
        double slope = 1.0;
        for (int iteration = 0; iteration < 12; ++iteration) {
            double before = 0.0;
            double p = 1.0;
            for (int k = 1; k <= n; ++k) {
                const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            const double step = p / slope;
            x -= step;
            if (std::abs(step) < 1e-15) {
                break;
            }
        }
        nodes[static_cast<std::size_t>(i)] = x;
        weights[static_cast<std::size_t>(i)] = 2.0 / ((1.0 - x * x) * slope * slope);
    }
}

} // namespace alpenglow::sh
