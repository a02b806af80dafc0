// Constants of the basis, computed at compile time in double.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <numbers>

namespace alpenglow::sh::detail {

// Newton from above; exact to the last bit or two, which is all the tables need.
constexpr double constexpr_sqrt(double x) {
    double r = x > 1.0 ? x : 1.0;
    if (x <= 0.0) {
        return 0.0;
    }
    for (int i = 0; i < 64; ++i) {
        const double next = 0.5 * (r + x / r);
        if (next >= r) {
            break;
        }
        r = next;
    }
    return r;
}

// Y_l^m = Q_l^m(z) * (m > 0: Re, m < 0: Im of (-(x + iy))^|m|); the minus sign is the Condon-Shortley phase.
//   Q_m^m = seed[m]
//   Q_l^m = a[l][m] z Q_{l-1}^m - b[l][m] Q_{l-2}^m
struct BasisTables {
    double seed[max_order] = {};
    double a[max_order][max_order] = {};
    double b[max_order][max_order] = {};
    // Q_l^m = z^((l-m) mod 2) * sum_k poly[l][m][k] z^(2k)
    double poly[max_order][max_order][max_order / 2] = {};
};

constexpr BasisTables make_basis_tables() {
    BasisTables t;
    // Q_m^m / Q_{m-1}^{m-1} = sqrt((2m+1) / (2m)); the pair m, -m carries a factor sqrt(2) from m = 1 on.
    double seed_squared = 0.25 * std::numbers::inv_pi;
    for (int m = 0; m < max_order; ++m) {
        if (m > 0) {
            seed_squared *= (2.0 * m + 1.0) / (2.0 * m) * (m == 1 ? 2.0 : 1.0);
        }
        t.seed[m] = constexpr_sqrt(seed_squared);
        for (int l = m + 1; l < max_order; ++l) {
            const double l2 = static_cast<double>(l) * l;
            const double m2 = static_cast<double>(m) * m;
            const double k2 = (l - 1.0) * (l - 1.0);
            t.a[l][m] = constexpr_sqrt((4.0 * l2 - 1.0) / (l2 - m2));
            t.b[l][m] = l == m + 1 ? 0.0 : t.a[l][m] * constexpr_sqrt((k2 - m2) / (4.0 * k2 - 1.0));
        }
        t.poly[m][m][0] = t.seed[m];
        for (int l = m + 1; l < max_order; ++l) {
            const bool even = (l - m) % 2 == 0;
            for (int k = 0; k < max_order / 2; ++k) {
                // Multiplying by z turns the odd polynomial's power k into the even one's k + 1.
                const double raised = even ? (k > 0 ? t.poly[l - 1][m][k - 1] : 0.0) : t.poly[l - 1][m][k];
                t.poly[l][m][k] = t.a[l][m] * raised - (l > m + 1 ? t.b[l][m] * t.poly[l - 2][m][k] : 0.0);
            }
        }
    }
    return t;
}

inline constexpr BasisTables basis_tables = make_basis_tables();

} // namespace alpenglow::sh::detail
