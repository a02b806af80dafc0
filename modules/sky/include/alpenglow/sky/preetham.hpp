// The clear-sky model of Preetham, Shirley and Smits 1999: luminance and chromaticity of the dome from the sun's
// direction and the turbidity.
#pragma once

#include <array>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Distribution coefficients of Perez et al. 1993: F = (1 + A e^(B / cos theta)) (1 + C e^(D gamma) + E cos^2 gamma).
template <class Real>
struct PerezCoefficients {
    Real a, b, c, d, e;
};

// The turbidity that the model answers for: below 1.7 its luminance term changes sign (1 + A e^B crosses zero at 1.64),
// above 10 the zenith luminance at sunset turns negative.
inline constexpr double preetham_min_turbidity = 1.7;
inline constexpr double preetham_max_turbidity = 10.0;

// The model for one sun and one turbidity. Real is float or double; double is the reference.
template <class Real>
struct PreethamSky {
    glm::vec<3, Real> to_sun;                     // unit, never below the horizon
    Real turbidity;                               // as used, after clamping
    std::array<PerezCoefficients<Real>, 3> perez; // of Y, x, y
    glm::vec<3, Real> zenith_Yxy;                 // cd/m^2, chromaticity
    glm::vec<3, Real> normalisation;              // F(0, theta_sun) of Y, x, y
    glm::vec<3, Real> scale;                      // zenith_Yxy / normalisation
};

// Turbidity is clamped to 1.7 .. 10 (NaN counts as 1.7). A sun below the horizon is moved up to the horizon in its own
// azimuth (towards north for a sun at the nadir): what happens after sunset is not the model's to say, see
// twilight.hpp. `to_sun` is a unit vector in the local frame, +Z the zenith.
template <class Real>
[[nodiscard]] PreethamSky<Real> make_preetham(const glm::vec<3, Real>& to_sun, Real turbidity);

// Luminance in cd/m^2 and chromaticity x, y towards a unit vector. Directions below the horizon get the radiance of the
// horizon above them. Accuracy of float against double: 2e-5 relative, over all directions, suns and turbidities.
template <class Real>
[[nodiscard]] glm::vec<3, Real> luminance_chromaticity(const PreethamSky<Real>& sky,
                                                       const glm::vec<3, Real>& direction);

// The same as linear Rec.709 in cd/m^2 within the gamut (into_gamut): finite and never negative.
template <class Real>
[[nodiscard]] glm::vec<3, Real> radiance(const PreethamSky<Real>& sky, const glm::vec<3, Real>& direction);

extern template PreethamSky<float> make_preetham(const glm::vec3&, float);
extern template PreethamSky<double> make_preetham(const glm::dvec3&, double);
extern template glm::vec3 luminance_chromaticity(const PreethamSky<float>&, const glm::vec3&);
extern template glm::dvec3 luminance_chromaticity(const PreethamSky<double>&, const glm::dvec3&);
extern template glm::vec3 radiance(const PreethamSky<float>&, const glm::vec3&);
extern template glm::dvec3 radiance(const PreethamSky<double>&, const glm::dvec3&);

} // namespace alpenglow::sky
