#include <alpenglow/impostors/reproject.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include "resample.hpp"

namespace alpenglow::impostors {
namespace {

// One texel's worth of a layer: radiance of both lights together, alpha, moments of depth.
struct Sample {
    glm::vec4 colour{0.0F};
    glm::vec2 depth{0.0F};
};

// A layer as it is about to be drawn: which mips, with what lights.
struct LayerView {
    const Layer* layer = nullptr;
    double w_plane = 0.0; // 1 / axis depth of its plane
    double z_plane = 0.0;
    int level = 0;     // the finer of two mips
    float fine = 1.0F; // weight of the finer one
    bool warped = false;
    double spread = 0.0; // of 1 / depth over its slab, from its plane
    int search = 0;      // steps through the slab of a warp that moves texels far; 0: fixed point
    int blocks_across = 0;
};

// How a layer is read.
struct Reading {
    LightGain gain;
    Filter filter = Filter::bilinear;
    bool open_edges = false;
    float cubic_b = 0.0F; // at level 0
};

Sample texel(const MipLevel& mip, const Reading& reading, int x, int y) {
    const LightGain& gain = reading.gain;
    if (reading.open_edges) {
        x = std::clamp(x, 0, mip.width - 1);
        y = std::clamp(y, 0, mip.height - 1);
    } else if (x < 0 || y < 0 || x >= mip.width || y >= mip.height) {
        return {};
    }
    const auto i = static_cast<std::size_t>(y * mip.width + x);
    Sample s{mip.colour[i] * glm::vec4(gain.key, 1.0F), mip.depth[i]};
    if (!mip.fill.empty()) {
        s.colour += mip.fill[i] * glm::vec4(gain.fill, 0.0F);
    }
    return s;
}

// u, v in texels of this level, centres at halves; transparent outside.
Sample bilinear(const MipLevel& mip, const Reading& reading, float u, float v) {
    const float fx = std::floor(u - 0.5F);
    const float fy = std::floor(v - 0.5F);
    const int x = static_cast<int>(fx);
    const int y = static_cast<int>(fy);
    const float s = u - 0.5F - fx;
    const float t = v - 0.5F - fy;
    const Sample a = texel(mip, reading, x, y);
    const Sample b = texel(mip, reading, x + 1, y);
    const Sample c = texel(mip, reading, x, y + 1);
    const Sample d = texel(mip, reading, x + 1, y + 1);
    const float wa = (1.0F - s) * (1.0F - t);
    const float wb = s * (1.0F - t);
    const float wc = (1.0F - s) * t;
    const float wd = s * t;
    return {wa * a.colour + wb * b.colour + wc * c.colour + wd * d.colour,
            wa * a.depth + wb * b.depth + wc * c.depth + wd * d.depth};
}

// Colour alone, all four texels inside: nearly every pixel's case.
glm::vec4 bilinear_colour(const MipLevel& mip, const Reading& reading, float u, float v) {
    const float fx = std::floor(u - 0.5F);
    const float fy = std::floor(v - 0.5F);
    const int x = static_cast<int>(fx);
    const int y = static_cast<int>(fy);
    if (x < 0 || y < 0 || x + 1 >= mip.width || y + 1 >= mip.height) {
        return bilinear(mip, reading, u, v).colour;
    }
    const float s = u - 0.5F - fx;
    const float t = v - 0.5F - fy;
    const auto i = static_cast<std::size_t>(y * mip.width + x);
    const auto below = i + static_cast<std::size_t>(mip.width);
    const float wb = s * (1.0F - t);
    const float wc = (1.0F - s) * t;
    const float wd = s * t;
    const float wa = 1.0F - wb - wc - wd;
    const auto mix = [&](const std::vector<glm::vec4>& image) {
        return wa * image[i] + wb * image[i + 1] + wc * image[below] + wd * image[below + 1];
    };
    const glm::vec4 key = mix(mip.colour) * glm::vec4(reading.gain.key, 1.0F);
    return mip.fill.empty() ? key : key + mix(mip.fill) * glm::vec4(reading.gain.fill, 0.0F);
}

// Of 16 texels. Mitchell and Netravali's cubics with 2 C + B = 1 take B / 6 of the second difference off a picture: B =
// 0 is Catmull and Rom's, which takes nothing, and B = 1/2 is what fits a picture that had 1/12 of it added beforehand.
Sample cubic(const MipLevel& mip, const Reading& reading, float b, float u, float v) {
    const float fx = std::floor(u - 0.5F);
    const float fy = std::floor(v - 0.5F);
    const int x = static_cast<int>(fx);
    const int y = static_cast<int>(fy);
    const auto weights = [b](float t) {
        const float t2 = t * t;
        const float t3 = t2 * t;
        const float k = b / 6.0F;
        return std::array<float, 4>{-0.5F * t3 + t2 - 0.5F * t + k * (2.0F * t3 - 3.0F * t2 + 1.0F),
                                    1.5F * t3 - 2.5F * t2 + 1.0F + k * (-6.0F * t3 + 9.0F * t2 - 2.0F),
                                    -1.5F * t3 + 2.0F * t2 + 0.5F * t + k * (6.0F * t3 - 9.0F * t2 + 1.0F),
                                    0.5F * t3 - 0.5F * t2 + k * (-2.0F * t3 + 3.0F * t2)};
    };
    const std::array<float, 4> wx = weights(u - 0.5F - fx);
    const std::array<float, 4> wy = weights(v - 0.5F - fy);
    Sample sum;
    for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
            const Sample s = texel(mip, reading, x + i - 1, y + j - 1);
            const float w = wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)];
            sum.colour += w * s.colour;
            sum.depth += w * s.depth;
        }
    }
    // It overshoots: light and matter stay what they can be.
    sum.colour = glm::max(sum.colour, glm::vec4(0.0F));
    sum.colour.w = std::min(sum.colour.w, 1.0F);
    sum.depth.x = std::clamp(sum.depth.x, -sum.colour.w, sum.colour.w);
    sum.depth.y = std::clamp(sum.depth.y, 0.0F, sum.colour.w);
    return sum;
}

float bilinear_warp(const Layer& layer, float u, float v) {
    const int width = layer.mips.front().width;
    const int height = layer.mips.front().height;
    const float x = std::clamp(u - 0.5F, 0.0F, static_cast<float>(width - 1));
    const float y = std::clamp(v - 0.5F, 0.0F, static_cast<float>(height - 1));
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, width - 1);
    const int y1 = std::min(y0 + 1, height - 1);
    const float s = x - static_cast<float>(x0);
    const float t = y - static_cast<float>(y0);
    const auto at = [&](int i, int j) { return layer.warp[static_cast<std::size_t>(j * width + i)]; };
    return (1.0F - t) * ((1.0F - s) * at(x0, y0) + s * at(x1, y0)) + t * ((1.0F - s) * at(x0, y1) + s * at(x1, y1));
}

Sample fetch(const LayerView& view, const Reading& reading, float u, float v) {
    const auto at = [&](int level) {
        const float scale = 1.0F / static_cast<float>(1 << level);
        const MipLevel& mip = view.layer->mips[static_cast<std::size_t>(level)];
        return reading.filter == Filter::cubic
                   ? cubic(mip, reading, level == 0 ? reading.cubic_b : 0.0F, u * scale, v * scale)
                   : bilinear(mip, reading, u * scale, v * scale);
    };
    Sample s = at(view.level);
    if (view.fine < 1.0F) {
        const Sample coarse = at(view.level + 1);
        s.colour = view.fine * s.colour + (1.0F - view.fine) * coarse.colour;
        s.depth = view.fine * s.depth + (1.0F - view.fine) * coarse.depth;
    }
    return s;
}

glm::vec4 fetch_colour(const LayerView& view, const Reading& reading, float u, float v) {
    if (reading.filter == Filter::cubic) {
        return fetch(view, reading, u, v).colour;
    }
    const auto at = [&](int level) {
        const float scale = 1.0F / static_cast<float>(1 << level);
        return bilinear_colour(view.layer->mips[static_cast<std::size_t>(level)], reading, u * scale, v * scale);
    };
    const glm::vec4 c = at(view.level);
    return view.fine < 1.0F ? view.fine * c + (1.0F - view.fine) * at(view.level + 1) : c;
}

// The inverse depth at which a ray first meets a warp's surface: steps from the front of the slab to its back, then two
// of regula falsi. `above` is how much nearer (in inverse depth) the surface is than the ray: at most 0 in front, at
// least 0 at the back.
template <class Above>
double first_crossing(const LayerView& view, const Above& above) {
    const double front = 1.0 / view.layer->near_m;
    const double back = 1.0 / view.layer->far_m;
    double w0 = front;
    double f0 = above(front);
    double w1 = front;
    double f1 = f0;
    for (int k = 1; k <= view.search && f1 < 0.0; ++k) {
        w0 = w1;
        f0 = f1;
        w1 = front + (back - front) * (static_cast<double>(k) / view.search);
        f1 = above(w1);
    }
    const auto between = [&] { return f1 > f0 ? w0 + (w1 - w0) * (f0 / (f0 - f1)) : w1; };
    const double w = between();
    const double f = above(w);
    (f < 0.0 ? w0 : w1) = w;
    (f < 0.0 ? f0 : f1) = f;
    return between();
}

// The pixels that any layer can reach: the projected corners of the first and the last slab.
PixelRect footprint(const Capture& capture, const Frustum& view) {
    double left = std::numeric_limits<double>::infinity();
    double top = left;
    double right = -left;
    double bottom = -left;
    const Frustum& c = capture.view;
    for (const double z : {capture.layers.front().near_m, capture.layers.back().far_m}) {
        for (int corner = 0; corner < 4; ++corner) {
            const double u = (corner & 1) != 0 ? c.tan_right : c.tan_left;
            const double v = (corner & 2) != 0 ? c.tan_top : c.tan_bottom;
            const glm::dvec3 p = c.eye_m + z * (c.forward + u * c.right + v * c.up) - view.eye_m;
            const double depth = glm::dot(p, view.forward);
            if (!(depth > 1e-9 * glm::length(p))) {
                return {0, 0, view.width, view.height};
            }
            const double x = (glm::dot(p, view.right) / depth - view.tan_left) * view.pixels_per_tan_x();
            const double y = (view.tan_top - glm::dot(p, view.up) / depth) * view.pixels_per_tan_y();
            left = std::min(left, x);
            right = std::max(right, x);
            top = std::min(top, y);
            bottom = std::max(bottom, y);
        }
    }
    const auto pixel = [](double v, int size) {
        return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
    };
    return {pixel(std::floor(left), view.width), pixel(std::floor(top), view.height),
            pixel(std::floor(right) + 1.0, view.width), pixel(std::floor(bottom) + 1.0, view.height)};
}

ResampleLayer resample_layer(const LayerView& view, float cubic_b) {
    const Layer& layer = *view.layer;
    ResampleLayer out;
    out.width = layer.mips.front().width;
    out.height = layer.mips.front().height;
    out.w_plane = static_cast<float>(view.w_plane);
    out.spread = static_cast<float>(view.spread);
    out.search = view.search;
    out.warp = view.warped ? layer.warp.data() : nullptr;
    out.near_m = static_cast<float>(layer.near_m);
    out.far_m = static_cast<float>(layer.far_m);
    out.occupied = layer.occupied.data();
    out.blocks_across = view.blocks_across;
    out.skip_by_blocks = view.level == 0;
    out.mip_count = view.fine < 1.0F ? 2 : 1;
    for (int m = 0; m < out.mip_count; ++m) {
        const MipLevel& mip = layer.mips[static_cast<std::size_t>(view.level + m)];
        out.mips[m] = {&mip.colour.front().x,
                       mip.fill.empty() ? nullptr : &mip.fill.front().x,
                       mip.width,
                       mip.height,
                       1.0F / static_cast<float>(1 << (view.level + m)),
                       m == 0 ? view.fine : 1.0F - view.fine,
                       view.level + m == 0 ? cubic_b : 0.0F};
    }
    return out;
}

std::size_t draw(const Capture& capture, const Frustum& view, const DrawSettings& settings, std::span<glm::vec4> image,
                 bool vectors);

} // namespace

float share_in_front(float alpha, float depth_1, float depth_2, float s) {
    if (!(alpha > 1e-6F)) {
        return depth_1 <= s * alpha ? 1.0F : 0.0F;
    }
    const float mean = depth_1 / alpha;
    const float variance = std::max(0.0F, depth_2 / alpha - mean * mean);
    const float half = std::sqrt(3.0F * variance);
    if (half < 1e-6F) {
        return mean <= s ? 1.0F : 0.0F;
    }
    return std::clamp(0.5F + 0.5F * (s - mean) / half, 0.0F, 1.0F);
}

std::size_t draw_scalar(const Capture& capture, const Frustum& view, const DrawSettings& settings,
                        std::span<glm::vec4> image) {
    return draw(capture, view, settings, image, false);
}

std::size_t draw(const Capture& capture, const Frustum& view, const DrawSettings& settings,
                 std::span<glm::vec4> image) {
    return draw(capture, view, settings, image, true);
}

namespace {

std::size_t draw(const Capture& capture, const Frustum& view, const DrawSettings& settings, std::span<glm::vec4> image,
                 bool vectors) {
    assert(image.size() == static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
    assert(settings.scene_depth_m.empty() || settings.scene_depth_m.size() == image.size());
    if (capture.layers.empty() || !(settings.weight > 0.0F)) {
        return 0;
    }
    const PixelRect rect = footprint(capture, view);
    if (rect.empty()) {
        return 0;
    }
    const Frustum& c = capture.view;
    // The view's eye and rays in the capture's axes.
    const auto local = [&c](const glm::dvec3& v) {
        return glm::dvec3(glm::dot(v, c.right), glm::dot(v, c.up), glm::dot(v, c.forward));
    };
    const glm::dvec3 eye = local(view.eye_m - c.eye_m);
    const glm::dvec3 ray_0 = local(view.direction(0.5, 0.5));
    const glm::dvec3 ray_x = local(view.right) / view.pixels_per_tan_x();
    const glm::dvec3 ray_y = -local(view.up) / view.pixels_per_tan_y();
    const double texels_x = c.pixels_per_tan_x();
    const double texels_y = c.pixels_per_tan_y();
    const double facing = glm::dot(view.forward, c.forward);

    // Texels of the capture that meet in a pixel, where the layer's middle is: picks the mip.
    std::vector<LayerView> layers(capture.layers.size());
    for (std::size_t k = 0; k < layers.size(); ++k) {
        // Seen from behind, the last slab is the first.
        const Layer& layer = capture.layers[facing >= 0.0 ? k : layers.size() - 1 - k];
        LayerView& v = layers[k];
        v.layer = &layer;
        v.z_plane = layer.plane_m;
        v.w_plane = 1.0 / layer.plane_m;
        v.warped = !layer.warp.empty();
        v.spread = std::max(1.0 / layer.near_m - v.w_plane, v.w_plane - 1.0 / layer.far_m);
        v.blocks_across = (layer.mips.front().width + 7) / 8;
        // Texels between where the middle ray meets the front and the back of the slab.
        const double ahead = layer.plane_m - eye.z;
        if (v.warped && ahead > 1e-9 * layer.plane_m) {
            const double moved = std::hypot(eye.x * texels_x, eye.y * texels_y) * layer.plane_m / ahead *
                                 (1.0 / layer.near_m - 1.0 / layer.far_m);
            v.search = moved < 2.0 ? 0 : static_cast<int>(std::min(8.0, std::ceil(moved / 3.5)));
        }
        const glm::dvec3 middle = c.eye_m + layer.plane_m * c.forward - view.eye_m;
        const double depth = std::max(std::abs(glm::dot(middle, view.forward)), 1e-9 * layer.plane_m);
        const double texels = std::min(texels_x, texels_y) / layer.plane_m; // per metre
        const double pixels = std::max(view.pixels_per_tan_x(), view.pixels_per_tan_y()) / depth;
        // With two texels a pixel, samples are still no sparser than those of direct drawing; a coarser level would
        // blur.
        const double level =
            std::clamp(std::log2(texels / pixels) - 1.0, 0.0, static_cast<double>(layer.mips.size() - 1));
        v.level = static_cast<int>(level);
        v.fine = static_cast<float>(1.0 - (level - v.level));
    }
    const bool sliced = settings.near_m > 0.0 || std::isfinite(settings.far_m) || !settings.scene_depth_m.empty();
    const double depth_x = glm::dot(view.forward, c.right);
    const double depth_y = glm::dot(view.forward, c.up);
    const float cubic_b = capture.sharpened ? 0.5F : 0.0F;
    const Reading reading{settings.gain, settings.filter, capture.open_edges, cubic_b};
    const double beyond = capture.open_edges ? 0.0 : 1.0;
    const auto body = [&](std::size_t first, std::size_t last) {
        for (std::size_t row = first; row < last; ++row) {
            const int j = rect.y0 + static_cast<int>(row);
            for (int i = rect.x0; i < rect.x1; ++i) {
                const glm::dvec3 v = ray_0 + static_cast<double>(i) * ray_x + static_cast<double>(j) * ray_y;
                if (std::abs(v.z) < 1e-9) {
                    continue; // along the planes
                }
                // Where the ray meets axis depth z, the capture's eye sees tangents a + b / z: linear in inverse depth.
                const double ax = v.x / v.z;
                const double ay = v.y / v.z;
                const double bx = eye.x - eye.z * ax;
                const double by = eye.y - eye.z * ay;
                const double u0 = (ax - c.tan_left) * texels_x;
                const double v0 = (c.tan_top - ay) * texels_y;
                const double u1 = bx * texels_x;
                const double v1 = -by * texels_y;
                const auto pixel =
                    static_cast<std::size_t>(j) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(i);
                double far = settings.far_m;
                if (!settings.scene_depth_m.empty()) {
                    far = std::min(far, static_cast<double>(settings.scene_depth_m[pixel]));
                }
                glm::vec4 sum(0.0F);
                for (const LayerView& layer : layers) {
                    double z = layer.z_plane;
                    double w = layer.w_plane;
                    const MipLevel& base = layer.layer->mips.front();
                    const double reach = layer.warped ? std::max(std::abs(u1), std::abs(v1)) * layer.spread : 0.0;
                    if (reach < 6.0 && layer.level == 0) { // nothing here, nor in the blocks around: nothing to find
                        const double u_plane = std::clamp(u0 + u1 * w, 0.0, base.width - 1.0);
                        const double v_plane = std::clamp(v0 + v1 * w, 0.0, base.height - 1.0);
                        if (layer.layer->occupied[static_cast<std::size_t>(
                                static_cast<int>(v_plane) / 8 * layer.blocks_across + static_cast<int>(u_plane) / 8)] ==
                            0) {
                            continue;
                        }
                    }
                    const auto depth_at = [&](double at) { // of the map where the ray is at inverse depth `at`
                        const auto s = static_cast<double>(bilinear_warp(*layer.layer, static_cast<float>(u0 + u1 * at),
                                                                         static_cast<float>(v0 + v1 * at)));
                        return std::clamp(capture.depth_origin_m + capture.depth_scale_m * s, layer.layer->near_m,
                                          layer.layer->far_m);
                    };
                    if (layer.search > 0) {
                        w = first_crossing(layer, [&](double at) { return 1.0 / depth_at(at) - at; });
                        z = 1.0 / w;
                    } else if (reach > 0.02) {
                        // The texel whose own depth puts it on this ray, by fixed point: the map changes slowly.
                        for (int step = 0; step < 3; ++step) {
                            z = depth_at(w);
                            const double before = w;
                            w = 1.0 / z;
                            if (std::abs(w - before) * (std::abs(u1) + std::abs(v1)) < 0.02) {
                                break; // texels
                            }
                        }
                    }
                    if ((z - eye.z) * v.z <= 0.0) {
                        continue; // behind the view's eye
                    }
                    const double u = u0 + u1 * w;
                    const double t = v0 + v1 * w;
                    if (!(u >= -beyond && t >= -beyond && u <= base.width + beyond && t <= base.height + beyond)) {
                        continue;
                    }
                    if (!sliced) {
                        sum +=
                            (1.0F - sum.w) * fetch_colour(layer, reading, static_cast<float>(u), static_cast<float>(t));
                        if (sum.w > 0.9995F) {
                            break;
                        }
                        continue;
                    }
                    Sample s = fetch(layer, reading, static_cast<float>(u), static_cast<float>(t));
                    if (s.colour.w > 0.0F) {
                        // The view's axis depth, in s: along this ray depth in the view is linear in depth in the
                        // capture.
                        const double per_z = (depth_x * v.x + depth_y * v.y + facing * v.z) / v.z;
                        const auto to_s = [&](double depth_m) {
                            const double capture_z = eye.z + depth_m / per_z;
                            return static_cast<float>(
                                std::clamp((capture_z - capture.depth_origin_m) / capture.depth_scale_m, -1e6, 1e6));
                        };
                        const auto in_front = [&](double depth_m) {
                            const float share = share_in_front(s.colour.w, s.depth.x, s.depth.y, to_s(depth_m));
                            return per_z > 0.0 ? share : 1.0F - share;
                        };
                        const float until = std::isfinite(far) ? in_front(far) : 1.0F;
                        const float from = settings.near_m > 0.0 ? in_front(settings.near_m) : 0.0F;
                        const float share = std::max(0.0F, until - from);
                        if (share < 1.0F) {
                            // 1 - (1 - alpha)^share, and radiance in proportion.
                            const float left = s.colour.w < 1.0F ? -std::expm1(share * std::log1p(-s.colour.w))
                                                                 : (share > 0.0F ? 1.0F : 0.0F);
                            s.colour *= left / s.colour.w;
                        }
                    }
                    sum += (1.0F - sum.w) * s.colour;
                    if (sum.w > 0.9995F) {
                        break;
                    }
                }
                image[pixel] += settings.weight * sum;
            }
        }
    };
    const std::size_t pixels =
        static_cast<std::size_t>(rect.x1 - rect.x0) * static_cast<std::size_t>(rect.y1 - rect.y0);
    if (!vectors || sliced) {
        parallel_for(static_cast<std::size_t>(rect.y1 - rect.y0), 8, body, settings.threads);
        return pixels;
    }
    std::vector<ResampleLayer> rows(layers.size());
    for (std::size_t k = 0; k < layers.size(); ++k) {
        rows[k] = resample_layer(layers[k], cubic_b);
    }
    ResampleInput input;
    input.layers = rows.data();
    input.layer_count = static_cast<int>(rows.size());
    input.eye_z = static_cast<float>(eye.z);
    input.depth_origin_m = static_cast<float>(capture.depth_origin_m);
    input.depth_scale_m = static_cast<float>(capture.depth_scale_m);
    for (int channel = 0; channel < 3; ++channel) {
        input.key[channel] = settings.gain.key[channel];
        input.fill[channel] = settings.gain.fill[channel];
    }
    input.open_edges = capture.open_edges;
    input.cubic = settings.filter == Filter::cubic;
    input.weight = settings.weight;
    parallel_for(
        static_cast<std::size_t>(rect.y1 - rect.y0), 8,
        [&](std::size_t first, std::size_t last) {
            for (std::size_t line = first; line < last; ++line) {
                const int j = rect.y0 + static_cast<int>(line);
                // Set up in double at the first pixel: what is left for float are texels of the picture.
                const glm::dvec3 v = ray_0 + static_cast<double>(rect.x0) * ray_x + static_cast<double>(j) * ray_y;
                const auto u_of = [&](const glm::dvec3& r) { return (r.x - c.tan_left * r.z) * texels_x; };
                const auto v_of = [&](const glm::dvec3& r) { return (c.tan_top * r.z - r.y) * texels_y; };
                const auto eu_of = [&](const glm::dvec3& r) { return (eye.x * r.z - eye.z * r.x) * texels_x; };
                const auto ev_of = [&](const glm::dvec3& r) { return (eye.z * r.y - eye.y * r.z) * texels_y; };
                const auto ramp = [&](const auto& form) {
                    return Ramp{static_cast<float>(form(v)), static_cast<float>(form(ray_x))};
                };
                ResampleRow row;
                row.u = ramp(u_of);
                row.v = ramp(v_of);
                row.eu = ramp(eu_of);
                row.ev = ramp(ev_of);
                row.vz = ramp([](const glm::dvec3& r) { return r.z; });
                row.pixels = rect.x1 - rect.x0;
                resample_row(input, row,
                             &image[static_cast<std::size_t>(j) * static_cast<std::size_t>(view.width) +
                                    static_cast<std::size_t>(rect.x0)]
                                  .x);
            }
        },
        settings.threads);
    return pixels;
}

} // namespace

void over(std::span<const glm::vec4> front, std::span<glm::vec4> back) {
    assert(front.size() == back.size());
    for (std::size_t i = 0; i < front.size(); ++i) {
        back[i] = front[i] + (1.0F - front[i].w) * back[i];
    }
}

} // namespace alpenglow::impostors
