#include <alpenglow/sh/basis.hpp>

#include "tables.hpp"

#include <array>

namespace alpenglow::sh {
namespace {

template <class Real>
void basis(int order, Real x, Real y, Real z, Real* out) noexcept {
    const detail::BasisTables& t = detail::basis_tables;
    Real re = 1; // (-(x + iy))^m
    Real im = 0;
    for (int m = 0; m < order; ++m) {
        Real before = 0;
        Real q = static_cast<Real>(t.seed[m]);
        for (int l = m; l < order; ++l) {
            if (l > m) {
                const Real next = static_cast<Real>(t.a[l][m]) * z * q - static_cast<Real>(t.b[l][m]) * before;
                before = q;
                q = next;
            }
            out[index(l, m)] = q * re;
            if (m > 0) {
                out[index(l, -m)] = q * im;
            }
        }
        const Real turned = y * im - x * re;
        im = -(x * im + y * re);
        re = turned;
    }
}

template <class Real, class Value, class Direction>
Value dot_basis(int order, std::span<const Value> coefficients, const Direction& d) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && coefficients.size() >= count);
    std::array<Real, max_coefficients> y;
    basis<Real>(order, d.x, d.y, d.z, y.data());
    Value sum = coefficients[0] * y[0];
    for (std::size_t i = 1; i < count; ++i) {
        sum += coefficients[i] * y[i];
    }
    return sum;
}

} // namespace

void evaluate_basis(int order, const glm::dvec3& d, std::span<double> out) noexcept {
    assert(order >= 1 && order <= max_order && out.size() >= static_cast<std::size_t>(coefficient_count(order)));
    basis<double>(order, d.x, d.y, d.z, out.data());
}

void evaluate_basis(int order, const glm::vec3& d, std::span<float> out) noexcept {
    assert(order >= 1 && order <= max_order && out.size() >= static_cast<std::size_t>(coefficient_count(order)));
    basis<float>(order, d.x, d.y, d.z, out.data());
}

double evaluate(int order, std::span<const double> coefficients, const glm::dvec3& direction) noexcept {
    return dot_basis<double>(order, coefficients, direction);
}
float evaluate(int order, std::span<const float> coefficients, const glm::vec3& direction) noexcept {
    return dot_basis<float>(order, coefficients, direction);
}
glm::vec3 evaluate(int order, std::span<const glm::vec3> coefficients, const glm::vec3& direction) noexcept {
    return dot_basis<float>(order, coefficients, direction);
}
glm::dvec3 evaluate(int order, std::span<const glm::dvec3> coefficients, const glm::dvec3& direction) noexcept {
    return dot_basis<double>(order, coefficients, direction);
}

} // namespace alpenglow::sh
