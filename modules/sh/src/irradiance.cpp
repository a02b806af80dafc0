#include <alpenglow/sh/irradiance.hpp>

#include <alpenglow/core/constants.hpp>

#include <array>
#include <cmath>

namespace alpenglow::sh {
namespace {

template <class Real, class Value>
void scale_bands(int order, std::span<const Value> in, std::span<Value> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && in.size() >= count && out.size() >= count);
    static_cast<void>(count);
    for (int l = 0; l < order; ++l) {
        const Real factor = static_cast<Real>(cosine_factor(l));
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            out[i] = in[i] * factor;
        }
    }
}

// c1 .. c5 of eq. 12: A^_l times the constants of the basis.
const double c1 = 0.25 * pi * 0.25 * std::sqrt(15.0 / pi);
const double c2 = pi / 3.0 * 0.5 * std::sqrt(3.0 / pi);
const double c3 = 0.25 * pi * 0.75 * std::sqrt(5.0 / pi);
const double c4 = 0.5 * std::sqrt(pi);
const double c5 = 0.25 * pi * 0.25 * std::sqrt(5.0 / pi);

// The coefficients in the paper's signs: odd m flips.
template <class Real>
struct Paper {
    Real L00, L1m1, L10, L11, L2m2, L2m1, L20, L21, L22;
    explicit Paper(std::span<const Real> L)
        : L00(L[0]), L1m1(-L[1]), L10(L[2]), L11(-L[3]), L2m2(L[4]), L2m1(-L[5]), L20(L[6]), L21(-L[7]), L22(L[8]) {}
};

template <class Real, class Matrix>
Matrix quadratic_form(std::span<const Real> radiance) noexcept {
    assert(radiance.size() >= 9);
    const Paper<Real> L(radiance);
    const Real k1 = static_cast<Real>(c1), k2 = static_cast<Real>(c2), k3 = static_cast<Real>(c3),
               k4 = static_cast<Real>(c4), k5 = static_cast<Real>(c5);
    return {k1 * L.L22,  k1 * L.L2m2, k1 * L.L21,  k2 * L.L11,
            k1 * L.L2m2, -k1 * L.L22, k1 * L.L2m1, k2 * L.L1m1,
            k1 * L.L21,  k1 * L.L2m1, k3 * L.L20,  k2 * L.L10,
            k2 * L.L11,  k2 * L.L1m1, k2 * L.L10,  k4 * L.L00 - k5 * L.L20};
}

template <class Real, class Direction>
Real nine_terms(std::span<const Real> radiance, const Direction& n) noexcept {
    assert(radiance.size() >= 9);
    const Paper<Real> L(radiance);
    const Real k1 = static_cast<Real>(c1), k2 = static_cast<Real>(c2), k3 = static_cast<Real>(c3),
               k4 = static_cast<Real>(c4), k5 = static_cast<Real>(c5);
    return k1 * L.L22 * (n.x * n.x - n.y * n.y) + k3 * L.L20 * n.z * n.z + k4 * L.L00 - k5 * L.L20 +
           2 * k1 * (L.L2m2 * n.x * n.y + L.L21 * n.x * n.z + L.L2m1 * n.y * n.z) +
           2 * k2 * (L.L11 * n.x + L.L1m1 * n.y + L.L10 * n.z);
}

template <class Real>
void flip(int order, std::span<const Real> in, std::span<Real> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && in.size() >= count && out.size() >= count);
    static_cast<void>(count);
    for (int l = 0; l < order; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            out[i] = m % 2 != 0 ? -in[i] : in[i];
        }
    }
}

} // namespace

double cosine_factor(int l) noexcept {
    assert(l >= 0 && l < max_order);
    // Eq. 8 as fractions of pi.
    static constexpr std::array<double, max_order> over_pi{1.0,         2.0 / 3.0, 0.25,       0.0,
                                                           -1.0 / 24.0, 0.0,       1.0 / 64.0, 0.0};
    return pi * over_pi[static_cast<std::size_t>(l)];
}

void irradiance(int order, std::span<const double> radiance, std::span<double> out) noexcept {
    scale_bands<double>(order, radiance, out);
}
void irradiance(int order, std::span<const float> radiance, std::span<float> out) noexcept {
    scale_bands<float>(order, radiance, out);
}
void irradiance(int order, std::span<const glm::vec3> radiance, std::span<glm::vec3> out) noexcept {
    scale_bands<float>(order, radiance, out);
}
void irradiance(int order, std::span<const glm::dvec3> radiance, std::span<glm::dvec3> out) noexcept {
    scale_bands<double>(order, radiance, out);
}

glm::dmat4 irradiance_matrix(std::span<const double> radiance) noexcept {
    return quadratic_form<double, glm::dmat4>(radiance);
}
glm::mat4 irradiance_matrix(std::span<const float> radiance) noexcept {
    return quadratic_form<float, glm::mat4>(radiance);
}

double irradiance_nine_terms(std::span<const double> radiance, const glm::dvec3& normal) noexcept {
    return nine_terms<double>(radiance, normal);
}
float irradiance_nine_terms(std::span<const float> radiance, const glm::vec3& normal) noexcept {
    return nine_terms<float>(radiance, normal);
}

void flip_phase(int order, std::span<const double> in, std::span<double> out) noexcept {
    flip<double>(order, in, out);
}
void flip_phase(int order, std::span<const float> in, std::span<float> out) noexcept {
    flip<float>(order, in, out);
}

} // namespace alpenglow::sh
