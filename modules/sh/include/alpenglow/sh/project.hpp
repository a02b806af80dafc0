// Projection on spherical harmonics: of a function by quadrature, and of weighted samples.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <functional>
#include <span>
#include <vector>

namespace alpenglow::sh {

// Directions (unit) and weights (steradians, summing to 4 pi).
struct SphereQuadrature {
    std::vector<glm::dvec3> directions;
    std::vector<double> weights;
};

// Gauss-Legendre in z times equal steps in azimuth: integrates every polynomial in x, y, z up to `degree` exactly
// (to 2e-13 relative), with about degree^2 / 2 points. Projecting a function of band limit L on bands below n needs
// degree L + n - 1. degree 0 .. 4000.
[[nodiscard]] SphereQuadrature sphere_quadrature(int degree);

// out[i] = sum_k weights[k] values[k] Y_i(directions[k]). All three spans of one length; out holds order*order values.
void project_samples(int order, std::span<const glm::dvec3> directions, std::span<const double> values,
                     std::span<const double> weights, std::span<double> out) noexcept;
void project_samples(int order, std::span<const glm::dvec3> directions, std::span<const glm::dvec3> values,
                     std::span<const double> weights, std::span<glm::dvec3> out) noexcept;

// Projects `function` (value per unit direction) with the quadrature given.
void project_function(int order, const SphereQuadrature& quadrature,
                      const std::function<double(const glm::dvec3&)>& function, std::span<double> out);
void project_function(int order, const SphereQuadrature& quadrature,
                      const std::function<glm::dvec3(const glm::dvec3&)>& function, std::span<glm::dvec3> out);

} // namespace alpenglow::sh
