// A cloud of Gaussian blobs whose optical depths are exact: what the tests and benchmarks of impostors draw. Extinction
// is a sum of Gaussians, so that any stretch of a ray has its optical depth in closed form (erf); radiance is summed
// over steps, each weighted with the blobs in it, so that only the blend of colours within a step is approximate.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/impostors/capture.hpp>

namespace alpenglow::test {

struct Blob {
    glm::dvec3 centre_m{0.0};
    double sigma_m = 1.0;
    double extinction_per_m = 0.1; // at its centre
    float key = 1.0F;              // source radiance over the key light's illuminance
    float fill = 0.3F;
};

struct BlobCloud {
    std::vector<Blob> blobs;
    impostors::Sphere bounds;
    int steps = 48; // over the bounds
};

// Optical depth from a to b along the ray, of blobs that are Gaussians along it.
struct RayBlob {
    double amplitude; // extinction at the closest point x sigma x sqrt(pi / 2)
    double t;         // of the closest point
    double inverse;   // 1 / (sqrt(2) sigma)
    float key;
    float fill;
};

inline double optical_depth(const Blob& blob, const glm::dvec3& from, const glm::dvec3& direction, double length_m) {
    const glm::dvec3 p = blob.centre_m - from;
    const double t = glm::dot(p, direction);
    const glm::dvec3 off = p - t * direction;
    const double amplitude = blob.extinction_per_m * blob.sigma_m * std::sqrt(1.5707963267948966) *
                             std::exp(-std::min(700.0, glm::dot(off, off) / (2.0 * blob.sigma_m * blob.sigma_m)));
    const double inverse = 1.0 / (std::sqrt(2.0) * blob.sigma_m);
    return amplitude * (std::erf((length_m - t) * inverse) - std::erf(-t * inverse));
}

// A heap of `count` blobs in a ball of radius 1 about the origin, lit by `to_key`; blobs are `detail` times smaller
// than usual.
inline BlobCloud make_blob_cloud(int count, std::uint32_t seed, const glm::dvec3& to_key = {0.3, 0.4, 0.866},
                                 double optical_thickness = 6.0, double detail = 1.0) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    BlobCloud cloud;
    for (int i = 0; i < count; ++i) {
        const double z = 2.0 * uniform(random) - 1.0;
        const double phi = 6.283185307179586 * uniform(random);
        const double flat = std::sqrt(1.0 - z * z);
        Blob blob;
        blob.sigma_m = (0.05 + 0.11 * uniform(random) * uniform(random)) / detail;
        const double r = (1.0 - 4.0 * blob.sigma_m) * std::cbrt(uniform(random));
        blob.centre_m = r * glm::dvec3(flat * std::cos(phi), flat * std::sin(phi), 0.6 * z);
        blob.extinction_per_m = 0.5 + uniform(random);
        cloud.blobs.push_back(blob);
    }
    // Scaled so that the mean line through the middle has this optical depth.
    double depth = 0.0;
    for (const Blob& blob : cloud.blobs) {
        for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
            depth += optical_depth(blob, -axis, axis, 2.0) / 3.0;
        }
    }
    const double scale = optical_thickness / std::max(depth, 1e-3);
    for (Blob& blob : cloud.blobs) {
        blob.extinction_per_m *= scale;
    }
    for (Blob& blob : cloud.blobs) {
        double shadow = 0.0;
        double sky = 0.0;
        for (const Blob& other : cloud.blobs) {
            shadow += optical_depth(other, blob.centre_m, glm::normalize(to_key), 3.0);
            sky += optical_depth(other, blob.centre_m, {0.0, 0.0, 1.0}, 3.0);
        }
        blob.key = static_cast<float>(0.15 + std::exp(-0.4 * shadow));
        blob.fill = static_cast<float>(0.2 + 0.4 * std::exp(-0.2 * sky));
    }
    cloud.bounds = {glm::dvec3(0.0), 1.0};
    return cloud;
}

// Draws the matter between consecutive axis depths into one image each. `images` has edges.size() - 1 slabs, or a slab
// request of a Drawable. Blobs end at 4 sigma.
inline void draw_blobs(const BlobCloud& cloud, const impostors::CaptureRequest& request,
                       std::span<impostors::SlabImage> slabs) {
    const impostors::Frustum& view = request.view;
    for (impostors::SlabImage& slab : slabs) {
        slab.fill.assign(slab.colour.size(), glm::vec3(0.0F));
    }
    const double step = 2.0 * cloud.bounds.radius_m / cloud.steps;
    const auto rows = [&](std::size_t first, std::size_t last) {
        std::vector<RayBlob> near;
        for (std::size_t j = first; j < last; ++j) {
            for (int i = 0; i < view.width; ++i) {
                const glm::dvec3 along = view.direction(i + 0.5, static_cast<double>(j) + 0.5);
                const double per_depth = glm::length(along); // path over axis depth
                const glm::dvec3 direction = along / per_depth;
                near.clear();
                double enter = std::numeric_limits<double>::infinity();
                double leave = -enter;
                for (const Blob& blob : cloud.blobs) {
                    const glm::dvec3 p = blob.centre_m - view.eye_m;
                    const double t = glm::dot(p, direction);
                    const glm::dvec3 off = p - t * direction;
                    const double d2 = glm::dot(off, off) / (blob.sigma_m * blob.sigma_m);
                    if (d2 > 16.0) {
                        continue;
                    }
                    // Ends at 4 sigma without a step: what is left there is taken away.
                    near.push_back({blob.extinction_per_m * blob.sigma_m * 1.2533141373155003 *
                                        (std::exp(-0.5 * d2) - std::exp(-8.0)),
                                    t, 0.7071067811865476 / blob.sigma_m, blob.key, blob.fill});
                    enter = std::min(enter, t - 4.0 * blob.sigma_m);
                    leave = std::max(leave, t + 4.0 * blob.sigma_m);
                }
                if (near.empty()) {
                    continue;
                }
                const auto pixel = j * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(i);
                for (std::size_t k = 0; k < slabs.size(); ++k) {
                    const double from = std::max(enter, std::max(0.0, request.edges_m[k]) * per_depth);
                    const double to = std::min(leave, request.edges_m[k + 1] * per_depth);
                    if (!(to > from)) {
                        continue;
                    }
                    const int steps = std::max(1, static_cast<int>(std::ceil((to - from) / step)));
                    double transmittance = 1.0;
                    double key = 0.0;
                    double fill = 0.0;
                    double s_1 = 0.0;
                    double s_2 = 0.0;
                    for (int n = 0; n < steps; ++n) {
                        const double a = from + (to - from) * n / steps;
                        const double b = from + (to - from) * (n + 1) / steps;
                        double tau = 0.0;
                        double tau_key = 0.0;
                        double tau_fill = 0.0;
                        for (const RayBlob& blob : near) {
                            const double x = (a - blob.t) * blob.inverse;
                            const double y = (b - blob.t) * blob.inverse;
                            if (y < -3.5 || x > 3.5) {
                                continue;
                            }
                            const double part = blob.amplitude * (std::erf(y) - std::erf(x));
                            tau += part;
                            tau_key += part * static_cast<double>(blob.key);
                            tau_fill += part * static_cast<double>(blob.fill);
                        }
                        if (tau <= 0.0) {
                            continue;
                        }
                        const double kept = transmittance * -std::expm1(-tau);
                        key += kept * tau_key / tau;
                        fill += kept * tau_fill / tau;
                        const double s = (0.5 * (a + b) / per_depth - request.depth_origin_m) / request.depth_scale_m;
                        s_1 += kept * s;
                        s_2 += kept * s * s;
                        transmittance -= kept;
                        if (transmittance < 1e-6) {
                            break;
                        }
                    }
                    impostors::SlabImage& slab = slabs[k];
                    slab.colour[pixel] = glm::vec4(request.lights.key * static_cast<float>(key),
                                                   static_cast<float>(1.0 - transmittance));
                    slab.fill[pixel] = request.lights.fill * static_cast<float>(fill);
                    slab.depth[pixel] = {static_cast<float>(s_1), static_cast<float>(s_2)};
                }
            }
        }
    };
    parallel_for(static_cast<std::size_t>(view.height), 4, rows);
}

inline impostors::Drawable drawable(const BlobCloud& cloud) {
    return [&cloud](const impostors::CaptureRequest& request, std::span<impostors::SlabImage> slabs) -> Status {
        draw_blobs(cloud, request, slabs);
        return Ok{};
    };
}

// The cloud drawn directly: premultiplied radiance of both lights, and alpha.
inline std::vector<glm::vec4> draw_directly(const BlobCloud& cloud, const impostors::Frustum& view,
                                            const impostors::Lights& lights = {}) {
    impostors::CaptureRequest request;
    request.view = view;
    request.edges_m = {0.0, 1e9};
    request.lights = lights;
    std::vector<impostors::SlabImage> slab(1);
    const auto pixels = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
    slab[0].colour.assign(pixels, glm::vec4(0.0F));
    slab[0].depth.assign(pixels, glm::vec2(0.0F));
    draw_blobs(cloud, request, slab);
    for (std::size_t i = 0; i < pixels; ++i) {
        slab[0].colour[i] += glm::vec4(slab[0].fill[i], 0.0F);
    }
    return slab[0].colour;
}

// Relative RMSE over radiance, and over alpha: the worse.
inline double relative_rmse(std::span<const glm::vec4> image, std::span<const glm::vec4> exact) {
    double error = 0.0, energy = 0.0, error_alpha = 0.0, energy_alpha = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        const glm::dvec4 e(exact[i]);
        const glm::dvec4 d = glm::dvec4(image[i]) - e;
        error += glm::dot(glm::dvec3(d), glm::dvec3(d));
        energy += glm::dot(glm::dvec3(e), glm::dvec3(e));
        error_alpha += d.w * d.w;
        energy_alpha += e.w * e.w;
    }
    return std::sqrt(
        std::max(energy > 0.0 ? error / energy : 0.0, energy_alpha > 0.0 ? error_alpha / energy_alpha : 0.0));
}

// PSNR in dB over a sky of radiance `sky`, tone mapped by x / (1 + x) and gamma 2.2, over the pixels where either image
// has alpha over 1/255.
inline double tone_mapped_psnr(std::span<const glm::vec4> image, std::span<const glm::vec4> exact,
                               const glm::vec3& sky = {0.3F, 0.45F, 0.8F}) {
    double error = 0.0;
    std::size_t count = 0;
    const auto tone = [](float v) { return std::pow(static_cast<double>(v / (1.0F + v)), 1.0 / 2.2); };
    for (std::size_t i = 0; i < exact.size(); ++i) {
        if (std::max(image[i].w, exact[i].w) < 1.0F / 255.0F) {
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            const double d =
                tone(image[i][c] + (1.0F - image[i].w) * sky[c]) - tone(exact[i][c] + (1.0F - exact[i].w) * sky[c]);
            error += d * d;
            ++count;
        }
    }
    return error > 0.0 ? -10.0 * std::log10(error / static_cast<double>(count)) : 200.0;
}

} // namespace alpenglow::test
