// One coefficient vector in many directions.
#pragma once

#include "tables.hpp"

namespace alpenglow::sh::detail {

// The coefficients of each m folded into polynomials in z: f = sum_m cosine_m(z) Re (-(x + iy))^m + sine_m(z) Im.
// Degrees stay low enough for float up to order 6.
struct Folded {
    float cosine[max_order][max_order]; // [m][power of z]
    float sine[max_order][max_order];

    Folded(int order, const float* f) noexcept {
        for (int m = 0; m < order; ++m) {
            double c[max_order] = {}, s[max_order] = {};
            for (int l = m; l < order; ++l) {
                for (int k = 0, power = (l - m) % 2; power <= l - m; ++k, power += 2) {
                    c[power] += basis_tables.poly[l][m][k] * static_cast<double>(f[index(l, m)]);
                    s[power] += basis_tables.poly[l][m][k] * static_cast<double>(f[index(l, -m)]);
                }
            }
            for (int power = 0; power < order - m; ++power) {
                cosine[m][power] = static_cast<float>(c[power]);
                sine[m][power] = static_cast<float>(s[power]);
            }
        }
    }
};

} // namespace alpenglow::sh::detail
