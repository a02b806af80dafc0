#include "quadratic.hpp"

#include "tables.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace alpenglow::sh::detail {

Quadratic diagonalise(std::span<const double> f) noexcept {
    // Y_0, Y_1, Y_2 as in eq. 3 to 5 of the deringing paper: k0, k1 n, and the quadratic forms below.
    const double k0 = basis_tables.poly[0][0][0], k1 = basis_tables.poly[1][0][0], k2 = basis_tables.seed[2];
    const double k20 = -basis_tables.poly[2][0][0]; // Y_2^0 = k20 (2 z^2 - x^2 - y^2)
    Quadratic q;
    q.c = k0 * f[0];
    double b[3] = {-k1 * f[3], -k1 * f[1], k1 * f[2]};
    double a[3][3];
    a[0][0] = -k20 * f[6] + k2 * f[8];
    a[1][1] = -k20 * f[6] - k2 * f[8];
    a[2][2] = 2.0 * k20 * f[6];
    a[0][1] = a[1][0] = k2 * f[4];
    a[1][2] = a[2][1] = -k2 * f[5];
    a[0][2] = a[2][0] = -k2 * f[7];
    // Cyclic Jacobi: three angles a sweep, quadratically convergent, accurate for equal eigenvalues too.
    for (int sweep = 0; sweep < 12; ++sweep) {
        const double off = std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]);
        const double on = std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]);
        if (off <= 1e-17 * on || off == 0.0) {
            break;
        }
        for (int p = 0; p < 2; ++p) {
            for (int r = p + 1; r < 3; ++r) {
                const double gap = a[r][r] - a[p][p];
                const double twice = 2.0 * a[p][r];
                const double length = std::abs(gap) + std::hypot(gap, twice);
                if (length == 0.0 || twice == 0.0) {
                    continue;
                }
                const double t = std::copysign(1.0, gap) * twice / length;
                const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
                const int o = 3 - p - r;
                a[p][p] -= t * a[p][r];
                a[r][r] += t * a[p][r];
                a[p][r] = a[r][p] = 0.0;
                const double op = a[o][p], orr = a[o][r];
                a[o][p] = a[p][o] = c * op - s * orr;
                a[o][r] = a[r][o] = s * op + c * orr;
                const double bp = b[p];
                b[p] = c * bp - s * b[r];
                b[r] = s * bp + c * b[r];
                for (int k = 0; k < 3; ++k) {
                    const double vp = q.axes[p][k];
                    q.axes[p][k] = c * vp - s * q.axes[r][k];
                    q.axes[r][k] = s * vp + c * q.axes[r][k];
                }
            }
        }
    }
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int i, int j) { return a[i][i] < a[j][j]; });
    const Quadratic unsorted = q;
    for (int i = 0; i < 3; ++i) {
        q.beta[i] = b[order[i]];
        q.lambda[i] = a[order[i]][order[i]];
        std::copy_n(unsorted.axes[order[i]], 3, q.axes[i]);
    }
    return q;
}

QuadraticMinimum minimise(const Quadratic& q, double w1, double w2) noexcept {
    // Stationary points have (lambda_i - mu) n_i = -beta_i / 2; the global minimum is the one with mu <= lambda_1. With
    // nu = lambda_1 - mu >= 0 and gaps g_i = lambda_i - lambda_1: sum b_i^2 / (g_i + nu)^2 = 1.
    double b[3], g[3];
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        b[i] = 0.5 * w1 * q.beta[i];
        g[i] = w2 * (q.lambda[i] - q.lambda[0]);
        largest = std::max({largest, std::abs(b[i]), g[i]});
    }
    QuadraticMinimum m;
    m.dual = q.c + w2 * q.lambda[0];
    if (!(largest > 0.0)) {
        m.n[0] = 1.0;
        return m;
    }
    // Scaled to 1: squares neither overflow nor vanish.
    for (int i = 0; i < 3; ++i) {
        b[i] /= largest;
        g[i] /= largest;
    }
    double nu = 0.0;
    for (int i = 0; i < 3; ++i) {
        nu = std::max(nu, std::abs(b[i]) - g[i]);
    }
    // Newton on 1 / |n| - 1, which is nearly linear and concave: from the left of the root it never passes it.
    for (int iteration = 0; iteration < 50; ++iteration) {
        double n2 = 0.0, slope = 0.0;
        for (int i = 0; i < 3; ++i) {
            const double gap = g[i] + nu;
            if (gap > 0.0) {
                const double n = b[i] / gap;
                n2 += n * n;
                slope += n * n / gap;
            }
        }
        if (n2 <= 1.0 || slope <= 0.0) {
            break; // the root, or the hard case: beta has nothing along the lowest axes, and nu = 0
        }
        const double step = n2 * (std::sqrt(n2) - 1.0) / slope;
        nu += step;
        if (step <= 1e-16 * nu) {
            break;
        }
    }
    double rest = 1.0;
    double loss = nu;
    for (int i = 2; i >= 0; --i) {
        const double gap = g[i] + nu;
        m.n[i] = gap > 0.0 ? -b[i] / gap : 0.0;
        loss += gap > 0.0 ? b[i] * b[i] / gap : 0.0;
        rest -= m.n[i] * m.n[i];
    }
    m.dual -= largest * loss;
    if (rest > 1e-14) { // the hard case: the lowest axis takes what is missing
        m.n[0] = std::copysign(std::sqrt(m.n[0] * m.n[0] + rest), m.n[0]);
    }
    const double length = std::sqrt(m.n[0] * m.n[0] + m.n[1] * m.n[1] + m.n[2] * m.n[2]);
    for (double& n : m.n) {
        n /= length;
    }
    return m;
}

} // namespace alpenglow::sh::detail
