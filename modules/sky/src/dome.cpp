#include <alpenglow/sky/dome.hpp>

#include "fast_math.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

constexpr double least_cosine = 1e-3;

// Perez et al. 1993, table 1: a, b, c, d, e, each x1 + x2 Z + delta (x3 + x4 Z). Compared number by number with
// Radiance's gendaylit.c.
constexpr double all_weather[8][5][4] = {{{1.3525, -0.2576, -0.2690, -1.4366},
                                          {-0.7670, 0.0007, 1.2734, -0.1233},
                                          {2.8000, 0.6004, 1.2375, 1.0000},
                                          {1.8734, 0.6297, 0.9738, 0.2809},
                                          {0.0356, -0.1246, -0.5718, 0.9938}},
                                         {{-1.2219, -0.7730, 1.4148, 1.1016},
                                          {-0.2054, 0.0367, -3.9128, 0.9156},
                                          {6.9750, 0.1774, 6.4477, -0.1239},
                                          {-1.5798, -0.5081, -1.7812, 0.1080},
                                          {0.2624, 0.0672, -0.2190, -0.4285}},
                                         {{-1.1000, -0.2515, 0.8952, 0.0156},
                                          {0.2782, -0.1812, -4.5000, 1.1766},
                                          {24.7219, -13.0812, -37.7000, 34.8438},
                                          {-5.0000, 1.5218, 3.9229, -2.6204},
                                          {-0.0156, 0.1597, 0.4199, -0.5562}},
                                         {{-0.5484, -0.6654, -0.2672, 0.7117},
                                          {0.7234, -0.6219, -5.6812, 2.6297},
                                          {33.3389, -18.3000, -62.2500, 52.0781},
                                          {-3.5000, 0.0016, 1.1477, 0.1062},
                                          {0.4659, -0.3296, -0.0876, -0.0329}},
                                         {{-0.6000, -0.3566, -2.5000, 2.3250},
                                          {0.2937, 0.0496, -5.6812, 1.8415},
                                          {21.0000, -4.7656, -21.5906, 7.2492},
                                          {-3.5000, -0.1554, 1.4062, 0.3988},
                                          {0.0032, 0.0766, -0.0656, -0.1294}},
                                         {{-1.0156, -0.3670, 1.0078, 1.4051},
                                          {0.2875, -0.5328, -3.8500, 3.3750},
                                          {14.0000, -0.9999, -7.1406, 7.5469},
                                          {-3.4000, -0.1078, -1.0750, 1.5702},
                                          {-0.0672, 0.4016, 0.3017, -0.4844}},
                                         {{-1.0000, 0.0211, 0.5025, -0.5119},
                                          {-0.3000, 0.1922, 0.7023, -1.6317},
                                          {19.0000, -5.0000, 1.2438, -1.9094},
                                          {-4.0000, 0.0250, 0.3844, 0.2656},
                                          {1.0468, -0.3788, -2.4517, 1.4656}},
                                         {{-1.0500, 0.0289, 0.4260, 0.3590},
                                          {-0.3250, 0.1156, 0.7781, 0.0025},
                                          {31.0625, -14.5000, -46.1148, 55.3750},
                                          {-7.2312, 0.4050, 13.3500, 0.6234},
                                          {1.5000, -0.6426, 1.8564, 0.5636}}};
constexpr double clearness_bins[7] = {1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200};
// Perez et al. 1990, table 4 and eq. 10: zenith luminance over diffuse irradiance, a + c cos Z + c' e^(-3 Z) + d delta.
constexpr double zenith_efficacy[8][4] = {{40.86, 26.77, -29.59, -45.75}, {26.58, 14.73, 58.46, -21.25},
                                          {19.34, 2.28, 100.00, 0.25},    {13.25, -1.39, 124.79, 15.66},
                                          {14.47, -5.09, 160.09, 9.13},   {19.76, -3.88, 154.61, -19.21},
                                          {28.39, -9.67, 151.58, -69.39}, {42.91, -19.62, 130.80, -164.08}};

// CIE S 011:2003, table 1: a, b, c, d, e.
constexpr double general[15][5] = {
    {4.0, -0.70, 0, -1.0, 0.00},   {4.0, -0.70, 2, -1.5, 0.15},   {1.1, -0.80, 0, -1.0, 0.00},
    {1.1, -0.80, 2, -1.5, 0.15},   {0.0, -1.00, 0, -1.0, 0.00},   {0.0, -1.00, 2, -1.5, 0.15},
    {0.0, -1.00, 5, -2.5, 0.30},   {0.0, -1.00, 10, -3.0, 0.45},  {-1.0, -0.55, 2, -1.5, 0.15},
    {-1.0, -0.55, 5, -2.5, 0.30},  {-1.0, -0.55, 10, -3.0, 0.45}, {-1.0, -0.32, 10, -3.0, 0.45},
    {-1.0, -0.32, 16, -3.0, 0.30}, {-1.0, -0.15, 16, -3.0, 0.30}, {-1.0, -0.15, 24, -2.8, 0.15}};

template <class Real>
Real value(const DomeTerm<Real>& t, Real cos_theta, Real gamma, Real cos_gamma, Real sun_z) {
    if (t.scale == Real(0)) {
        return Real(0);
    }
    if (t.intermediate) {
        // Nakamura et al. 1985 as CIE prints it (Littlefair 1994): altitudes of the element and of the sun.
        const Real altitude = std::asin(std::clamp(cos_theta, Real(0), Real(1)));
        const Real sun = std::asin(std::clamp(sun_z, Real(0), Real(1)));
        const Real level = Real(1.35) * (std::sin(Real(3.59) * altitude - Real(0.009)) + Real(2.31)) *
                               std::sin(Real(2.60) * sun + Real(0.316)) +
                           altitude + Real(4.799);
        const Real fall = Real(-0.563) * ((sun - Real(0.008)) * (altitude + Real(1.059)) + Real(0.812));
        return t.scale * level / Real(2.326) * fast_exp(fall * gamma);
    }
    const Real gradation = t.g0 + t.g1 * cos_theta + t.a * fast_exp(t.b / cos_theta);
    const Real indicatrix = t.s0 + t.c * fast_exp(t.d * gamma) + t.e * cos_gamma * cos_gamma;
    return t.scale * std::max(gradation, Real(0)) * std::max(indicatrix, Real(0));
}

template <class Real>
Real perez_value(const PerezCoefficients<Real>& p, Real cos_theta, Real gamma, Real cos_gamma) {
    return (Real(1) + p.a * fast_exp(p.b / cos_theta)) *
           (Real(1) + p.c * fast_exp(p.d * gamma) + p.e * cos_gamma * cos_gamma);
}

std::size_t clearness_bin(double clearness) {
    std::size_t bin = 0;
    while (bin < 7 && clearness >= clearness_bins[bin]) {
        ++bin;
    }
    return bin;
}

// Zenith luminance of any weather, cd/m^2 (Perez et al. 1990, eq. 10), theta the sun's zenith angle.
double all_weather_zenith(double clearness, double brightness, double theta) {
    // delta = m E_diffuse / E_0 gives the diffuse irradiance.
    const double mass = 1.0 / (std::cos(theta) + 0.15 * std::pow(93.885 - theta / degree_rad, -1.253));
    const double diffuse_w = brightness * 1367.0 / mass;
    const double* z = zenith_efficacy[clearness_bin(clearness)];
    return std::max(diffuse_w * (z[0] + z[1] * std::cos(theta) + z[2] * std::exp(-3.0 * theta) + z[3] * brightness),
                    0.0);
}

// Zenith luminance of the clear sky, cd/m^2 (Karayel et al. 1984), for altitudes up to 75 degrees, where the tangent
// runs away; of the overcast sky, after Krochmann and Seidl 1974: 9 / (7 pi) (300 + 21000 sin h) lux.
double clear_zenith(double turbidity, double altitude) {
    return 1000.0 * ((1.376 * turbidity - 1.81) * std::tan(std::min(altitude, 75.0 * degree_rad)) + 0.38);
}
double overcast_zenith(double altitude) {
    return 9.0 / (7.0 * pi) * (300.0 + 21000.0 * std::sin(altitude));
}

DomeTerm<double> kittler(double a0, double c, double d, double e) {
    // (a0 + c e^(d gamma) + e cos^2 gamma) (1 - e^(-0.32 / cos theta))
    DomeTerm<double> t;
    t.g0 = 1.0;
    t.a = -1.0;
    t.b = -0.32;
    t.s0 = a0;
    t.c = c;
    t.d = d;
    t.e = e;
    return t;
}
DomeTerm<double> overcast() {
    DomeTerm<double> t;
    t.g0 = 1.0 / 3.0;
    t.g1 = 2.0 / 3.0;
    return t;
}

// Sets the scale so that the term gives `luminance` at the zenith.
void scale_to_zenith(DomeTerm<double>& t, double luminance, double theta, double sun_z) {
    t.scale = 1.0;
    const double now = value(t, 1.0, theta, sun_z, sun_z);
    t.scale = now > 0.0 ? luminance / now : 0.0;
}

} // namespace

Status check(const DomeParameters& p) {
    const auto wrong = [](const char* field, double v, const char* expected) {
        return Error{std::string(field) + " is " + std::to_string(v), "sky dome", expected};
    };
    if (!(p.turbidity >= 1.7F && p.turbidity <= 10.0F)) {
        return wrong("turbidity", p.turbidity, "a number from 1.7 to 10");
    }
    if (!(p.clearness >= 1.0F && p.clearness <= 100.0F)) {
        return wrong("clearness", p.clearness, "a number from 1 to 100");
    }
    if (!(p.brightness >= 0.001F && p.brightness <= 0.6F)) {
        return wrong("brightness", p.brightness, "a number from 0.001 to 0.6");
    }
    if (p.cie_type < 1 || p.cie_type > 15) {
        return wrong("cie_type", p.cie_type, "a whole number from 1 to 15");
    }
    if (!(p.zenith_cd_m2 >= 0.0F && p.zenith_cd_m2 <= 1e9F)) {
        return wrong("zenith_cd_m2", p.zenith_cd_m2, "a number from 0 to 1e9");
    }
    const double length = glm::length(glm::dvec3(p.to_sun));
    if (!(std::abs(length - 1.0) < 1e-3)) {
        return wrong("the length of to_sun", length, "1");
    }
    return Ok{};
}

template <class Real>
SkyDome<Real> make_dome(const DomeParameters& p) {
    assert(check(p));
    const PreethamSky<double> clear = make_preetham(glm::dvec3(p.to_sun), static_cast<double>(p.turbidity));
    const double sun_z = clear.to_sun.z;
    const double theta = std::atan2(std::hypot(clear.to_sun.x, clear.to_sun.y), sun_z);
    const double altitude = 0.5 * pi - theta;
    std::array<DomeTerm<double>, 2> terms{};
    std::array<double, 2> zenith{};
    double grey = 0.0;
    switch (p.model) {
    case DomeModel::preetham: {
        const PerezCoefficients<double>& c = clear.perez[0];
        terms[0] = {1.0, 1.0, 0.0, c.a, c.b, 1.0, c.c, c.d, c.e, false};
        zenith[0] = clear.zenith_Yxy.x;
        break;
    }
    case DomeModel::perez: {
        const double clearness = p.clearness;
        const double brightness = p.brightness;
        const std::size_t bin = clearness_bin(clearness);
        std::array<double, 5> x{};
        for (std::size_t k = 0; k < 5; ++k) {
            const double* c = all_weather[bin][k];
            x[k] = c[0] + c[1] * theta + brightness * (c[2] + c[3] * theta);
        }
        if (bin == 0) {
            const double* c = all_weather[0][2];
            const double* d = all_weather[0][3];
            x[2] = std::exp(std::pow(std::max(brightness * (c[0] + c[1] * theta), 0.0), c[2])) - c[3];
            x[3] = -std::exp(brightness * (d[0] + d[1] * theta)) + d[2] + brightness * d[3];
        }
        terms[0] = {1.0, 1.0, 0.0, x[0], std::min(x[1], -1e-3), 1.0, x[2], x[3], x[4], false};
        zenith[0] = all_weather_zenith(clearness, brightness, theta);
        grey = std::clamp(1.0 - (clearness - 1.0) / 2.0, 0.0, 1.0);
        break;
    }
    case DomeModel::cie_clear:
        terms[0] = kittler(0.91, 10.0, -3.0, 0.45);
        zenith[0] = clear_zenith(p.turbidity, altitude);
        break;
    case DomeModel::cie_overcast:
        terms[0] = overcast();
        zenith[0] = overcast_zenith(altitude);
        grey = 1.0;
        break;
    case DomeModel::asrc_cie: {
        // Overcast, intermediate, clear turbid and clear sky, blended as Perez et al. 1990, section 3.4, say; up to 1.2
        // a bright overcast turns intermediate as well.
        DomeTerm<double> intermediate;
        intermediate.intermediate = true;
        const std::array<DomeTerm<double>, 4> skies{overcast(), intermediate, kittler(0.856, 16.0, -3.0, 0.3),
                                                    kittler(0.91, 10.0, -3.0, 0.45)};
        constexpr std::array<double, 4> knots{1.0, 1.2, 3.0, 6.0};
        const double clearness = p.clearness;
        const double brightness = p.brightness;
        std::size_t i = 0;
        while (i < 2 && clearness >= knots[i + 1]) {
            ++i;
        }
        double t = (clearness - knots[i]) / (knots[i + 1] - knots[i]);
        if (i == 0) {
            t = std::max(t, (brightness - 0.05) / 0.4);
        }
        t = std::clamp(t, 0.0, 1.0);
        terms = {skies[i], skies[i + 1]};
        // Each sky with its own zenith: one formula by clearness bins, as there, would step when the weather drifts.
        const double between = 0.5 * (overcast_zenith(altitude) + clear_zenith(p.turbidity, altitude));
        const std::array<double, 4> zeniths{
            overcast_zenith(altitude), between,
            clear_zenith(std::min(1.5 * static_cast<double>(p.turbidity), 10.0), altitude),
            clear_zenith(p.turbidity, altitude)};
        zenith = {(1.0 - t) * zeniths[i], t * zeniths[i + 1]};
        grey = std::clamp(1.0 - (static_cast<double>(p.clearness) - 1.0) / 2.0, 0.0, 1.0);
        break;
    }
    case DomeModel::cie_general: {
        const double* c = general[static_cast<std::size_t>(p.cie_type - 1)];
        // f(chi) = 1 + c (e^(d chi) - e^(d pi / 2)) + e cos^2 chi
        terms[0] = {1.0, 1.0, 0.0, c[0], c[1], 1.0 - c[2] * std::exp(0.5 * pi * c[3]), c[2], c[3], c[4], false};
        const double t = std::clamp((p.cie_type - 4) / 8.0, 0.0, 1.0); // overcast 1 .. 4, clear from 12 on
        zenith[0] = (1.0 - t) * overcast_zenith(altitude) + t * clear_zenith(p.turbidity, altitude);
        grey = 1.0 - t;
        break;
    }
    }
    const double whole = zenith[0] + zenith[1];
    for (std::size_t i = 0; i < 2; ++i) {
        const double share = p.zenith_cd_m2 > 0.0F && whole > 0.0 ? static_cast<double>(p.zenith_cd_m2) / whole : 1.0;
        scale_to_zenith(terms[i], share * zenith[i], theta, sun_z);
    }
    SkyDome<Real> dome{};
    dome.to_sun = glm::vec<3, Real>(clear.to_sun);
    for (std::size_t i = 0; i < 2; ++i) {
        const DomeTerm<double>& t = terms[i];
        dome.luminance[i] = {Real(t.scale), Real(t.g0), Real(t.g1), Real(t.a), Real(t.b),
                             Real(t.s0),    Real(t.c),  Real(t.d),  Real(t.e), t.intermediate};
        const PerezCoefficients<double>& c = clear.perez[i + 1];
        dome.chromaticity[i] = {Real(c.a), Real(c.b), Real(c.c), Real(c.d), Real(c.e)};
    }
    dome.zenith_xy = {Real(clear.zenith_Yxy.y / clear.normalisation.y),
                      Real(clear.zenith_Yxy.z / clear.normalisation.z)};
    dome.grey = Real(grey);
    return dome;
}

template <class Real>
glm::vec<3, Real> luminance_chromaticity(const SkyDome<Real>& dome, const glm::vec<3, Real>& direction) {
    const glm::vec<3, Real> v(std::clamp(direction.x, Real(-1), Real(1)), std::clamp(direction.y, Real(-1), Real(1)),
                              std::clamp(direction.z, Real(-1), Real(1)));
    const Real cos_gamma = std::clamp(glm::dot(v, dome.to_sun), Real(-1), Real(1));
    const Real gamma = fast_angle(v, dome.to_sun, cos_gamma);
    const Real cos_theta = std::max(v.z, Real(least_cosine));
    glm::vec<3, Real> out;
    out.x = value(dome.luminance[0], cos_theta, gamma, cos_gamma, dome.to_sun.z) +
            value(dome.luminance[1], cos_theta, gamma, cos_gamma, dome.to_sun.z);
    const Real x = dome.zenith_xy.x * perez_value(dome.chromaticity[0], cos_theta, gamma, cos_gamma);
    const Real y = dome.zenith_xy.y * perez_value(dome.chromaticity[1], cos_theta, gamma, cos_gamma);
    out.y = x + dome.grey * (Real(0.3127) - x);
    out.z = y + dome.grey * (Real(0.3290) - y);
    return out;
}

template <class Real>
glm::vec<3, Real> radiance(const SkyDome<Real>& dome, const glm::vec<3, Real>& direction) {
    return into_gamut(yxy_to_rec709(luminance_chromaticity(dome, direction)));
}

Spectrum spectral_radiance(const SkyDome<double>& dome, const glm::dvec3& direction) {
    const glm::dvec3 Yxy = luminance_chromaticity(dome, direction);
    Spectrum spectrum = daylight_spectrum({Yxy.y, Yxy.z});
    const double now = spectrum_to_xyz(spectrum).y;
    for (double& s : spectrum) {
        s *= now > 0.0 ? Yxy.x / now : 0.0;
    }
    return spectrum;
}

template SkyDome<float> make_dome(const DomeParameters&);
template SkyDome<double> make_dome(const DomeParameters&);
template glm::vec3 luminance_chromaticity(const SkyDome<float>&, const glm::vec3&);
template glm::dvec3 luminance_chromaticity(const SkyDome<double>&, const glm::dvec3&);
template glm::vec3 radiance(const SkyDome<float>&, const glm::vec3&);
template glm::dvec3 radiance(const SkyDome<double>&, const glm::dvec3&);

} // namespace alpenglow::sky
