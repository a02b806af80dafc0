// Functions with an axis: analytic projections of simple lights, convolution, and the direction of most light.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sh {

// Zonal coefficients z_0 .. z_(order-1) (those of m = 0) of functions about +Z. `zonal` holds `order` values.
//
// A punctual light of unit illuminance (lux on a surface that faces it): z_l = sqrt((2l+1) / 4 pi).
void zonal_delta(int order, std::span<double> zonal) noexcept;
// Unit radiance within `angle_rad` of the axis, 0 .. pi: the sun's or the moon's disc, a spherical light. Accurate to
// 1e-14 relative however small the disc; divide by disc_solid_angle times cos for a light of given illuminance.
void zonal_disc(int order, double angle_rad, std::span<double> zonal) noexcept;
// Radiance that falls from 1 on the axis linearly in the cosine to 0 at `angle_rad`, 0 .. pi: a soft spot.
void zonal_cone(int order, double angle_rad, std::span<double> zonal) noexcept;
// Radiance `above` for z > 0, `below` for z < 0: sky and ground.
void zonal_hemisphere(int order, double above, double below, std::span<double> zonal) noexcept;

// 2 pi (1 - cos angle), without cancellation.
[[nodiscard]] double disc_solid_angle(double angle_rad) noexcept;

// Turns a zonal function from +Z to the unit direction `axis` and adds it to `out`, times `scale`:
// out_lm += scale sqrt(4 pi / (2l+1)) z_l Y_lm(axis).
void add_zonal(int order, std::span<const double> zonal, const glm::dvec3& axis, double scale,
               std::span<double> out) noexcept;
void add_zonal(int order, std::span<const double> zonal, const glm::dvec3& axis, const glm::dvec3& scale,
               std::span<glm::dvec3> out) noexcept;
void add_zonal(int order, std::span<const double> zonal, const glm::vec3& axis, const glm::vec3& scale,
               std::span<glm::vec3> out) noexcept;

// Convolution with a zonal kernel, Sloan 2017 eq. 2: out_lm = sqrt(4 pi / (2l+1)) h_l f_lm. In place is fine.
void convolve(int order, std::span<const double> f, std::span<const double> h, std::span<double> out) noexcept;
// The same as factors of bands, for scale_bands and windows: factors[l] = sqrt(4 pi / (2l+1)) h_l.
void convolution_factors(int order, std::span<const double> h, std::span<float> factors) noexcept;

// The optimal linear direction (-f_3, -f_1, f_2), unit (Sloan 2017, section 2.2). +Z where the linear band is zero or
// not finite. Weigh the channels first to find it for a colour.
[[nodiscard]] glm::dvec3 optimal_linear_direction(std::span<const double> f) noexcept;
[[nodiscard]] glm::vec3 optimal_linear_direction(std::span<const float> f) noexcept;

} // namespace alpenglow::sh
