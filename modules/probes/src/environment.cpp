#include <alpenglow/probes/environment.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <vector>

#include <glm/common.hpp>

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

void project_environment(const EnvironmentMap& map, std::span<glm::vec3> out) {
    const int order = map.order;
    const auto n = static_cast<std::size_t>(sh::coefficient_count(order));
    const auto width = static_cast<std::size_t>(map.width);
    assert(out.size() >= n);
    // Integrals of cos(m phi) and sin(m phi) over a column, for m = 0 .. order-1.
    const auto orders = static_cast<std::size_t>(order);
    std::vector<double> waves(2 * orders * width);
    for (std::size_t m = 0; m < orders; ++m) {
        const double half = static_cast<double>(m) * pi / map.width;
        const double mean = m == 0 ? 1.0 : std::sin(half) / half;
        for (std::size_t u = 0; u < width; ++u) {
            const double phi =
                two_pi * (static_cast<double>(u) + 0.5) / map.width + static_cast<double>(map.azimuth_rad);
            waves[2 * m * width + u] = mean * std::cos(static_cast<double>(m) * phi);
            waves[(2 * m + 1) * width + u] = mean * std::sin(static_cast<double>(m) * phi);
        }
    }
    std::array<glm::dvec3, sh::max_coefficients> sum{};
    std::array<double, sh::max_coefficients> basis{};
    for (int v = 0; v < map.height; ++v) {
        const double top = pi * v / map.height;
        const double step = pi / map.height;
        // cos(top) - cos(top + step), without cancellation.
        const double weight = two_pi / map.width * 2.0 * std::sin(top + 0.5 * step) * std::sin(0.5 * step);
        sh::evaluate_basis(order, glm::dvec3(std::sin(top + 0.5 * step), 0.0, std::cos(top + 0.5 * step)), basis);
        const glm::vec3* const row = map.radiance.data() + static_cast<std::size_t>(v) * width;
        for (int m = 0; m < order; ++m) {
            const double* const c = waves.data() + 2 * static_cast<std::size_t>(m) * width;
            const double* const s = c + width;
            glm::dvec3 by_cos(0.0);
            glm::dvec3 by_sin(0.0);
            for (std::size_t u = 0; u < width; ++u) {
                const glm::dvec3 radiance(row[u]);
                by_cos += c[u] * radiance;
                by_sin += s[u] * radiance;
            }
            for (int l = m; l < order; ++l) {
                const double q = weight * basis[static_cast<std::size_t>(sh::index(l, m))];
                sum[static_cast<std::size_t>(sh::index(l, m))] += q * by_cos;
                if (m > 0) {
                    sum[static_cast<std::size_t>(sh::index(l, -m))] += q * by_sin;
                }
            }
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = glm::vec3(static_cast<double>(map.scale) * sum[i]);
    }
}

glm::vec3 environment_radiance(const EnvironmentMap& map, const glm::vec3& direction) {
    const glm::dvec3 d(direction);
    const double turn = (std::atan2(d.y, d.x) - static_cast<double>(map.azimuth_rad)) / two_pi;
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
