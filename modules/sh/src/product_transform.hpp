// Tables that take coefficients to Fourier series on circles of latitude and back, for products.
#pragma once

#include <alpenglow/sh/basis.hpp>

namespace alpenglow::sh::detail {

// Gauss-Lobatto nodes in z: at the poles only m = 0 is not zero, so that they cost next to nothing, and one circle less
// is needed between them.
struct ProductTransform {
    static constexpr int max_circles = 5; // pairs z, -z and a circle at z = 0
    static constexpr int max_terms = max_order * (max_order + 1) / 2;
    int pairs = 0;
    bool middle = false; // then circle `pairs` is the one at z = 0
    // For m = 0 .. order-1, l = m .. order-1: the factor of coefficients (l, +-m) in the Fourier coefficients of exp(i
    // m phi) at the northern circle, and back.
    float forward[max_circles][max_terms] = {};
    float backward[max_circles][max_terms] = {};
    // The same at the north pole, m = 0.
    float pole_forward[max_order] = {};
    float pole_backward[max_order] = {};
};

// Exact for products cut at the same order. Made on first use, order 1 .. max_order.
[[nodiscard]] const ProductTransform& product_transform(int order);

} // namespace alpenglow::sh::detail
