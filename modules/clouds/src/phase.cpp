#include <alpenglow/clouds/phase.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace alpenglow::clouds {
namespace {

constexpr float inverse_four_pi = static_cast<float>(0.25 / pi);

float held(float g) {
    return std::clamp(g, -1.0F + 1e-6F, 1.0F - 1e-6F);
}

// (1 - g)^2 + 2 g (1 - cos) instead of 1 + g^2 - 2 g cos, which cancels to 0 near g = 1. For g < 0 the same about -1.
float denominator(float g, float one_minus_cos) {
    return g >= 0.0F ? (1.0F - g) * (1.0F - g) + 2.0F * g * one_minus_cos
                     : (1.0F + g) * (1.0F + g) - 2.0F * g * std::max(0.0F, 2.0F - one_minus_cos);
}

float henyey_greenstein(float g, float one_minus_cos) {
    g = held(g);
    const float d = denominator(g, one_minus_cos);
    return inverse_four_pi * (1.0F - g) * (1.0F + g) / (d * std::sqrt(d));
}

float sample_henyey_greenstein(float g, float u) {
    g = held(g);
    if (std::abs(g) < 1e-3F) {
        const float s = 2.0F * u - 1.0F;
        return std::clamp(s + 1.5F * g * (1.0F - s * s), -1.0F, 1.0F); // the inverse to first order in g
    }
    const float s = (1.0F - g * g) / (1.0F - g + 2.0F * g * u);
    return std::clamp((1.0F + g * g - s * s) / (2.0F * g), -1.0F, 1.0F);
}

// The real root of the Rayleigh phase function's cumulative distribution.
float sample_rayleigh(float u) {
    const float b = 4.0F * u - 2.0F;
    const float a = std::cbrt(b + std::sqrt(b * b + 1.0F));
    return std::clamp(a - 1.0F / a, -1.0F, 1.0F);
}

} // namespace

float phase_value(const Phase& phase, float one_minus_cos) {
    switch (phase.kind) {
    case PhaseKind::henyey_greenstein:
        return henyey_greenstein(phase.g, one_minus_cos);
    case PhaseKind::double_henyey_greenstein:
        return phase.weight * henyey_greenstein(phase.g, one_minus_cos) +
               (1.0F - phase.weight) * henyey_greenstein(phase.g2, one_minus_cos);
    case PhaseKind::cornette_shanks: {
        const float c = 1.0F - one_minus_cos;
        return henyey_greenstein(phase.g, one_minus_cos) * 1.5F * (1.0F + c * c) / (2.0F + phase.g * phase.g);
    }
    case PhaseKind::rayleigh: {
        const float c = 1.0F - one_minus_cos;
        return inverse_four_pi * 0.75F * (1.0F + c * c);
    }
    }
    return inverse_four_pi;
}

float sample_phase_cos(const Phase& phase, float u) {
    switch (phase.kind) {
    case PhaseKind::henyey_greenstein:
        return sample_henyey_greenstein(phase.g, u);
    case PhaseKind::double_henyey_greenstein:
        return u < phase.weight
                   ? sample_henyey_greenstein(phase.g, u / phase.weight)
                   : sample_henyey_greenstein(phase.g2, std::min((u - phase.weight) / (1.0F - phase.weight), 1.0F));
    case PhaseKind::cornette_shanks: {
        // Newton within a bracket on the cumulative distribution, started at HG's cosine.
        const double g = held(phase.g);
        const double norm = 1.5 / (2.0 + g * g);
        double low = -1.0;
        double high = 1.0;
        double c = sample_henyey_greenstein(phase.g, u);
        // F(c) = norm * integral over -1..c of (1 + x^2) (1 - g^2) / (2 (1 + g^2 - 2 g x)^1.5); substitute
        // s = sqrt(1 + g^2 - 2 g x), x = (1 + g^2 - s^2) / (2 g).
        const auto antiderivative = [&](double x) {
            if (std::abs(g) < 1e-2) { // series in g, to second order
                return 0.5 * (x + x * x * x / 3.0) + 1.5 * g * (x * x / 2.0 + x * x * x * x / 4.0) * 1.0;
            }
            const double a = 1.0 + g * g;
            const double s = std::sqrt(std::max(1e-300, a - 2.0 * g * x));
            // dx = -(s / g) ds; integrand (1 - g^2)/2 * (1 + x^2) / s^3 * (-(s/g)) ds
            const double q = 1.0 / (4.0 * g * g);
            const double poly = -1.0 / s * (1.0 + a * a * q) - 2.0 * a * q * s + q * s * s * s / 3.0;
            return -(1.0 - g * g) / (2.0 * g) * poly;
        };
        const double bottom = antiderivative(-1.0);
        const double total = antiderivative(1.0) - bottom;
        for (int i = 0; i < 30; ++i) {
            const double value = (antiderivative(c) - bottom) / total - double(u);
            (value > 0.0 ? high : low) = c;
            const double d = std::max(1e-300, 1.0 + g * g - 2.0 * g * c);
            const double slope = norm * (1.0 + c * c) * (1.0 - g * g) / (2.0 * d * std::sqrt(d));
            double next = c - value / slope;
            if (!(next > low && next < high)) {
                next = 0.5 * (low + high);
            }
            if (std::abs(next - c) < 1e-7) {
                c = next;
                break;
            }
            c = next;
        }
        return static_cast<float>(std::clamp(c, -1.0, 1.0));
    }
    case PhaseKind::rayleigh:
        return sample_rayleigh(u);
    }
    return 2.0F * u - 1.0F;
}

void phase_moments(const Phase& phase, std::span<double> moments) {
    const auto henyey = [](double g, std::size_t l) { return std::pow(g, static_cast<double>(l)); };
    const double g = held(phase.g);
    for (std::size_t l = 0; l < moments.size(); ++l) {
        switch (phase.kind) {
        case PhaseKind::henyey_greenstein:
            moments[l] = henyey(g, l);
            break;
        case PhaseKind::double_henyey_greenstein:
            moments[l] = double(phase.weight) * henyey(g, l) + (1.0 - double(phase.weight)) * henyey(held(phase.g2), l);
            break;
        case PhaseKind::cornette_shanks: {
            // mu^2 P_l = a P_(l+2) + b P_l + c P_(l-2): multiply HG by 1.5 (1 + mu^2) / (2 + g^2).
            const auto n = static_cast<double>(l);
            const double up = (n + 1.0) * (n + 2.0) / ((2.0 * n + 1.0) * (2.0 * n + 3.0));
            const double same = (n + 1.0) * (n + 1.0) / ((2.0 * n + 1.0) * (2.0 * n + 3.0)) +
                                (l > 0 ? n * n / ((2.0 * n + 1.0) * (2.0 * n - 1.0)) : 0.0);
            const double down = l > 1 ? n * (n - 1.0) / ((2.0 * n + 1.0) * (2.0 * n - 1.0)) : 0.0;
            const double below = l > 1 ? down * henyey(g, l - 2) : 0.0;
            moments[l] = 1.5 / (2.0 + g * g) * (henyey(g, l) * (1.0 + same) + up * henyey(g, l + 2) + below);
            break;
        }
        case PhaseKind::rayleigh:
            moments[l] = l == 0 ? 1.0 : (l == 2 ? 0.1 : 0.0);
            break;
        }
    }
}

} // namespace alpenglow::clouds
