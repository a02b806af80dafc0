// From spectra and chromaticities to the project's light: photometric linear Rec.709.
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Spectra are sampled every 10 nm from 380 nm to 780 nm.
inline constexpr std::size_t spectrum_samples = 41;
inline constexpr double spectrum_first_nm = 380.0;
inline constexpr double spectrum_step_nm = 10.0;
using Spectrum = std::array<double, spectrum_samples>;

// CIE 1931 2-degree colour matching functions (Wyszecki and Stiles 1982, table I(3.3.1)).
[[nodiscard]] const Spectrum& cie_x();
[[nodiscard]] const Spectrum& cie_y();
[[nodiscard]] const Spectrum& cie_z();

// Tristimulus values of a spectral radiance (W m^-2 sr^-1 nm^-1) or irradiance (W m^-2 nm^-1), Y in cd/m^2 or lux
// (683 lm/W at the peak).
[[nodiscard]] glm::dvec3 spectrum_to_xyz(const Spectrum& spectrum);

// Linear Rec.709 (white D65) with 0.2126 R + 0.7152 G + 0.0722 B = Y up to 3e-4 (the weights are rounded, the matrix
// is not; 3e-5 near white). Colours outside the gamut come out with negative components: see into_gamut.
[[nodiscard]] glm::dvec3 xyz_to_rec709(const glm::dvec3& xyz);
[[nodiscard]] glm::vec3 xyz_to_rec709(const glm::vec3& xyz);
// From luminance Y and chromaticity x, y; black where y is not above 1e-6.
[[nodiscard]] glm::dvec3 yxy_to_rec709(const glm::dvec3& Yxy);
[[nodiscard]] glm::vec3 yxy_to_rec709(const glm::vec3& Yxy);

[[nodiscard]] double luminance(const glm::dvec3& rgb);
[[nodiscard]] float luminance(const glm::vec3& rgb);

// The rule for colours out of gamut: mix with the white of equal luminance until the least component is 0, which keeps
// luminance and hue direction. Without positive luminance: black.
[[nodiscard]] glm::dvec3 into_gamut(const glm::dvec3& rgb);
[[nodiscard]] glm::vec3 into_gamut(const glm::vec3& rgb);

// Daylight of chromaticity (x, y) as a relative spectrum, 100 at 560 nm for most daylights: S0 + M1 S1 + M2 S2 (Judd,
// MacAdam, Wyszecki 1964; course 2003, "Preetham et al spectral radiance model"). Meant for chromaticities near the
// daylight locus; negative power far from it is set to 0, and the denominator is kept from 0.
[[nodiscard]] Spectrum daylight_spectrum(glm::dvec2 xy);

} // namespace alpenglow::sky
