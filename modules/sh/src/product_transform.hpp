// Tables that take coefficients to Fourier series on circles of latitude and back, for products.
#pragma once

#include <alpenglow/sh/basis.hpp>

namespace alpenglow::sh::detail {

struct ProductTransform {
    static constexpr int max_pairs = 6;
    static constexpr int max_terms = max_order * (max_order + 1) / 2;
    int pairs = 0; // of nodes z, -z; a node at z = 0 stands in its own pair, with its weight halved
    // For m = 0 .. order-1, l = m .. order-1: the factor of coefficients (l, +-m) in the Fourier coefficients of exp(i
    // m phi) at the pair's northern node, and back.
    float forward[max_pairs][max_terms] = {};
    float backward[max_pairs][max_terms] = {};
};

// Exact for products cut at the same order. Made on first use, order 1 .. max_order.
[[nodiscard]] const ProductTransform& product_transform(int order);

} // namespace alpenglow::sh::detail
