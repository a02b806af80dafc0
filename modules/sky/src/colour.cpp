#include <alpenglow/sky/colour.hpp>

#include "colour_of.hpp"

#include <algorithm>
#include <cmath>

namespace alpenglow::sky {
namespace {

constexpr Spectrum x_bar{0.0014, 0.0042, 0.0143, 0.0435, 0.1344, 0.2839, 0.3483, 0.3362, 0.2908, 0.1954, 0.0956,
                         0.0320, 0.0049, 0.0093, 0.0633, 0.1655, 0.2904, 0.4334, 0.5945, 0.7621, 0.9163, 1.0263,
                         1.0622, 1.0026, 0.8544, 0.6424, 0.4479, 0.2835, 0.1649, 0.0874, 0.0468, 0.0227, 0.0114,
                         0.0058, 0.0029, 0.0014, 0.0007, 0.0003, 0.0002, 0.0001, 0.0000};
constexpr Spectrum y_bar{0.0000, 0.0001, 0.0004, 0.0012, 0.0040, 0.0116, 0.0230, 0.0380, 0.0600, 0.0910, 0.1390,
                         0.2080, 0.3230, 0.5030, 0.7100, 0.8620, 0.9540, 0.9950, 0.9950, 0.9520, 0.8700, 0.7570,
                         0.6310, 0.5030, 0.3810, 0.2650, 0.1750, 0.1070, 0.0610, 0.0320, 0.0170, 0.0082, 0.0041,
                         0.0021, 0.0010, 0.0005, 0.0003, 0.0001, 0.0001, 0.0000, 0.0000};
constexpr Spectrum z_bar{0.0065, 0.0201, 0.0679, 0.2074, 0.6456, 1.3856, 1.7471, 1.7721, 1.6692, 1.2876, 0.8130,
                         0.4652, 0.2720, 0.1582, 0.0782, 0.0422, 0.0203, 0.0087, 0.0039, 0.0021, 0.0017, 0.0011,
                         0.0008, 0.0003, 0.0002, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000,
                         0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000};

// Mean and first two characteristic vectors of daylight (Wyszecki and Stiles 1982, table V(3.3.4)).
constexpr Spectrum s0{63.4,  65.8,  94.8,  104.8, 105.9, 96.8, 113.9, 125.6, 125.5, 121.3, 121.3, 113.5, 113.1, 110.8,
                      106.5, 108.8, 105.3, 104.4, 100.0, 96.0, 95.1,  89.1,  90.5,  90.3,  88.4,  84.0,  85.1,  81.9,
                      82.6,  84.9,  81.3,  71.9,  74.3,  76.4, 63.3,  71.7,  77.0,  65.2,  47.7,  68.6,  65.0};
constexpr Spectrum s1{38.5,  35.0,  43.4,  46.3,  43.9,  37.1,  36.7,  35.9,  32.6,  27.9,  24.3, 20.1,  16.2,  13.2,
                      8.6,   6.1,   4.2,   1.9,   0.0,   -1.6,  -3.5,  -3.5,  -5.8,  -7.2,  -8.6, -9.5,  -10.9, -10.7,
                      -12.0, -14.0, -13.6, -12.0, -13.3, -12.9, -10.6, -11.6, -12.2, -10.2, -7.8, -11.2, -10.4};
constexpr Spectrum s2{3.0,  1.2,  -1.1, -0.5, -0.7, -1.2, -2.6, -2.9, -2.8, -2.6, -2.6, -1.8, -1.5, -1.3,
                      -1.2, -1.0, -0.5, -0.3, 0.0,  0.2,  0.5,  2.1,  3.2,  4.1,  4.7,  5.1,  6.7,  7.3,
                      8.6,  9.8,  10.2, 8.3,  9.6,  8.5,  7.0,  7.6,  8.0,  6.7,  5.2,  7.4,  6.8};

} // namespace

const Spectrum& cie_x() {
    return x_bar;
}
const Spectrum& cie_y() {
    return y_bar;
}
const Spectrum& cie_z() {
    return z_bar;
}

glm::dvec3 spectrum_to_xyz(const Spectrum& spectrum) {
    glm::dvec3 xyz(0.0);
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        xyz += spectrum[i] * glm::dvec3(x_bar[i], y_bar[i], z_bar[i]);
    }
    return xyz * (683.0 * spectrum_step_nm);
}

glm::dvec3 xyz_to_rec709(const glm::dvec3& xyz) {
    return xyz_to_rec709_of(xyz);
}
glm::vec3 xyz_to_rec709(const glm::vec3& xyz) {
    return xyz_to_rec709_of(xyz);
}
glm::dvec3 yxy_to_rec709(const glm::dvec3& Yxy) {
    return yxy_to_rec709_of(Yxy);
}
glm::vec3 yxy_to_rec709(const glm::vec3& Yxy) {
    return yxy_to_rec709_of(Yxy);
}
double luminance(const glm::dvec3& rgb) {
    return luminance_of(rgb);
}
float luminance(const glm::vec3& rgb) {
    return luminance_of(rgb);
}
glm::dvec3 into_gamut(const glm::dvec3& rgb) {
    return into_gamut_of(rgb);
}
glm::vec3 into_gamut(const glm::vec3& rgb) {
    return into_gamut_of(rgb);
}

Spectrum daylight_spectrum(glm::dvec2 xy) {
    double denominator = 0.0241 + 0.2562 * xy.x - 0.7341 * xy.y;
    if (std::abs(denominator) < 1e-4) {
        denominator = std::copysign(1e-4, denominator);
    }
    const double m1 = (-1.3515 - 1.7703 * xy.x + 5.9114 * xy.y) / denominator;
    const double m2 = (0.0300 - 31.4424 * xy.x + 30.0717 * xy.y) / denominator;
    Spectrum out{};
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        out[i] = std::max(s0[i] + m1 * s1[i] + m2 * s2[i], 0.0);
    }
    return out;
}

} // namespace alpenglow::sky
