#include "product_transform.hpp"

#include <alpenglow/core/constants.hpp>

#include <array>
#include <cmath>

namespace alpenglow::sh::detail {
namespace {

// P_n(x) and P_n'(x).
struct Legendre {
    double value, slope;
};
Legendre legendre(int n, double x) {
    double p = 1.0, previous = 0.0;
    for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * previous) / k;
        previous = p;
        p = next;
    }
    return {p, n * (x * p - previous) / (x * x - 1.0)};
}

ProductTransform make(int order) {
    // The integrand is a polynomial of degree 3 (order - 1) in z once the azimuth is done; n inner nodes and the poles
    // are exact up to degree 2 n + 1. The inner nodes are the roots of P_(n+1)'.
    const int inner = (3 * (order - 1)) / 2, degree = inner + 1;
    const double scale = 2.0 / (degree * (degree + 1.0));
    ProductTransform t;
    t.pairs = inner / 2;
    t.middle = inner % 2 != 0;
    for (int circle = 0; circle < t.pairs + (t.middle ? 1 : 0); ++circle) {
        double z = circle == t.pairs ? 0.0 : std::cos(pi * (circle + 1.0) / degree);
        for (int iteration = 0; iteration < 50 && z != 0.0; ++iteration) {
            const Legendre p = legendre(degree, z);
            // (1 - z^2) P'' = 2 z P' - n (n + 1) P
            const double step = p.slope * (1.0 - z * z) / (2.0 * z * p.slope - degree * (degree + 1.0) * p.value);
            z -= step;
            if (std::abs(step) < 1e-16) {
                break;
            }
        }
        const double value = legendre(degree, z).value, weight = scale / (value * value);
        std::array<double, max_coefficients> y;
        // At azimuth 0 the sine functions vanish and Y_l^m is the factor of cos(m phi).
        evaluate_basis(order, glm::dvec3(std::sqrt((1.0 - z) * (1.0 + z)), 0.0, z), y);
        int term = 0;
        for (int m = 0; m < order; ++m) {
            for (int l = m; l < order; ++l, ++term) {
                const double q = y[static_cast<std::size_t>(index(l, m))];
                t.forward[circle][term] = static_cast<float>(m == 0 ? q : 0.5 * q);
                t.backward[circle][term] = static_cast<float>(two_pi * weight * q);
            }
        }
    }
    for (int l = 0; l < order; ++l) {
        const double q = std::sqrt((2.0 * l + 1.0) / (4.0 * pi));
        t.pole_forward[l] = static_cast<float>(q);
        t.pole_backward[l] = static_cast<float>(two_pi * scale * q);
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
