#include "product_transform.hpp"

#include <alpenglow/sh/gauss_legendre.hpp>

#include <alpenglow/core/constants.hpp>

#include <array>
#include <cmath>

namespace alpenglow::sh::detail {
namespace {

ProductTransform make(int order) {
    // The integrand is a polynomial of degree 3 (order - 1) in z once the azimuth is done.
    std::vector<double> z, weights;
    const int nodes = 3 * (order - 1) / 2 + 1;
    gauss_legendre(nodes, z, weights);
    ProductTransform t;
    t.pairs = (nodes + 1) / 2;
    for (int pair = 0; pair < t.pairs; ++pair) {
        const auto node = static_cast<std::size_t>(pair);
        const bool middle = 2 * pair + 1 == nodes;
        const double height = middle ? 0.0 : z[node];
        std::array<double, max_coefficients> y;
        // At azimuth 0 the sine functions vanish and Y_l^m is the factor of cos(m phi).
        evaluate_basis(order, glm::dvec3(std::sqrt((1.0 - height) * (1.0 + height)), 0.0, height), y);
        int term = 0;
        for (int m = 0; m < order; ++m) {
            for (int l = m; l < order; ++l, ++term) {
                const double q = y[static_cast<std::size_t>(index(l, m))];
                t.forward[pair][term] = static_cast<float>(m == 0 ? q : 0.5 * q);
                t.backward[pair][term] = static_cast<float>(two_pi * weights[node] * q * (middle ? 0.5 : 1.0));
            }
        }
    }
    return t;
}

} // namespace

const ProductTransform& product_transform(int order) {
    static const std::array<ProductTransform, max_order> tables{make(1), make(2), make(3), make(4),
                                                                make(5), make(6), make(7), make(8)};
    return tables[static_cast<std::size_t>(order - 1)];
}

} // namespace alpenglow::sh::detail
