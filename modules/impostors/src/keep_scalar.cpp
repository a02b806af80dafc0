#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "keep.hpp"
#include "sensitivity.hpp"

namespace alpenglow::impostors {
namespace {

// c - (difference of second order) / 12 in both directions, within the range of the five texels.
template <class T>
void sharpen(std::vector<T>& image, int width, int height, bool open_edges) {
    if (image.empty()) {
        return;
    }
    const std::vector<T> from = image;
    const auto at = [&](int x, int y) {
        if (open_edges) {
            x = std::clamp(x, 0, width - 1);
            y = std::clamp(y, 0, height - 1);
        } else if (x < 0 || y < 0 || x >= width || y >= height) {
            return T(0.0F);
        }
        return from[static_cast<std::size_t>(y * width + x)];
    };
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const T c = at(x, y);
            const T l = at(x - 1, y);
            const T r = at(x + 1, y);
            const T u = at(x, y - 1);
            const T d = at(x, y + 1);
            const T least = glm::min(glm::min(c, glm::min(l, r)), glm::min(u, d));
            const T greatest = glm::max(glm::max(c, glm::max(l, r)), glm::max(u, d));
            image[static_cast<std::size_t>(y * width + x)] =
                glm::clamp(c + (4.0F * c - l - r - u - d) * (1.0F / 12.0F), least, greatest);
        }
    }
}

void find_occupied(Layer& layer) {
    const MipLevel& base = layer.mips.front();
    const int w = (base.width + 7) / 8;
    const int h = (base.height + 7) / 8;
    layer.occupied.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0);
    for (int y = 0; y < base.height; ++y) {
        for (int x = 0; x < base.width; ++x) {
            const auto i = static_cast<std::size_t>(y * base.width + x);
            if (base.colour[i] == glm::vec4(0.0F) && (base.fill.empty() || base.fill[i] == glm::vec4(0.0F))) {
                continue;
            }
            for (int by = std::max(0, y / 8 - 1); by <= std::min(h - 1, y / 8 + 1); ++by) {
                for (int bx = std::max(0, x / 8 - 1); bx <= std::min(w - 1, x / 8 + 1); ++bx) {
                    layer.occupied[static_cast<std::size_t>(by * w + bx)] = 1;
                }
            }
        }
    }
}

// Averages of 2 x 2; beyond an odd border lies transparency, so that coverage is kept.
template <class T>
std::vector<T> halve(const std::vector<T>& from, int width, int height) {
    if (from.empty()) {
        return {};
    }
    const int w = (width + 1) / 2;
    const int h = (height + 1) / 2;
    std::vector<T> to(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), T(0.0F));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            to[static_cast<std::size_t>((y / 2) * w + x / 2)] += 0.25F * from[static_cast<std::size_t>(y * width + x)];
        }
    }
    return to;
}

void build_mips(Layer& layer) {
    while (layer.mips.back().width > 1 || layer.mips.back().height > 1) {
        const MipLevel& from = layer.mips.back();
        MipLevel to;
        to.width = (from.width + 1) / 2;
        to.height = (from.height + 1) / 2;
        to.colour = halve(from.colour, from.width, from.height);
        to.fill = halve(from.fill, from.width, from.height);
        to.depth = halve(from.depth, from.width, from.height);
        layer.mips.push_back(std::move(to));
    }
}

// All layers together, front to back, at one level; a fill light's part apart.
struct Composite {
    std::vector<glm::vec4> colour;
    std::vector<glm::vec4> fill;
};
Composite composite(const std::vector<Layer>& layers, std::size_t level) {
    const MipLevel& first = layers.front().mips[level];
    Composite sum{std::vector<glm::vec4>(first.colour.size(), glm::vec4(0.0F)),
                  std::vector<glm::vec4>(first.fill.size(), glm::vec4(0.0F))};
    for (const Layer& layer : layers) {
        const MipLevel& mip = layer.mips[level];
        for (std::size_t i = 0; i < mip.colour.size(); ++i) {
            const float left = 1.0F - sum.colour[i].w;
            sum.colour[i] += left * mip.colour[i];
            if (!sum.fill.empty() && !mip.fill.empty()) {
                sum.fill[i] += left * mip.fill[i];
            }
        }
    }
    return sum;
}

// Scales optical depths and radiances of the coarser levels so that all layers together show the average of what they
// show at full resolution.
void match_mips(std::vector<Layer>& layers) {
    Composite target = composite(layers, 0);
    for (std::size_t level = 1; level < layers.front().mips.size(); ++level) {
        const MipLevel& finer = layers.front().mips[level - 1];
        target.colour = halve(target.colour, finer.width, finer.height);
        target.fill = halve(target.fill, finer.width, finer.height);
        const Composite now = composite(layers, level);
        for (std::size_t i = 0; i < now.colour.size(); ++i) {
            const float want = std::min(target.colour[i].w, 0.9999F);
            const float have = std::min(now.colour[i].w, 0.9999F);
            if (have <= 1e-6F || want <= 1e-6F) {
                continue;
            }
            const float power = std::log1p(-want) / std::log1p(-have);
            for (Layer& layer : layers) {
                MipLevel& mip = layer.mips[level];
                const float alpha = mip.colour[i].w;
                if (alpha <= 0.0F) {
                    continue;
                }
                const float scale = alpha < 1.0F ? -std::expm1(power * std::log1p(-alpha)) / alpha : 1.0F;
                mip.colour[i] *= scale;
                mip.depth[i] *= scale;
                if (!mip.fill.empty()) {
                    mip.fill[i] *= scale;
                }
            }
        }
        const Composite then = composite(layers, level);
        const auto ratio = [](const glm::vec4& wanted, const glm::vec4& got) {
            glm::vec4 r(1.0F);
            for (int c = 0; c < 3; ++c) {
                r[c] = got[c] > 1e-30F ? std::clamp(wanted[c] / got[c], 0.25F, 4.0F) : 1.0F;
            }
            return r;
        };
        for (std::size_t i = 0; i < then.colour.size(); ++i) {
            const glm::vec4 key = ratio(target.colour[i], then.colour[i]);
            const glm::vec4 fill = then.fill.empty() ? glm::vec4(1.0F) : ratio(target.fill[i], then.fill[i]);
            for (Layer& layer : layers) {
                layer.mips[level].colour[i] *= key;
                if (!layer.mips[level].fill.empty()) {
                    layer.mips[level].fill[i] *= fill;
                }
            }
        }
    }
}

// Mean s of each texel, from its own level in proportion to its alpha and from the coarser levels for the rest: the map
// runs on smoothly past the rim, where a warp has to find its way in (a pull-push pyramid).
std::vector<float> continued_depth(const Layer& layer, double plane_s) {
    std::vector<float> coarse{static_cast<float>(plane_s)};
    int coarse_width = 1;
    int coarse_height = 1;
    for (std::size_t level = layer.mips.size(); level-- > 0;) {
        const MipLevel& mip = layer.mips[level];
        std::vector<float> map(mip.colour.size());
        for (int y = 0; y < mip.height; ++y) {
            for (int x = 0; x < mip.width; ++x) {
                const auto i = static_cast<std::size_t>(y * mip.width + x);
                // Bilinear from the coarser level.
                const float u = 0.5F * (static_cast<float>(x) + 0.5F) - 0.5F;
                const float v = 0.5F * (static_cast<float>(y) + 0.5F) - 0.5F;
                const int x0 = std::clamp(static_cast<int>(std::floor(u)), 0, coarse_width - 1);
                const int y0 = std::clamp(static_cast<int>(std::floor(v)), 0, coarse_height - 1);
                const int x1 = std::min(x0 + 1, coarse_width - 1);
                const int y1 = std::min(y0 + 1, coarse_height - 1);
                const float fu = std::clamp(u - static_cast<float>(x0), 0.0F, 1.0F);
                const float fv = std::clamp(v - static_cast<float>(y0), 0.0F, 1.0F);
                const auto at = [&](int cx, int cy) {
                    return coarse[static_cast<std::size_t>(cy * coarse_width + cx)];
                };
                const float below = (1.0F - fv) * ((1.0F - fu) * at(x0, y0) + fu * at(x1, y0)) +
                                    fv * ((1.0F - fu) * at(x0, y1) + fu * at(x1, y1));
                const float alpha = mip.colour[i].w;
                constexpr float trust = 0.004F; // an alpha that speaks for itself: about one step of 8 bits
                map[i] = (mip.depth[i].x + trust * below) / (alpha + trust);
            }
        }
        coarse = std::move(map);
        coarse_width = mip.width;
        coarse_height = mip.height;
    }
    return coarse;
}

// The map as a mesh with a node at every `cell` texels has it: nodes take the mean of the texels around them, weighted
// by a tent and by what is there to be seen.
std::vector<float> bent_at_nodes(const std::vector<float>& map, const MipLevel& base, int cell) {
    const int across = (base.width + cell - 1) / cell + 1;
    const int down = (base.height + cell - 1) / cell + 1;
    std::vector<float> node(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i) {
            float sum = 0.0F;
            float weights = 0.0F;
            for (int y = std::max(0, (j - 1) * cell); y < std::min(base.height, (j + 1) * cell); ++y) {
                for (int x = std::max(0, (i - 1) * cell); x < std::min(base.width, (i + 1) * cell); ++x) {
                    const auto at = static_cast<std::size_t>(y * base.width + x);
                    const auto size = static_cast<float>(cell);
                    const float u = 1.0F - std::abs(static_cast<float>(x - i * cell) + 0.5F) / size;
                    const float v = 1.0F - std::abs(static_cast<float>(y - j * cell) + 0.5F) / size;
                    const float weight = u * v * (base.colour[at].w + 1e-3F);
                    sum += weight * map[at];
                    weights += weight;
                }
            }
            const int x = std::min(i * cell, base.width - 1);
            const int y = std::min(j * cell, base.height - 1);
            node[static_cast<std::size_t>(j * across + i)] =
                weights > 0.0F ? sum / weights : map[static_cast<std::size_t>(y * base.width + x)];
        }
    }
    std::vector<float> bent(map.size());
    for (int y = 0; y < base.height; ++y) {
        for (int x = 0; x < base.width; ++x) {
            const float u = (static_cast<float>(x) + 0.5F) / static_cast<float>(cell);
            const float v = (static_cast<float>(y) + 0.5F) / static_cast<float>(cell);
            const int i = static_cast<int>(u);
            const int j = static_cast<int>(v);
            const float s = u - static_cast<float>(i);
            const float t = v - static_cast<float>(j);
            const auto at = [&](int a, int b) { return node[static_cast<std::size_t>(b * across + a)]; };
            bent[static_cast<std::size_t>(y * base.width + x)] =
                (1.0F - t) * ((1.0F - s) * at(i, j) + s * at(i + 1, j)) +
                t * ((1.0F - s) * at(i, j + 1) + s * at(i + 1, j + 1));
        }
    }
    return bent;
}

} // namespace

std::size_t sanitise(std::span<glm::vec4> colour, std::span<glm::vec3> fill, std::span<glm::vec2> depth) {
    std::size_t rejected = 0;
    constexpr float greatest = 1e30F; // squares of sums stay finite in double, and averages in float
    for (std::size_t i = 0; i < colour.size(); ++i) {
        glm::vec4& c = colour[i];
        glm::vec2& d = depth[i];
        glm::vec3* f = fill.empty() ? nullptr : &fill[i];
        const auto within = [](float v) { return std::isgreaterequal(v, 0.0F) && std::islessequal(v, greatest); };
        const bool fill_ok = f == nullptr || (within(f->x) && within(f->y) && within(f->z));
        const bool depth_finite = std::isfinite(d.x) && std::isfinite(d.y);
        if (within(c.x) && within(c.y) && within(c.z) && within(c.w) && c.w <= 1.0F && fill_ok && depth_finite) {
            // Rounding alone puts moments a hair outside; that is no fault.
            d.x = std::clamp(d.x, -c.w, c.w);
            d.y = c.w > 0.0F ? std::clamp(d.y, d.x * d.x / c.w, c.w) : 0.0F;
            continue;
        }
        const bool finite = std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z) && std::isfinite(c.w) &&
                            depth_finite &&
                            (f == nullptr || (std::isfinite(f->x) && std::isfinite(f->y) && std::isfinite(f->z)));
        // A rounding error below zero or above one is no fault either, but is put right.
        if (!finite || c.w > 1.0F + 1e-4F || std::min({c.x, c.y, c.z, c.w}) < -1e-4F) {
            ++rejected;
        }
        if (!finite) {
            c = glm::vec4(0.0F);
            d = glm::vec2(0.0F);
            if (f != nullptr) {
                *f = glm::vec3(0.0F);
            }
            continue;
        }
        c = glm::vec4(std::clamp(c.x, 0.0F, greatest), std::clamp(c.y, 0.0F, greatest), std::clamp(c.z, 0.0F, greatest),
                      std::clamp(c.w, 0.0F, 1.0F));
        if (f != nullptr) {
            *f = glm::vec3(std::clamp(f->x, 0.0F, greatest), std::clamp(f->y, 0.0F, greatest),
                           std::clamp(f->z, 0.0F, greatest));
        }
        d.x = std::clamp(d.x, -c.w, c.w);
        d.y = c.w > 0.0F ? std::clamp(d.y, d.x * d.x / c.w, c.w) : 0.0F;
    }
    return rejected;
}

double plane_of(const Capture& capture, double near_m, double far_m, double alpha, double depth) {
    // The paper's plane goes through the centre. Layers stand in the middle of their slab (in inverse depth, as
    // parallax goes), so that half a slab bounds how far anything is off; a warp starts from where most of the
    // matter is.
    if (warped_kind(capture.representation) && alpha > 0.0) {
        return std::clamp(capture.depth_origin_m + capture.depth_scale_m * depth / alpha, near_m, far_m);
    }
    return single_picture(capture.representation) || near_m <= 0.0 ? 0.5 * (near_m + far_m)
                                                                   : 2.0 * near_m * far_m / (near_m + far_m);
}

void keep_scalar(Capture& result, std::span<const double> edges_m, const CaptureSettings& settings,
                 std::span<SlabImage> slabs) {
    const std::size_t texels = slabs.front().colour.size();
    glm::vec4 mean(0.0F);
    float left = 1.0F;
    for (std::size_t k = 0; k < slabs.size(); ++k) {
        SlabImage& slab = slabs[k];
        result.rejected_texels += sanitise(slab.colour, slab.fill, slab.depth);
        Layer layer;
        layer.near_m = edges_m[k];
        layer.far_m = edges_m[k + 1];
        glm::dvec4 sum(0.0);
        double depth = 0.0;
        for (std::size_t i = 0; i < texels; ++i) {
            sum += glm::dvec4(slab.colour[i]);
            if (!slab.fill.empty()) {
                sum += glm::dvec4(glm::dvec3(slab.fill[i]), 0.0);
            }
            depth += static_cast<double>(slab.depth[i].x);
        }
        layer.plane_m = plane_of(result, layer.near_m, layer.far_m, sum.w, depth);
        const glm::vec4 shown = left * glm::vec4(sum / static_cast<double>(texels));
        mean += shown;
        left -= shown.w;
        MipLevel base;
        base.width = result.view.width;
        base.height = result.view.height;
        base.colour = std::move(slab.colour);
        base.depth = std::move(slab.depth);
        if (!slab.fill.empty()) {
            base.fill.resize(texels);
            for (std::size_t i = 0; i < texels; ++i) {
                base.fill[i] = glm::vec4(slab.fill[i], 0.0F);
            }
        }
        layer.mips.push_back(std::move(base));
        build_mips(layer);
        find_occupied(layer);
        if (warped_kind(settings.representation)) {
            layer.warp = continued_depth(layer, (layer.plane_m - result.depth_origin_m) / result.depth_scale_m);
            if (settings.warp_cell > 1) {
                layer.warp = bent_at_nodes(layer.warp, layer.mips.front(), settings.warp_cell);
            }
        }
        result.layers.push_back(std::move(layer));
    }
    result.mean = mean;
    if (!settings.mips) {
        for (Layer& layer : result.layers) {
            layer.mips.resize(1);
        }
    } else if (result.layers.size() > 1) {
        match_mips(result.layers);
    }
    result.sensitivity = measure_sensitivity(result);
    if (settings.sharpen) { // after the mips: coarser levels are averages, with nothing to make good
        for (Layer& layer : result.layers) {
            MipLevel& base = layer.mips.front();
            std::vector<float> before(texels);
            for (std::size_t i = 0; i < texels; ++i) {
                before[i] = base.colour[i].w;
            }
            sharpen(base.colour, base.width, base.height, settings.open_edges);
            sharpen(base.fill, base.width, base.height, settings.open_edges);
            for (std::size_t i = 0; i < texels; ++i) {
                base.depth[i] *= before[i] > 0.0F ? base.colour[i].w / before[i] : 0.0F;
            }
        }
    }
}

} // namespace alpenglow::impostors
