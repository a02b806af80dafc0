#include "sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::impostors {
namespace {

// Relative RMS of what linear interpolation loses at a random phase f of a texel: f (1 - f) / 2 times the second
// difference, whose RMS over f is sqrt(1 / 120).
constexpr double linear_loss = 0.09128709291752769;

glm::dmat3 outer(const glm::dvec3& a) {
    return {a * a.x, a * a.y, a * a.z};
}

} // namespace

Sensitivity measure_sensitivity(const Capture& capture) {
    Sensitivity result;
    const int width = capture.view.width;
    const int height = capture.view.height;
    const auto texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    std::vector<float> transmittance(texels, 1.0F);
    std::vector<glm::dvec4> whole(texels, glm::dvec4(0.0));
    std::vector<glm::dvec4> part(texels); // this layer's radiance and alpha, as seen through those in front
    const double per_tan_x = capture.view.pixels_per_tan_x();
    const double per_tan_y = capture.view.pixels_per_tan_y();
    for (const Layer& layer : capture.layers) {
        const MipLevel& base = layer.mips.front();
        for (std::size_t i = 0; i < texels; ++i) {
            const glm::vec4 c = base.fill.empty() ? base.colour[i] : base.colour[i] + base.fill[i];
            part[i] = static_cast<double>(transmittance[i]) * glm::dvec4(c);
            whole[i] += part[i];
        }
        const auto at = [&](int x, int y) {
            return x < 0 || y < 0 || x >= width || y >= height ? glm::dvec4(0.0)
                                                               : part[static_cast<std::size_t>(y * width + x)];
        };
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const auto i = static_cast<std::size_t>(y * width + x);
                const auto alpha = static_cast<double>(base.colour[i].w);
                if (alpha <= 1e-6) {
                    continue;
                }
                const double mean = static_cast<double>(base.depth[i].x) / alpha;
                const double variance = std::max(0.0, static_cast<double>(base.depth[i].y) / alpha - mean * mean);
                const double z = std::max(capture.depth_origin_m + capture.depth_scale_m * mean, 1e-3 * layer.far_m);
                const double shown_at = layer.warp.empty()
                                            ? layer.plane_m
                                            : std::clamp(capture.depth_origin_m +
                                                             capture.depth_scale_m * static_cast<double>(layer.warp[i]),
                                                         std::max(layer.near_m, 1e-3 * layer.far_m), layer.far_m);
                const double off = 1.0 / z - 1.0 / shown_at;
                const double spread = std::sqrt(variance) * capture.depth_scale_m / (z * z);
                const double rho_2 = off * off + spread * spread;
                const glm::dvec4 gx = 0.5 * per_tan_x * (at(x + 1, y) - at(x - 1, y));
                const glm::dvec4 gy = 0.5 * per_tan_y * (at(x, y - 1) - at(x, y + 1));
                const double tx = capture.view.tan_left + (x + 0.5) / per_tan_x;
                const double ty = capture.view.tan_top - (y + 0.5) / per_tan_y;
                const auto answer = [&](int c) { return glm::dvec3(-gx[c], -gy[c], tx * gx[c] + ty * gy[c]); };
                result.radiance += rho_2 * (outer(answer(0)) + outer(answer(1)) + outer(answer(2)));
                result.alpha += rho_2 * outer(answer(3));
            }
        }
        for (std::size_t i = 0; i < texels; ++i) {
            transmittance[i] *= 1.0F - base.colour[i].w;
        }
    }
    double energy = 0.0;
    double energy_alpha = 0.0;
    double curvature = 0.0;
    double curvature_alpha = 0.0;
    const auto at = [&](int x, int y) {
        return x < 0 || y < 0 || x >= width || y >= height ? glm::dvec4(0.0)
                                                           : whole[static_cast<std::size_t>(y * width + x)];
    };
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::dvec4 c = at(x, y);
            const glm::dvec4 xx = at(x + 1, y) + at(x - 1, y) - 2.0 * c;
            const glm::dvec4 yy = at(x, y + 1) + at(x, y - 1) - 2.0 * c;
            energy += glm::dot(glm::dvec3(c), glm::dvec3(c));
            energy_alpha += c.w * c.w;
            curvature += glm::dot(glm::dvec3(xx), glm::dvec3(xx)) + glm::dot(glm::dvec3(yy), glm::dvec3(yy));
            curvature_alpha += xx.w * xx.w + yy.w * yy.w;
        }
    }
    result.radiance = energy > 0.0 ? result.radiance / energy : glm::dmat3(0.0);
    result.alpha = energy_alpha > 0.0 ? result.alpha / energy_alpha : glm::dmat3(0.0);
    result.resample = linear_loss * std::sqrt(std::max(energy > 0.0 ? curvature / energy : 0.0,
                                                       energy_alpha > 0.0 ? curvature_alpha / energy_alpha : 0.0));
    return result;
}

} // namespace alpenglow::impostors
