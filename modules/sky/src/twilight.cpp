#include <alpenglow/sky/twilight.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace alpenglow::sky {
namespace {

struct Knot {
    double altitude_deg, log10_fade;
};
constexpr std::array<Knot, 9> knots{
    {{-18, -8.3}, {-15, -7.0}, {-12, -6.1}, {-9, -4.95}, {-6, -3.48}, {-3, -2.05}, {0, -0.85}, {5, -0.25}, {10, 0}}};

// Slopes for a monotone cubic (Fritsch and Butland 1984): harmonic means of the neighbouring secants.
std::array<double, knots.size()> monotone_slopes() {
    std::array<double, knots.size()> slopes{};
    const auto secant = [](std::size_t i) {
        return (knots[i + 1].log10_fade - knots[i].log10_fade) / (knots[i + 1].altitude_deg - knots[i].altitude_deg);
    };
    slopes.front() = secant(0);
    for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
        slopes[i] = 2.0 / (1.0 / secant(i - 1) + 1.0 / secant(i));
    }
    return slopes; // the last slope is 0: the fade joins 1 smoothly
}

} // namespace

double twilight_fade(double sun_altitude_rad) {
    const double altitude = sun_altitude_rad / degree_rad;
    if (altitude >= knots.back().altitude_deg) {
        return 1.0;
    }
    if (!(altitude > knots.front().altitude_deg)) {
        return 0.0;
    }
    static const std::array<double, knots.size()> slopes = monotone_slopes();
    std::size_t i = 0;
    while (i + 2 < knots.size() && altitude >= knots[i + 1].altitude_deg) {
        ++i;
    }
    const double width = knots[i + 1].altitude_deg - knots[i].altitude_deg;
    const double t = (altitude - knots[i].altitude_deg) / width;
    const double u = 1.0 - t;
    const double log10_fade = knots[i].log10_fade * u * u * (1.0 + 2.0 * t) +
                              knots[i + 1].log10_fade * t * t * (3.0 - 2.0 * t) +
                              width * t * u * (slopes[i] * u - slopes[i + 1] * t);
    const double end = std::clamp((altitude - knots.front().altitude_deg) / 2.0, 0.0, 1.0);
    return std::pow(10.0, log10_fade) * end * end * (3.0 - 2.0 * end);
}

glm::dvec3 night_floor_cd_m2() {
    // Luminance 2.2e-4, chromaticity (0.35, 0.36): airglow makes the dark sky warmer than daylight.
    return {2.59e-4, 2.14e-4, 1.63e-4};
}

} // namespace alpenglow::sky
