// The dome models of the papers behind one interface: luminance as a sum of at most two terms, chromaticity after
// Preetham.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/preetham.hpp>

#include <array>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

enum class DomeModel {
    preetham,     // Preetham, Shirley and Smits 1999: from turbidity
    perez,        // Perez, Seals and Michalsky 1993, all-weather: from clearness and brightness
    cie_clear,    // CIE 1973, Kittler: from turbidity
    cie_overcast, // Moon and Spencer 1942, CIE
    asrc_cie,   // Perez et al. 1990, Littlefair 1994: overcast, intermediate, hazy and clear sky, blended by clearness
    cie_general // CIE S 011 / ISO 15469:2003, types 1 to 15
};

struct DomeParameters {
    DomeModel model = DomeModel::preetham;
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F}; // unit; below the horizon it is held at the horizon
    float turbidity = 2.5F;             // 1.7 .. 10: of the clear models' luminance, and of every model's chromaticity
    float clearness = 6.0F;             // Perez' epsilon, 1 (overcast) .. 12 and more (clear)
    float brightness = 0.2F;            // Perez' delta, 0.01 .. 0.6; of asrc_cie below clearness 1.2
    int cie_type = 12;                  // 1 .. 15
    // Luminance of the zenith in cd/m^2 where it is known; 0: the model's own formula (docs/sky.md).
    float zenith_cd_m2 = 0.0F;
};

// Names the parameter that is out of range, if one is.
[[nodiscard]] Status check(const DomeParameters& parameters);

// One product: scale (g0 + g1 cos theta + a e^(b / cos theta)) (s0 + c e^(d gamma) + e cos^2 gamma), or Nakamura's
// intermediate sky, which has no such form.
template <class Real>
struct DomeTerm {
    Real scale = 0;
    Real g0 = 1, g1 = 0, a = 0, b = -1;
    Real s0 = 1, c = 0, d = -1, e = 0;
    bool intermediate = false;
};

template <class Real>
struct SkyDome {
    glm::vec<3, Real> to_sun;
    std::array<DomeTerm<Real>, 2> luminance;             // the second may have scale 0
    std::array<PerezCoefficients<Real>, 2> chromaticity; // of x, y
    glm::vec<2, Real> zenith_xy;                         // over F(0, theta_sun)
    Real grey = 0;                                       // 0: that chromaticity, 1: overcast's (D65)
};

// `parameters` have passed check(). float or double.
template <class Real>
[[nodiscard]] SkyDome<Real> make_dome(const DomeParameters& parameters);

// Luminance, chromaticity and radiance towards a unit vector, as luminance_chromaticity and radiance of Preetham's sky:
// cd/m^2, never negative, in gamut; below the horizon the horizon's.
template <class Real>
[[nodiscard]] glm::vec<3, Real> luminance_chromaticity(const SkyDome<Real>& dome, const glm::vec<3, Real>& direction);
template <class Real>
[[nodiscard]] glm::vec<3, Real> radiance(const SkyDome<Real>& dome, const glm::vec<3, Real>& direction);

// The spectrum towards a direction, W m^-2 sr^-1 nm^-1: daylight of its chromaticity, scaled to its luminance.
[[nodiscard]] Spectrum spectral_radiance(const SkyDome<double>& dome, const glm::dvec3& direction);

// Many directions at once, structure of arrays, with the widest SIMD at hand. All spans have the same length. Relative
// error against the double path, of the colour's norm: Preetham 1e-5, others 1e-4 (where a gradation nearly cancels).
struct Directions {
    std::span<const float> x, y, z;
};
struct Radiances {
    std::span<float> r, g, b;
};
void radiance(const SkyDome<float>& dome, const Directions& directions, const Radiances& out);

extern template SkyDome<float> make_dome(const DomeParameters&);
extern template SkyDome<double> make_dome(const DomeParameters&);
extern template glm::vec3 luminance_chromaticity(const SkyDome<float>&, const glm::vec3&);
extern template glm::dvec3 luminance_chromaticity(const SkyDome<double>&, const glm::dvec3&);
extern template glm::vec3 radiance(const SkyDome<float>&, const glm::vec3&);
extern template glm::dvec3 radiance(const SkyDome<double>&, const glm::dvec3&);

} // namespace alpenglow::sky
