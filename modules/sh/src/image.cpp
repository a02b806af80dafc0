#include <alpenglow/sh/image.hpp>

#include "image_check.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sh {
namespace {

// The integral of 1 / (1 + s^2 + t^2)^(3/2) from the origin to (s, t).
double corner(double s, double t) noexcept {
    return std::atan2(s * t, std::sqrt(s * s + t * t + 1.0));
}

glm::dvec3 pixel(std::span<const float> pixels, std::size_t i, std::size_t& bad) noexcept {
    const glm::dvec3 v(pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2]);
    if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) {
        return v;
    }
    ++bad;
    return glm::dvec3(0.0);
}

void add(int order, const glm::dvec3& direction, const glm::dvec3& weighted, std::span<glm::dvec3> out) {
    std::array<double, max_coefficients> y;
    evaluate_basis(order, direction, y);
    for (std::size_t i = 0; i < static_cast<std::size_t>(coefficient_count(order)); ++i) {
        out[i] += weighted * y[i];
    }
}

} // namespace

namespace detail {

std::optional<Error> check(const CubeMap& map, int supersampling) {
    if (map.size < 1 || map.size > 16384) {
        return Error{"size is " + std::to_string(map.size), "cube map", "1 to 16384 pixels a side"};
    }
    if (supersampling < 1 || supersampling > 64) {
        return Error{"supersampling is " + std::to_string(supersampling), "cube map", "1 to 64"};
    }
    const auto needed = static_cast<std::size_t>(map.size) * static_cast<std::size_t>(map.size) * 3;
    for (std::size_t face = 0; face < 6; ++face) {
        if (map.faces[face].size() != needed) {
            return Error{"face " + std::to_string(face) + " has " + std::to_string(map.faces[face].size()) + " floats",
                         "cube map", std::to_string(needed)};
        }
    }
    return std::nullopt;
}

std::optional<Error> check(const EquirectMap& map, int supersampling) {
    if (map.width < 1 || map.height < 1 || map.width > 65536 || map.height > 65536) {
        return Error{"size is " + std::to_string(map.width) + " x " + std::to_string(map.height), "equirectangular map",
                     "1 to 65536 pixels a side"};
    }
    if (supersampling < 1 || supersampling > 64) {
        return Error{"supersampling is " + std::to_string(supersampling), "equirectangular map", "1 to 64"};
    }
    const auto needed = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height) * 3;
    if (map.pixels.size() != needed) {
        return Error{"pixels has " + std::to_string(map.pixels.size()) + " floats", "equirectangular map",
                     std::to_string(needed)};
    }
    return std::nullopt;
}

} // namespace detail

glm::dvec3 cube_direction(int face, double s, double t) noexcept {
    switch (face) {
    case 0:
        return glm::normalize(glm::dvec3(1.0, -t, -s));
    case 1:
        return glm::normalize(glm::dvec3(-1.0, -t, s));
    case 2:
        return glm::normalize(glm::dvec3(s, 1.0, t));
    case 3:
        return glm::normalize(glm::dvec3(s, -1.0, -t));
    case 4:
        return glm::normalize(glm::dvec3(s, -t, 1.0));
    default:
        return glm::normalize(glm::dvec3(-s, -t, -1.0));
    }
}

double cube_solid_angle(double s0, double s1, double t0, double t1) noexcept {
    return corner(s0, t0) - corner(s0, t1) - corner(s1, t0) + corner(s1, t1);
}

Result<std::size_t> project_reference(const CubeMap& map, int order, std::span<glm::dvec3> out, int supersampling) {
    assert(order >= 1 && order <= max_order && out.size() >= static_cast<std::size_t>(coefficient_count(order)));
    if (auto error = detail::check(map, supersampling)) {
        return *error;
    }
    std::fill_n(out.begin(), coefficient_count(order), glm::dvec3(0.0));
    std::size_t bad = 0;
    const int points = map.size * supersampling;
    for (int face = 0; face < 6; ++face) {
        for (int row = 0; row < map.size; ++row) {
            for (int column = 0; column < map.size; ++column) {
                const glm::dvec3 value = pixel(map.faces[static_cast<std::size_t>(face)],
                                               static_cast<std::size_t>(row) * static_cast<std::size_t>(map.size) +
                                                   static_cast<std::size_t>(column),
                                               bad);
                for (int i = row * supersampling; i < (row + 1) * supersampling; ++i) {
                    for (int j = column * supersampling; j < (column + 1) * supersampling; ++j) {
                        const double s0 = 2.0 * j / points - 1.0, s1 = 2.0 * (j + 1) / points - 1.0;
                        const double t0 = 2.0 * i / points - 1.0, t1 = 2.0 * (i + 1) / points - 1.0;
                        add(order, cube_direction(face, 0.5 * (s0 + s1), 0.5 * (t0 + t1)),
                            value * cube_solid_angle(s0, s1, t0, t1), out);
                    }
                }
            }
        }
    }
    return bad;
}

Result<std::size_t> project_reference(const EquirectMap& map, int order, std::span<glm::dvec3> out, int supersampling) {
    assert(order >= 1 && order <= max_order && out.size() >= static_cast<std::size_t>(coefficient_count(order)));
    if (auto error = detail::check(map, supersampling)) {
        return *error;
    }
    std::fill_n(out.begin(), coefficient_count(order), glm::dvec3(0.0));
    std::size_t bad = 0;
    const int columns = map.width * supersampling, rows = map.height * supersampling;
    for (int row = 0; row < map.height; ++row) {
        for (int column = 0; column < map.width; ++column) {
            const glm::dvec3 value = pixel(map.pixels,
                                           static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) +
                                               static_cast<std::size_t>(column),
                                           bad);
            for (int i = row * supersampling; i < (row + 1) * supersampling; ++i) {
                const double top = std::cos(pi * i / rows), bottom = std::cos(pi * (i + 1) / rows);
                const double z = 0.5 * (top + bottom), r = std::sqrt(1.0 - z * z);
                for (int j = column * supersampling; j < (column + 1) * supersampling; ++j) {
                    const double phi = two_pi * (j + 0.5) / columns - pi;
                    add(order, {r * std::cos(phi), r * std::sin(phi), z}, value * ((top - bottom) * two_pi / columns),
                        out);
                }
            }
        }
    }
    return bad;
}

} // namespace alpenglow::sh
