// Irradiance from radiance coefficients. Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance
// Environment Maps" (2001).
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <span>

#include <glm/mat4x4.hpp>

namespace alpenglow::sh {

// A^_l of eq. 8: the factor of band l when radiance is convolved with the clamped cosine. pi, 2 pi / 3, pi / 4, 0,
// -pi / 24, 0, pi / 64, 0 for l = 0 .. 7.
[[nodiscard]] double cosine_factor(int l) noexcept;

// Irradiance coefficients (eq. 7): out_lm = A^_l in_lm. Radiance in cd/m^2 gives irradiance in lux. In place is fine.
// Cutting at order 3 leaves at most 9 % of the total light in any direction (the paper, section 3.1), at order 5 3.6 %.
void irradiance(int order, std::span<const double> radiance, std::span<double> out) noexcept;
void irradiance(int order, std::span<const float> radiance, std::span<float> out) noexcept;
void irradiance(int order, std::span<const glm::vec3> radiance, std::span<glm::vec3> out) noexcept;
void irradiance(int order, std::span<const glm::dvec3> radiance, std::span<glm::dvec3> out) noexcept;

// The symmetric matrix M of eq. 12 from nine radiance coefficients of one channel, with E(n) = (n, 1)^T M (n, 1),
// eq. 11. The constants c1 .. c5 are exact, where the paper prints six digits.
[[nodiscard]] glm::dmat4 irradiance_matrix(std::span<const double> radiance) noexcept;
[[nodiscard]] glm::mat4 irradiance_matrix(std::span<const float> radiance) noexcept;

// Eq. 13, the nine terms written out: E at the unit normal.
[[nodiscard]] double irradiance_nine_terms(std::span<const double> radiance, const glm::dvec3& normal) noexcept;
[[nodiscard]] float irradiance_nine_terms(std::span<const float> radiance, const glm::vec3& normal) noexcept;

// Converts between our signs and the basis without Condon-Shortley phase (Ramamoorthi's tables, three.js, Filament's
// shaders): multiplies by (-1)^m. Its own inverse; in place is fine.
void flip_phase(int order, std::span<const double> in, std::span<double> out) noexcept;
void flip_phase(int order, std::span<const float> in, std::span<float> out) noexcept;

} // namespace alpenglow::sh
