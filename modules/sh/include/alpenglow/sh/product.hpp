// Products of two functions given by coefficients: h = f g, projected again on bands.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace alpenglow::sh {

// integral of Y_i Y_j Y_k over the sphere, for i <= j <= k, zeros left out.
struct GauntEntry {
    std::uint8_t i, j, k;
    double value;
};

// The sparse table of one order, made on first use by a quadrature that is exact for these integrands (error 1e-15) and
// kept. Safe to call from several threads.
[[nodiscard]] std::span<const GauntEntry> gaunt_table(int order);

// out = the projection of f g on the bands below `order`: out_k = sum_ij G_ijk f_i g_j. Exact where f g has no higher
// bands; otherwise the rest, bands order .. 2 order - 2, is cut off. out must not overlap f or g.
void product(int order, std::span<const double> f, std::span<const double> g, std::span<double> out) noexcept;
void product(int order, std::span<const float> f, std::span<const float> g, std::span<float> out) noexcept;

// The matrix of "multiply by f", row-major order^2 x order^2, symmetric: product(f, g) = matrix g. For one f and many
// g.
void product_matrix(int order, std::span<const double> f, std::span<double> matrix) noexcept;

// integral of f g h over the sphere.
[[nodiscard]] double triple_product(int order, std::span<const double> f, std::span<const double> g,
                                    std::span<const double> h) noexcept;

} // namespace alpenglow::sh
