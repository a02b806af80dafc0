#include <alpenglow/sh/zonal.hpp>

#include <alpenglow/sh/gauss_legendre.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sh {
namespace {

double delta(int l) noexcept {
    return std::sqrt((2.0 * l + 1.0) / (4.0 * pi));
}

// 2 pi times the integral of falloff(u) Y_l0(z) over z from cos(angle) to 1, where u = (1 - z) / (1 - cos angle). Up to
// order 8 and linear falloff the integrand has degree 8: five nodes are exact, and nothing cancels for a small disc.
template <class Falloff>
void integrate_cap(int order, double angle_rad, std::span<double> zonal, Falloff&& falloff) noexcept {
    assert(order >= 1 && order <= max_order && zonal.size() >= static_cast<std::size_t>(order));
    assert(angle_rad >= 0.0 && angle_rad <= pi);
    static const auto nodes = [] {
        std::pair<std::vector<double>, std::vector<double>> n;
        gauss_legendre(5, n.first, n.second);
        return n;
    }();
    const double half = std::sin(0.5 * angle_rad);
    const double height = 2.0 * half * half; // 1 - cos(angle)
    std::fill_n(zonal.begin(), order, 0.0);
    for (std::size_t k = 0; k < nodes.first.size(); ++k) {
        const double u = 0.5 * (1.0 - nodes.first[k]);
        const double weight = pi * nodes.second[k] * height * falloff(u);
        const double z = 1.0 - height * u;
        double before = 0.0;
        double p = 1.0;
        for (int l = 0; l < order; ++l) {
            zonal[static_cast<std::size_t>(l)] += weight * delta(l) * p;
            const double next = ((2.0 * l + 1.0) * z * p - l * before) / (l + 1.0);
            before = p;
            p = next;
        }
    }
}

template <class Value, class Scale, class Direction>
void add(int order, std::span<const double> zonal, const Direction& axis, const Scale& scale,
         std::span<Value> out) noexcept {
    assert(order >= 1 && order <= max_order && zonal.size() >= static_cast<std::size_t>(order));
    assert(out.size() >= static_cast<std::size_t>(coefficient_count(order)));
    std::array<double, max_coefficients> y;
    evaluate_basis(order, glm::dvec3(axis), y);
    using Real = decltype(axis.x + axis.x);
    for (int l = 0; l < order; ++l) {
        const double factor = zonal[static_cast<std::size_t>(l)] / delta(l);
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            out[i] += scale * static_cast<Real>(factor * y[i]);
        }
    }
}

} // namespace

void zonal_delta(int order, std::span<double> zonal) noexcept {
    assert(order >= 1 && order <= max_order && zonal.size() >= static_cast<std::size_t>(order));
    for (int l = 0; l < order; ++l) {
        zonal[static_cast<std::size_t>(l)] = delta(l);
    }
}

void zonal_disc(int order, double angle_rad, std::span<double> zonal) noexcept {
    integrate_cap(order, angle_rad, zonal, [](double) { return 1.0; });
}

void zonal_cone(int order, double angle_rad, std::span<double> zonal) noexcept {
    integrate_cap(order, angle_rad, zonal, [](double u) { return 1.0 - u; });
}

void zonal_hemisphere(int order, double above, double below, std::span<double> zonal) noexcept {
    zonal_disc(order, 0.5 * pi, zonal);
    // Even bands but the mean vanish over a half; the odd ones change sign below.
    for (int l = 0; l < order; ++l) {
        double& z = zonal[static_cast<std::size_t>(l)];
        z *= l % 2 != 0 ? above - below : l == 0 ? above + below : 0.0;
    }
}

double disc_solid_angle(double angle_rad) noexcept {
    const double half = std::sin(0.5 * angle_rad);
    return 4.0 * pi * half * half;
}

void add_zonal(int order, std::span<const double> zonal, const glm::dvec3& axis, double scale,
               std::span<double> out) noexcept {
    add<double>(order, zonal, axis, scale, out);
}
void add_zonal(int order, std::span<const double> zonal, const glm::dvec3& axis, const glm::dvec3& scale,
               std::span<glm::dvec3> out) noexcept {
    add<glm::dvec3>(order, zonal, axis, scale, out);
}
void add_zonal(int order, std::span<const double> zonal, const glm::vec3& axis, const glm::vec3& scale,
               std::span<glm::vec3> out) noexcept {
    add<glm::vec3>(order, zonal, axis, scale, out);
}

void convolve(int order, std::span<const double> f, std::span<const double> h, std::span<double> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && f.size() >= count && out.size() >= count);
    assert(h.size() >= static_cast<std::size_t>(order));
    static_cast<void>(count);
    for (int l = 0; l < order; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            out[i] = f[i] * h[static_cast<std::size_t>(l)] / delta(l);
        }
    }
}

void convolution_factors(int order, std::span<const double> h, std::span<float> factors) noexcept {
    assert(h.size() >= static_cast<std::size_t>(order) && factors.size() >= static_cast<std::size_t>(order));
    for (int l = 0; l < order; ++l) {
        factors[static_cast<std::size_t>(l)] = static_cast<float>(h[static_cast<std::size_t>(l)] / delta(l));
    }
}

glm::dvec3 optimal_linear_direction(std::span<const double> f) noexcept {
    assert(f.size() >= 4);
    const double scale = std::max({std::abs(f[1]), std::abs(f[2]), std::abs(f[3])});
    // Scaled first, so that squares neither overflow nor vanish. A NaN fails the comparison.
    if (!(scale > 0.0) || !std::isfinite(f[1] + f[2] + f[3]) || !std::isfinite(1.0 / scale)) {
        return {0.0, 0.0, 1.0};
    }
    return glm::normalize(glm::dvec3(-f[3] / scale, -f[1] / scale, f[2] / scale));
}

glm::vec3 optimal_linear_direction(std::span<const float> f) noexcept {
    assert(f.size() >= 4);
    const std::array<double, 4> wide{f[0], f[1], f[2], f[3]};
    return glm::vec3(optimal_linear_direction(std::span<const double>(wide)));
}

} // namespace alpenglow::sh
