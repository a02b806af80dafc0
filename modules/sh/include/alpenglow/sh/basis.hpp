// Real orthonormal spherical harmonics: the basis, its index, and the value of a coefficient vector in a direction.
//
// Signs are those of Sloan, "Deringing Spherical Harmonics" (2017), eq. 1, which keeps the Condon-Shortley phase:
//   Y_1^-1 = -0.4886 y   Y_1^0 = 0.4886 z   Y_1^1 = -0.4886 x      in general (-1)^m times the basis without phase.
// "Order" n means bands 0 .. n-1, n*n coefficients; the coefficient of band l and function m stands at l(l+1)+m.
// The zonal axis is +Z. This is the scalar path and the reference; batch.hpp has the vectorised one.
#pragma once

#include <cassert>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sh {

inline constexpr int max_order = 8;
inline constexpr int max_coefficients = max_order * max_order;

[[nodiscard]] constexpr int coefficient_count(int order) noexcept {
    return order * order;
}
[[nodiscard]] constexpr int index(int l, int m) noexcept {
    return l * (l + 1) + m;
}

// The basis functions of bands 0 .. order-1 in a unit direction: out[index(l, m)] = Y_l^m(direction).
// order 1 .. max_order; out holds at least order*order values. Absolute error: double 2e-15, float 8e-7 at order 6
// (1.3e-7 at order 3), over all directions. A direction of length other than 1 gives other values, without a warning.
void evaluate_basis(int order, const glm::dvec3& direction, std::span<double> out) noexcept;
void evaluate_basis(int order, const glm::vec3& direction, std::span<float> out) noexcept;

// sum_i coefficients[i] Y_i(direction). `coefficients` holds order*order values or more.
[[nodiscard]] double evaluate(int order, std::span<const double> coefficients, const glm::dvec3& direction) noexcept;
[[nodiscard]] float evaluate(int order, std::span<const float> coefficients, const glm::vec3& direction) noexcept;
[[nodiscard]] glm::vec3 evaluate(int order, std::span<const glm::vec3> coefficients,
                                 const glm::vec3& direction) noexcept;
[[nodiscard]] glm::dvec3 evaluate(int order, std::span<const glm::dvec3> coefficients,
                                  const glm::dvec3& direction) noexcept;

} // namespace alpenglow::sh
