#include <alpenglow/sky/preetham.hpp>

#include "colour_of.hpp"
#include "fast_math.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

// B < -0.1 in the whole domain, so that e^(B / cos) is 0 to float precision at this cosine already.
constexpr double least_cosine = 1e-3;

template <class Real>
Real perez(const PerezCoefficients<Real>& p, Real cos_theta, Real gamma, Real cos_gamma) {
    return (Real(1) + p.a * fast_exp(p.b / cos_theta)) *
           (Real(1) + p.c * fast_exp(p.d * gamma) + p.e * cos_gamma * cos_gamma);
}

template <class Real>
glm::vec<3, Real> bounded(const glm::vec<3, Real>& v) {
    return {std::clamp(v.x, Real(-1), Real(1)), std::clamp(v.y, Real(-1), Real(1)), std::clamp(v.z, Real(-1), Real(1))};
}

// The float path: no branches, one division for the air's thickness, powers of two instead of exponentials.
glm::vec3 fast_luminance_chromaticity(const PreethamSky<float>& sky, const glm::vec3& v) {
    constexpr float log2_e = 1.44269504F;
    const glm::vec3& s = sky.to_sun;
    const float cosine = v.x * s.x + v.y * s.y + v.z * s.z;
    const float gamma = fast_angle(v, s, cosine) * log2_e;
    const float inverse = log2_e / std::max(v.z, static_cast<float>(least_cosine));
    const float squared = std::min(cosine * cosine, 1.0F);
    glm::vec3 value;
    for (int k = 0; k < 3; ++k) {
        const PerezCoefficients<float>& p = sky.perez[static_cast<std::size_t>(k)];
        value[k] = (1.0F + p.a * fast_exp2(p.b * inverse)) * (1.0F + p.c * fast_exp2(p.d * gamma) + p.e * squared);
    }
    return sky.scale * value;
}

// The sun never below the horizon.
template <class Real>
glm::vec<3, Real> above_horizon(const glm::vec<3, Real>& v) {
    if (v.z >= Real(0)) {
        return v;
    }
    const Real length = std::hypot(v.x, v.y);
    return length > Real(0) ? glm::vec<3, Real>(v.x / length, v.y / length, 0) : glm::vec<3, Real>(0, 1, 0);
}

template <class Real>
Real chromaticity(const double (&m)[3][4], Real t, Real s) {
    const auto row = [&](int i) {
        return ((Real(m[i][0]) * s + Real(m[i][1])) * s + Real(m[i][2])) * s + Real(m[i][3]);
    };
    return (row(0) * t + row(1)) * t + row(2);
}

// Preetham et al. 1999, appendix A.2.
constexpr double zenith_x[3][4] = {
    {0.00166, -0.00375, 0.00209, 0.0}, {-0.02903, 0.06377, -0.03202, 0.00394}, {0.11693, -0.21196, 0.06052, 0.25886}};
constexpr double zenith_y[3][4] = {
    {0.00275, -0.00610, 0.00317, 0.0}, {-0.04214, 0.08970, -0.04153, 0.00516}, {0.15346, -0.26756, 0.06670, 0.26688}};

} // namespace

template <class Real>
PreethamSky<Real> make_preetham(const glm::vec<3, Real>& to_sun, Real turbidity) {
    PreethamSky<Real> sky{};
    sky.to_sun = above_horizon(bounded(to_sun));
    const Real t = turbidity >= Real(preetham_min_turbidity) ? std::min(turbidity, Real(preetham_max_turbidity))
                                                             : Real(preetham_min_turbidity);
    sky.turbidity = t;
    sky.perez[0] = {Real(0.1787) * t - Real(1.4630), Real(-0.3554) * t + Real(0.4275), Real(-0.0227) * t + Real(5.3251),
                    Real(0.1206) * t - Real(2.5771), Real(-0.0670) * t + Real(0.3703)};
    sky.perez[1] = {Real(-0.0193) * t - Real(0.2592), Real(-0.0665) * t + Real(0.0008),
                    Real(-0.0004) * t + Real(0.2125), Real(-0.0641) * t - Real(0.8989),
                    Real(-0.0033) * t + Real(0.0452)};
    sky.perez[2] = {Real(-0.0167) * t - Real(0.2608), Real(-0.0950) * t + Real(0.0092),
                    Real(-0.0079) * t + Real(0.2102), Real(-0.0441) * t - Real(1.6537),
                    Real(-0.0109) * t + Real(0.0529)};
    const Real sun_horizontal = std::hypot(sky.to_sun.x, sky.to_sun.y);
    const Real theta = std::atan2(sun_horizontal, sky.to_sun.z);
    const Real chi = (Real(4.0 / 9.0) - t / Real(120)) * (Real(pi) - Real(2) * theta);
    const Real zenith_kcd = (Real(4.0453) * t - Real(4.9710)) * std::tan(chi) - Real(0.2155) * t + Real(2.4192);
    sky.zenith_Yxy = {Real(1000) * zenith_kcd, chromaticity(zenith_x, t, theta), chromaticity(zenith_y, t, theta)};
    for (int k = 0; k < 3; ++k) {
        sky.normalisation[k] = perez(sky.perez[static_cast<std::size_t>(k)], Real(1), theta, sky.to_sun.z);
    }
    sky.scale = sky.zenith_Yxy / sky.normalisation;
    return sky;
}

template <class Real>
glm::vec<3, Real> luminance_chromaticity(const PreethamSky<Real>& sky, const glm::vec<3, Real>& direction) {
    const glm::vec<3, Real> v = bounded(direction);
    if constexpr (std::is_same_v<Real, float>) {
        return fast_luminance_chromaticity(sky, v);
    }
    const Real cos_gamma = std::clamp(glm::dot(v, sky.to_sun), Real(-1), Real(1));
    const Real gamma = fast_angle(v, sky.to_sun, cos_gamma);
    const Real cos_theta = std::max(v.z, Real(least_cosine));
    glm::vec<3, Real> out;
    for (int k = 0; k < 3; ++k) {
        out[k] = sky.scale[k] * perez(sky.perez[static_cast<std::size_t>(k)], cos_theta, gamma, cos_gamma);
    }
    return out;
}

template <class Real>
glm::vec<3, Real> radiance(const PreethamSky<Real>& sky, const glm::vec<3, Real>& direction) {
    return into_gamut_of(yxy_to_rec709_of(luminance_chromaticity(sky, direction)));
}

template PreethamSky<float> make_preetham(const glm::vec3&, float);
template PreethamSky<double> make_preetham(const glm::dvec3&, double);
template glm::vec3 luminance_chromaticity(const PreethamSky<float>&, const glm::vec3&);
template glm::dvec3 luminance_chromaticity(const PreethamSky<double>&, const glm::dvec3&);
template glm::vec3 radiance(const PreethamSky<float>&, const glm::vec3&);
template glm::dvec3 radiance(const PreethamSky<double>&, const glm::dvec3&);

} // namespace alpenglow::sky
