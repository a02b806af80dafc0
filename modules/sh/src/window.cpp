#include <alpenglow/sh/window.hpp>

#include <alpenglow/core/constants.hpp>

#include <cmath>

namespace alpenglow::sh {
namespace {

double sinc(double x) noexcept {
    return std::abs(x) < 1e-8 ? 1.0 : std::sin(x) / x;
}

template <class Real>
void apply(int order, std::span<const double> factors, std::span<const Real> in, std::span<Real> out) noexcept {
    assert(order >= 1 && order <= max_order && factors.size() >= static_cast<std::size_t>(order));
    assert(in.size() >= static_cast<std::size_t>(coefficient_count(order)) &&
           out.size() >= static_cast<std::size_t>(coefficient_count(order)));
    for (int l = 0; l < order; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            out[i] = in[i] * static_cast<Real>(factors[static_cast<std::size_t>(l)]);
        }
    }
}

} // namespace

void window_factors(Window window, double cutoff, int order, std::span<double> factors) noexcept {
    assert(order >= 1 && order <= max_order && factors.size() >= static_cast<std::size_t>(order) && cutoff > 0.0);
    for (int l = 0; l < order; ++l) {
        double& factor = factors[static_cast<std::size_t>(l)];
        const double u = l / cutoff;
        const double s = sinc(pi * u);
        switch (window) {
        case Window::none:
            factor = 1.0;
            continue;
        case Window::gauss:
            factor = std::exp(-u * (u + 1.0 / cutoff));
            continue;
        case Window::hann:
            factor = 0.5 * (1.0 + std::cos(pi * u));
            break;
        case Window::sinc:
            factor = s;
            break;
        case Window::sinc4:
            factor = s * s * s * s;
            break;
        }
        factor = l >= cutoff ? 0.0 : factor;
    }
    factors[0] = 1.0;
}

void lanczos_factors(double cutoff, double lobes, int order, std::span<double> factors) noexcept {
    assert(order >= 1 && order <= max_order && factors.size() >= static_cast<std::size_t>(order) && cutoff > 0.0);
    assert(lobes > 0.0);
    for (int l = 0; l < order; ++l) {
        const double x = pi * l / cutoff;
        factors[static_cast<std::size_t>(l)] = l > 0 && l >= cutoff ? 0.0 : sinc(x) * sinc(x / lobes);
    }
}

void apply_window(int order, std::span<const double> factors, std::span<const double> in,
                  std::span<double> out) noexcept {
    apply<double>(order, factors, in, out);
}
void apply_window(int order, std::span<const double> factors, std::span<const float> in,
                  std::span<float> out) noexcept {
    apply<float>(order, factors, in, out);
}

} // namespace alpenglow::sh
