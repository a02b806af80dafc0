#include <alpenglow/probes/environment.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/image.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/common.hpp>
#include <glm/mat3x3.hpp>

namespace alpenglow::probes {

namespace {

Error map_error(const std::string& field, const std::string& what, const std::string& expected) {
    return {.what = what, .where = "EnvironmentMap::" + field, .expected = expected};
}

} // namespace

Status check(const EnvironmentMap& map) {
    if (map.width < 1 || map.height < 1) {
        return map_error(map.width < 1 ? "width" : "height",
                         "is " + std::to_string(map.width < 1 ? map.width : map.height), "1 or more");
    }
    const std::size_t pixels = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
    if (map.radiance.size() != pixels) {
        return map_error("radiance", "has " + std::to_string(map.radiance.size()) + " pixels",
                         std::to_string(pixels) + " for " + std::to_string(map.width) + " x " +
                             std::to_string(map.height));
    }
    if (!std::isfinite(map.scale) || std::isless(map.scale, 0.0F)) {
        return map_error("scale", "is " + std::to_string(map.scale), "0 or more");
    }
    if (!std::isfinite(map.azimuth_rad)) {
        return map_error("azimuth_rad", "is not finite", "radians");
    }
    if (map.order < 1 || map.order > max_probe_order) {
        return map_error("order", "is " + std::to_string(map.order), "1 to " + std::to_string(max_probe_order));
    }
    for (std::size_t i = 0; i < pixels; ++i) {
        for (int c = 0; c < 3; ++c) {
            const float v = map.radiance[i][c];
            if (!std::isfinite(v) || std::isless(v, 0.0F)) {
                const auto width = static_cast<std::size_t>(map.width);
                return map_error("radiance",
                                 "at column " + std::to_string(i % width) + ", row " + std::to_string(i / width) +
                                     " is " + std::to_string(v),
                                 "finite values of 0 or more");
            }
        }
    }
    return Ok{};
}

namespace {

// sh's maps look to +X in the middle and to +Y at its right; ours, as photographs do from within, to the north and the
// east: a rotation and a reflection.
glm::dmat3 local_from_image(double azimuth_rad) {
    const double s = std::sin(azimuth_rad);
    const double c = std::cos(azimuth_rad);
    return {glm::dvec3(s, c, 0.0), glm::dvec3(c, -s, 0.0), glm::dvec3(0.0, 0.0, 1.0)}; // columns
}

} // namespace

void project_environment(const EnvironmentMap& map, std::span<glm::vec3> out) {
    const auto n = static_cast<std::size_t>(sh::coefficient_count(map.order));
    const std::span<glm::vec3> coefficients = out.first(n);
    const sh::EquirectMap image{{&map.radiance.front().x, 3 * map.radiance.size()}, map.width, map.height};
    const Result<std::size_t> projected = sh::project(image, map.order, coefficients);
    assert(projected && *projected == 0); // check() has seen to it
    const sh::Rotation turn(map.order, local_from_image(static_cast<double>(map.azimuth_rad)));
    turn.apply(std::span<const glm::vec3>(coefficients), coefficients);
    for (glm::vec3& c : coefficients) {
        c *= map.scale;
    }
}

glm::vec3 environment_radiance(const EnvironmentMap& map, const glm::vec3& direction) {
    const glm::dvec3 d(direction);
    const double turn = (std::atan2(d.x, d.y) - static_cast<double>(map.azimuth_rad)) / two_pi + 0.5;
    const double u = (turn - std::floor(turn)) * map.width - 0.5;
    const double v = std::clamp(std::atan2(std::hypot(d.x, d.y), d.z) / pi * map.height - 0.5, 0.0, map.height - 1.0);
    const double u0 = std::floor(u);
    const double v0 = std::floor(v);
    const auto texel = [&](int column, int row) {
        const int x = (column % map.width + map.width) % map.width;
        const int y = std::min(row, map.height - 1);
        return glm::dvec3(map.radiance[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                                       static_cast<std::size_t>(x)]);
    };
    const int x = static_cast<int>(u0);
    const int y = static_cast<int>(v0);
    const glm::dvec3 above = glm::mix(texel(x, y), texel(x + 1, y), u - u0);
    const glm::dvec3 below = glm::mix(texel(x, y + 1), texel(x + 1, y + 1), u - u0);
    return glm::vec3(static_cast<double>(map.scale) * glm::mix(above, below, v - v0));
}

} // namespace alpenglow::probes
