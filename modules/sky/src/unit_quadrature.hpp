// Gauss-Legendre quadrature on [0, 1].
#pragma once

#include <alpenglow/sh/gauss_legendre.hpp>

#include <vector>

namespace alpenglow::sky {

struct UnitNodes {
    std::vector<double> x, w;
};

// `count` nodes, from 1 down to 0, and weights that sum to 1.
inline UnitNodes unit_quadrature(int count) {
    UnitNodes nodes;
    sh::gauss_legendre(count, nodes.x, nodes.w);
    for (std::size_t i = 0; i < nodes.x.size(); ++i) {
        nodes.x[i] = 0.5 * (1.0 + nodes.x[i]);
        nodes.w[i] *= 0.5;
    }
    return nodes;
}

} // namespace alpenglow::sky
