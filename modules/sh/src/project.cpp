#include <alpenglow/sh/project.hpp>

#include <alpenglow/sh/gauss_legendre.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace alpenglow::sh {
namespace {

template <class Value>
void accumulate(int order, const glm::dvec3& direction, const Value& weighted, std::span<Value> out) noexcept {
    std::array<double, max_coefficients> y;
    evaluate_basis(order, direction, y);
    for (std::size_t i = 0; i < static_cast<std::size_t>(coefficient_count(order)); ++i) {
        out[i] += weighted * y[i];
    }
}

template <class Value>
void project_all(int order, std::span<const glm::dvec3> directions, std::span<const double> weights,
                 std::span<Value> out, auto&& value_at) {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && out.size() >= count && weights.size() == directions.size());
    std::fill_n(out.begin(), count, Value(0.0));
    for (std::size_t k = 0; k < directions.size(); ++k) {
        accumulate<Value>(order, directions[k], value_at(k) * weights[k], out);
    }
}

} // namespace

SphereQuadrature sphere_quadrature(int degree) {
    assert(degree >= 0 && degree <= 4000);
    std::vector<double> z;
    std::vector<double> z_weights;
    gauss_legendre(degree / 2 + 1, z, z_weights);
    const int azimuths = degree + 1;
    SphereQuadrature q;
    q.directions.reserve(z.size() * static_cast<std::size_t>(azimuths));
    q.weights.reserve(q.directions.capacity());
    for (std::size_t i = 0; i < z.size(); ++i) {
        const double r = std::sqrt((1.0 - z[i]) * (1.0 + z[i]));
        for (int j = 0; j < azimuths; ++j) {
            const double phi = two_pi * (j + 0.5) / azimuths;
            q.directions.emplace_back(r * std::cos(phi), r * std::sin(phi), z[i]);
            q.weights.push_back(z_weights[i] * two_pi / azimuths);
        }
    }
    return q;
}

void project_samples(int order, std::span<const glm::dvec3> directions, std::span<const double> values,
                     std::span<const double> weights, std::span<double> out) noexcept {
    assert(values.size() == directions.size());
    project_all<double>(order, directions, weights, out, [&](std::size_t k) { return values[k]; });
}

void project_samples(int order, std::span<const glm::dvec3> directions, std::span<const glm::dvec3> values,
                     std::span<const double> weights, std::span<glm::dvec3> out) noexcept {
    assert(values.size() == directions.size());
    project_all<glm::dvec3>(order, directions, weights, out, [&](std::size_t k) { return values[k]; });
}

void project_function(int order, const SphereQuadrature& q, const std::function<double(const glm::dvec3&)>& function,
                      std::span<double> out) {
    project_all<double>(order, q.directions, q.weights, out, [&](std::size_t k) { return function(q.directions[k]); });
}

void project_function(int order, const SphereQuadrature& q,
                      const std::function<glm::dvec3(const glm::dvec3&)>& function, std::span<glm::dvec3> out) {
    project_all<glm::dvec3>(order, q.directions, q.weights, out,
                            [&](std::size_t k) { return function(q.directions[k]); });
}

} // namespace alpenglow::sh
