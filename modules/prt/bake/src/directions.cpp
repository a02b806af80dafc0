#include "directions.hpp"

#include <alpenglow/core/constants.hpp>

#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::prt {

std::uint64_t mix(std::uint64_t value) noexcept { // the finaliser of SplitMix64
    value += 0x9E3779B97F4A7C15ULL;
    value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    value = (value ^ (value >> 27U)) * 0x94D049BB133111EBULL;
    return value ^ (value >> 31U);
}

double uniform(std::uint64_t seed, std::uint64_t index) noexcept {
    return static_cast<double>(mix(mix(seed) ^ index) >> 11U) * 0x1.0p-53;
}

glm::dvec3 cosine_direction(double x, double y) noexcept {
    const double a = 2.0 * x - 1.0;
    const double b = 2.0 * y - 1.0;
    double r = 0.0;
    double phi = 0.0;
    if (std::abs(a) > std::abs(b)) {
        r = a;
        phi = pi / 4.0 * (b / a);
    } else if (b != 0.0) {
        r = b;
        phi = pi / 2.0 - pi / 4.0 * (a / b);
    }
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(std::fmax(0.0, 1.0 - r * r))};
}

namespace {
const double golden_angle_rad = pi * (3.0 - std::sqrt(5.0));
}

std::vector<glm::dvec3> fibonacci_hemisphere(std::size_t count) {
    std::vector<glm::dvec3> directions(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double r2 = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        const double phi = golden_angle_rad * static_cast<double>(i);
        directions[i] = {std::sqrt(r2) * std::cos(phi), std::sqrt(r2) * std::sin(phi), std::sqrt(1.0 - r2)};
    }
    return directions;
}

std::vector<glm::dvec3> fibonacci_sphere(std::size_t count) {
    std::vector<glm::dvec3> directions(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        const double r = std::sqrt(std::fmax(0.0, 1.0 - z * z));
        const double phi = golden_angle_rad * static_cast<double>(i);
        directions[i] = {r * std::cos(phi), r * std::sin(phi), z};
    }
    return directions;
}

glm::mat3 frame_about(const glm::vec3& normal, float spin_rad) noexcept {
    // Duff et al. 2017: no branch on the normal's direction but its sign.
    const float sign = std::copysign(1.0F, normal.z);
    const float a = -1.0F / (sign + normal.z);
    const float b = normal.x * normal.y * a;
    const glm::vec3 x{1.0F + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
    const glm::vec3 y{b, sign + normal.y * normal.y * a, -normal.y};
    const float c = std::cos(spin_rad);
    const float s = std::sin(spin_rad);
    return {c * x + s * y, c * y - s * x, normal};
}

} // namespace alpenglow::prt
