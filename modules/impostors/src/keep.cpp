#include "keep.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "keep_rows.hpp"

namespace alpenglow::impostors {
namespace {

constexpr double linear_loss = 0.09128709291752769; // sqrt(1 / 120): see sensitivity.cpp

float* floats(std::vector<glm::vec4>& image) {
    return image.empty() ? nullptr : &image.front().x;
}

TexelRect coarser(const TexelRect& box) {
    return {box.x0 / 2, box.y0 / 2, (box.x1 + 1) / 2, (box.y1 + 1) / 2};
}

// Reads a slab into the layer's level 0, row by row; `alpha` and `depth_1`, if any, are planes of the picture's size.
RowSums read(SlabImage& slab, MipLevel& base, std::vector<std::uint8_t>& occupied, std::vector<float>& alpha,
             std::vector<float>& depth_1, std::size_t& rejected) {
    RowSums sums;
    const auto width = static_cast<std::size_t>(base.width);
    base.colour = std::move(slab.colour);
    base.depth = std::move(slab.depth);
    if (!slab.fill.empty()) {
        base.fill.resize(base.colour.size());
    }
    for (int y = 0; y < base.height; ++y) {
        const std::size_t first = static_cast<std::size_t>(y) * width;
        RowIn row;
        row.colour = &base.colour[first].x;
        row.depth = &base.depth[first].x;
        if (!slab.fill.empty()) {
            row.fill = &slab.fill[first].x;
            row.fill_out = &base.fill[first].x;
        }
        if (!alpha.empty()) {
            row.alpha = &alpha[first];
            row.depth_1 = &depth_1[first];
        }
        row.occupied = &occupied[static_cast<std::size_t>(y / 8) * ((width + 7) / 8)];
        row.count = base.width;
        if (!read_row(row, sums)) {
            rejected +=
                sanitise(std::span(base.colour).subspan(first, width),
                         slab.fill.empty() ? std::span<glm::vec3>{} : std::span(slab.fill).subspan(first, width),
                         std::span(base.depth).subspan(first, width));
            (void)read_row(row, sums);
        }
    }
    slab.fill = {};
    return sums;
}

// Blocks that have something in them or in a neighbour, and the box around those.
TexelRect spread(std::vector<std::uint8_t>& occupied, int width, int height) {
    const int across = (width + 7) / 8;
    const int down = (height + 7) / 8;
    std::vector<std::uint8_t> out(occupied.size(), 0);
    TexelRect box{width, height, 0, 0};
    for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i) {
            if (occupied[static_cast<std::size_t>(j * across + i)] == 0) {
                continue;
            }
            const int i0 = std::max(0, i - 1);
            const int i1 = std::min(across - 1, i + 1);
            const int j0 = std::max(0, j - 1);
            const int j1 = std::min(down - 1, j + 1);
            for (int b = j0; b <= j1; ++b) {
                std::fill(out.begin() + b * across + i0, out.begin() + b * across + i1 + 1, std::uint8_t{1});
            }
            box = {std::min(box.x0, 8 * i0), std::min(box.y0, 8 * j0), std::max(box.x1, std::min(width, 8 * i1 + 8)),
                   std::max(box.y1, std::min(height, 8 * j1 + 8))};
        }
    }
    occupied = std::move(out);
    return box;
}

void build_mips(Layer& layer, TexelRect box) {
    while (layer.mips.back().width > 1 || layer.mips.back().height > 1) {
        MipLevel to;
        MipLevel& from = layer.mips.back();
        to.width = (from.width + 1) / 2;
        to.height = (from.height + 1) / 2;
        const auto texels = static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height);
        to.colour.resize(texels);
        to.depth.resize(texels);
        if (!from.fill.empty()) {
            to.fill.resize(texels);
        }
        if (!box.empty()) {
            halve(floats(from.colour), from.width, from.width, from.height, box, 4, floats(to.colour), to.width);
            halve(&from.depth.front().x, from.width, from.width, from.height, box, 2, &to.depth.front().x, to.width);
            if (!from.fill.empty()) {
                halve(floats(from.fill), from.width, from.width, from.height, box, 4, floats(to.fill), to.width);
            }
        }
        box = coarser(box);
        layer.mips.push_back(std::move(to));
    }
}

// Pull and push over planes of alpha and of the first moment: see continued_depth in keep_scalar.cpp.
struct DepthPyramid {
    struct Level {
        int width = 0, height = 0;
        std::vector<float> alpha, depth_1, map;
    };
    std::vector<Level> levels; // 0 is filled by read()
    std::vector<float> scratch;

    DepthPyramid(int width, int height) {
        for (;;) {
            const auto texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
            levels.push_back({width, height, std::vector<float>(texels), std::vector<float>(texels), {}});
            if (levels.size() > 1) {
                levels.back().map.resize(texels);
            }
            if (width == 1 && height == 1) {
                break;
            }
            width = (width + 1) / 2;
            height = (height + 1) / 2;
        }
        scratch.resize(2 * static_cast<std::size_t>(levels.front().width + 32) + 16);
    }

    std::vector<float> continued(TexelRect box, float plane_s) {
        std::vector<float> map(levels.front().alpha.size());
        if (box.empty()) {
            std::fill(map.begin(), map.end(), plane_s);
            return map;
        }
        for (std::size_t n = 0; n + 1 < levels.size(); ++n) {
            const Level& from = levels[n];
            Level& to = levels[n + 1];
            std::fill(to.alpha.begin(), to.alpha.end(), 0.0F);
            std::fill(to.depth_1.begin(), to.depth_1.end(), 0.0F);
            halve(from.alpha.data(), from.width, from.width, from.height, box, 1, to.alpha.data(), to.width);
            halve(from.depth_1.data(), from.width, from.width, from.height, box, 1, to.depth_1.data(), to.width);
            box = coarser(box);
        }
        const float root[] = {plane_s};
        for (std::size_t n = levels.size(); n-- > 0;) {
            Level& to = levels[n];
            Push p;
            const bool top = n + 1 == levels.size();
            p.coarse = top ? root : levels[n + 1].map.data();
            p.coarse_width = top ? 1 : levels[n + 1].width;
            p.coarse_height = top ? 1 : levels[n + 1].height;
            p.alpha = to.alpha.data();
            p.depth_1 = to.depth_1.data();
            p.width = to.width;
            p.height = to.height;
            p.map = n == 0 ? map.data() : to.map.data();
            p.scratch = scratch.data();
            push(p);
        }
        return map;
    }
};

// The map as a mesh with a node at every `cell` texels has it: see bent_at_nodes in keep_scalar.cpp. Sums down the
// columns first, then along the row.
void bend_at_nodes(std::vector<float>& map, const MipLevel& base, int cell) {
    const int across = (base.width + cell - 1) / cell + 1;
    const int down = (base.height + cell - 1) / cell + 1;
    const auto size = static_cast<float>(cell);
    std::vector<float> node(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    std::vector<float> sum(static_cast<std::size_t>(base.width) + 16);
    std::vector<float> weights(sum.size());
    const auto row_of = [&](int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(base.width); };
    for (int j = 0; j < down; ++j) {
        std::fill(sum.begin(), sum.end(), 0.0F);
        std::fill(weights.begin(), weights.end(), 0.0F);
        for (int y = std::max(0, (j - 1) * cell); y < std::min(base.height, (j + 1) * cell); ++y) {
            const float v = 1.0F - std::abs(static_cast<float>(y - j * cell) + 0.5F) / size;
            add_node_row(&map[row_of(y)], &base.colour[row_of(y)].x, v, base.width, sum.data(), weights.data());
        }
        for (int i = 0; i < across; ++i) {
            float value = 0.0F;
            float weight = 0.0F;
            for (int x = std::max(0, (i - 1) * cell); x < std::min(base.width, (i + 1) * cell); ++x) {
                const float u = 1.0F - std::abs(static_cast<float>(x - i * cell) + 0.5F) / size;
                value += u * sum[static_cast<std::size_t>(x)];
                weight += u * weights[static_cast<std::size_t>(x)];
            }
            node[static_cast<std::size_t>(j * across + i)] =
                weight > 0.0F ? value / weight
                              : map[row_of(std::min(j * cell, base.height - 1)) +
                                    static_cast<std::size_t>(std::min(i * cell, base.width - 1))];
        }
    }
    std::vector<float> line(static_cast<std::size_t>(across));
    for (int y = 0; y < base.height; ++y) {
        const float v = (static_cast<float>(y) + 0.5F) / size;
        const int j = static_cast<int>(v);
        const float t = v - static_cast<float>(j);
        const float* a = &node[static_cast<std::size_t>(j * across)];
        const float* b = a + across;
        for (int i = 0; i < across; ++i) {
            line[static_cast<std::size_t>(i)] = (1.0F - t) * a[i] + t * b[i];
        }
        float* out = &map[row_of(y)];
        for (int i = 0; i * cell < base.width; ++i) {
            const float from = line[static_cast<std::size_t>(i)];
            const float step = (line[static_cast<std::size_t>(i) + 1] - from) / size;
            const int count = std::min(cell, base.width - i * cell);
            for (int x = 0; x < count; ++x) {
                out[i * cell + x] = from + step * (static_cast<float>(x) + 0.5F);
            }
        }
    }
}

// What all layers show together: rows have a border of 8 zero texels on either side, and one above and below.
struct Whole {
    int stride;
    std::vector<float> colour, fill;

    Whole(int width, int height, bool with_fill) : stride(width + 24) {
        const auto size = 4 * static_cast<std::size_t>(stride) * (static_cast<std::size_t>(height) + 2);
        colour.resize(size);
        fill.resize(with_fill ? size : 0);
    }
    float* at(std::vector<float>& image) const {
        return image.empty() ? nullptr : &image[4 * (std::size_t(stride) + 8)];
    }
};

// The layer's place among the others, its answer to motion (the sums of sensitivity.cpp) and its sharpening.
void add_layer(Capture& capture, Layer& layer, const TexelRect& box, const CaptureSettings& settings, Whole& whole,
               float radiance_scale, std::vector<float>& scratch) {
    MipLevel& base = layer.mips.front();
    const double per_tan = capture.view.pixels_per_tan_x();
    LayerPass p;
    p.width = base.width;
    p.height = base.height;
    p.box = box;
    p.colour = floats(base.colour);
    p.fill = floats(base.fill);
    p.depth = &base.depth.front().x;
    p.warp = layer.warp.empty() ? nullptr : layer.warp.data();
    p.whole = whole.at(whole.colour);
    p.whole_fill = whole.at(whole.fill);
    p.whole_stride = whole.stride;
    p.sharpen = settings.sharpen;
    p.open_edges = settings.open_edges;
    p.radiance_scale = radiance_scale;
    // Depths in units of the plane's, moments as they are: all sums are about 1, whatever the distance.
    const bool ahead = layer.far_m > 0.0;
    const double floor_m = 1e-3 * layer.far_m;
    const double reference_m = ahead ? std::max(layer.plane_m, floor_m) : 1.0;
    const auto s_of = [&](double z_m) {
        return ahead ? static_cast<float>((z_m - capture.depth_origin_m) / capture.depth_scale_m) : 0.0F;
    };
    p.origin = ahead ? static_cast<float>(capture.depth_origin_m / reference_m) : 1.0F;
    p.scale = ahead ? static_cast<float>(capture.depth_scale_m / reference_m) : 0.0F;
    p.s_floor = s_of(floor_m);
    p.s_near = s_of(std::max(layer.near_m, floor_m));
    p.s_far = s_of(layer.far_m);
    p.s_plane = s_of(layer.plane_m);
    p.step_x = static_cast<float>(1.0 / per_tan);
    p.step_y = static_cast<float>(-1.0 / capture.view.pixels_per_tan_y());
    p.left = static_cast<float>(capture.view.tan_left) + 0.5F * p.step_x;
    p.top = static_cast<float>(capture.view.tan_top) + 0.5F * p.step_y;
    p.aspect = static_cast<float>(capture.view.pixels_per_tan_y() / per_tan);
    p.scratch = scratch.data();
    double sums[12] = {};
    layer_pass(p, sums);
    const double unit =
        ahead ? 0.5 * per_tan * capture.depth_scale_m / (reference_m * reference_m) : 0.0; // of rho x gradient
    for (int m = 0; m < 2; ++m) {
        const double* s = sums + static_cast<std::ptrdiff_t>(6 * m);
        (m == 0 ? capture.sensitivity.radiance : capture.sensitivity.alpha) +=
            unit * unit * glm::dmat3(s[0], s[1], s[3], s[1], s[2], s[4], s[3], s[4], s[5]);
    }
}

void match_levels(std::vector<Layer>& layers, Whole& whole, const TexelRect& box) {
    const MipLevel& base = layers.front().mips.front();
    const float* from = whole.at(whole.colour);
    const float* from_fill = whole.at(whole.fill);
    int stride = whole.stride;
    std::vector<float> target;
    std::vector<float> target_fill;
    std::vector<MatchMips::One> level(layers.size());
    TexelRect fine = box;
    int width = base.width;
    int height = base.height;
    for (std::size_t n = 1; n < layers.front().mips.size(); ++n) {
        const MipLevel& mip = layers.front().mips[n];
        const std::size_t texels = mip.colour.size();
        std::vector<float> to(4 * texels);
        std::vector<float> to_fill(from_fill != nullptr ? 4 * texels : 0);
        halve(from, stride, width, height, fine, 4, to.data(), mip.width);
        if (from_fill != nullptr) {
            halve(from_fill, stride, width, height, fine, 4, to_fill.data(), mip.width);
        }
        target = std::move(to);
        target_fill = std::move(to_fill);
        from = target.data();
        from_fill = target_fill.empty() ? nullptr : target_fill.data();
        fine = coarser(fine);
        width = stride = mip.width;
        height = mip.height;
        for (std::size_t k = 0; k < layers.size(); ++k) {
            MipLevel& of = layers[k].mips[n];
            level[k] = {floats(of.colour), floats(of.fill), &of.depth.front().x};
        }
        const auto row = static_cast<std::size_t>(width);
        match_mips({level.data(), static_cast<int>(level.size()), from, from_fill,
                    static_cast<std::size_t>(fine.y0) * row, static_cast<std::size_t>(fine.y1) * row});
    }
}

} // namespace

void keep(Capture& result, std::span<const double> edges_m, const CaptureSettings& settings,
          std::span<SlabImage> slabs) {
    const int width = result.view.width;
    const int height = result.view.height;
    const std::size_t texels = slabs.front().colour.size();
    const bool warped = warped_kind(result.representation);
    const bool with_fill = std::any_of(slabs.begin(), slabs.end(), [](const SlabImage& s) { return !s.fill.empty(); });
    DepthPyramid pyramid(warped ? width : 1, warped ? height : 1);
    std::vector<float> none;
    std::vector<TexelRect> boxes(slabs.size());
    TexelRect all{width, height, 0, 0};
    float most = 0.0F;
    float left = 1.0F;
    result.layers.resize(slabs.size());
    for (std::size_t k = 0; k < slabs.size(); ++k) {
        Layer& layer = result.layers[k];
        layer.near_m = edges_m[k];
        layer.far_m = edges_m[k + 1];
        layer.occupied.assign(static_cast<std::size_t>((width + 7) / 8) * static_cast<std::size_t>((height + 7) / 8),
                              0);
        MipLevel& base = layer.mips.emplace_back();
        base.width = width;
        base.height = height;
        const RowSums sums = read(slabs[k], base, layer.occupied, warped ? pyramid.levels.front().alpha : none,
                                  warped ? pyramid.levels.front().depth_1 : none, result.rejected_texels);
        const TexelRect box = spread(layer.occupied, width, height);
        boxes[k] = box;
        if (!box.empty()) {
            all = {std::min(all.x0, box.x0), std::min(all.y0, box.y0), std::max(all.x1, box.x1),
                   std::max(all.y1, box.y1)};
        }
        layer.plane_m = plane_of(result, layer.near_m, layer.far_m, sums.colour[3], sums.depth_1);
        most = std::max(most, sums.most);
        const glm::vec4 shown =
            left * glm::vec4(glm::dvec4(sums.colour[0], sums.colour[1], sums.colour[2], sums.colour[3]) /
                             static_cast<double>(texels));
        result.mean += shown;
        left -= shown.w;
        if (settings.mips) {
            build_mips(layer, box);
        }
        if (warped) {
            layer.warp = pyramid.continued(
                box, static_cast<float>((layer.plane_m - result.depth_origin_m) / result.depth_scale_m));
            if (settings.warp_cell > 1) {
                bend_at_nodes(layer.warp, layer.mips.front(), settings.warp_cell);
            }
        }
    }
    if (all.empty()) {
        return;
    }
    Whole whole(width, height, with_fill);
    std::vector<float> scratch(layer_scratch(width));
    const float radiance_scale = most > 0.0F ? 1.0F / std::clamp(most, 1e-30F, 1e30F) : 1.0F;
    for (std::size_t k = 0; k < result.layers.size(); ++k) {
        if (!boxes[k].empty()) {
            add_layer(result, result.layers[k], boxes[k], settings, whole, radiance_scale, scratch);
        }
    }
    const Curvature c = curvature(whole.at(whole.colour), whole.at(whole.fill), whole.stride, all, radiance_scale);
    Sensitivity& s = result.sensitivity;
    s.radiance = c.energy > 0.0 ? s.radiance / c.energy : glm::dmat3(0.0);
    s.alpha = c.energy_alpha > 0.0 ? s.alpha / c.energy_alpha : glm::dmat3(0.0);
    s.resample = linear_loss * std::sqrt(std::max(c.energy > 0.0 ? c.curvature / c.energy : 0.0,
                                                  c.energy_alpha > 0.0 ? c.curvature_alpha / c.energy_alpha : 0.0));
    if (settings.mips && result.layers.size() > 1) {
        match_levels(result.layers, whole, all);
    }
}

} // namespace alpenglow::impostors
