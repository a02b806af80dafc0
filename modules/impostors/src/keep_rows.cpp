#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "keep_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "keep_rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::impostors::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 8>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

constexpr int ring_planes = 11; // key RGBA, fill RGB, radiance RGB and alpha as seen through what is in front

// A few texels at the end of a row, as if there were a vector of them.
template <int channels>
struct Tail {
    alignas(64) float values[8 * channels];

    const float* read(const float* from, int count, int lanes) {
        if (count >= lanes) {
            return from;
        }
        std::memset(values, 0, sizeof values);
        std::copy_n(from, channels * count, values);
        return values;
    }
    float* place(float* to, int count, int lanes) { return count >= lanes ? to : values; }
    void write(float* to, int count, int lanes) const {
        if (count < lanes) {
            std::copy_n(values, channels * count, to);
        }
    }
};

// All of 0 <= x <= most, and no NaN: as integers, which no trap sees.
HWY_INLINE bool between(const float* values, int count, const std::int32_t* most) {
    const D d;
    const DI di;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const VI negative = hn::Set(di, -1);
    auto good = hn::Eq(negative, negative);
    int i = 0;
    for (; i + lanes <= count; i += lanes) {
        const VI bits = hn::BitCast(di, hn::LoadU(d, values + i));
        const VI limit = hn::LoadU(di, most + i % 24); // patterns repeat after 3 or 4 channels
        good = hn::And(good, hn::AndNot(hn::Gt(bits, limit), hn::Gt(bits, negative)));
    }
    bool all = hn::AllTrue(di, good);
    for (; i < count; ++i) {
        std::int32_t bits = 0;
        std::memcpy(&bits, values + i, sizeof bits);
        all = all && bits >= 0 && bits <= most[i % 24];
    }
    return all;
}

HWY_INLINE bool finite(const float* values, int count) {
    const D d;
    const DI di;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const VI magnitude = hn::Set(di, 0x7FFFFFFF);
    const VI infinity = hn::Set(di, 0x7F800000);
    auto good = hn::Eq(hn::Zero(di), hn::Zero(di));
    int i = 0;
    for (; i + lanes <= count; i += lanes) {
        good = hn::And(good, hn::Lt(hn::And(hn::BitCast(di, hn::LoadU(d, values + i)), magnitude), infinity));
    }
    bool all = hn::AllTrue(di, good);
    for (; i < count; ++i) {
        std::int32_t bits = 0;
        std::memcpy(&bits, values + i, sizeof bits);
        all = all && (bits & 0x7FFFFFFF) < 0x7F800000;
    }
    return all;
}

bool read_row_kernel(const RowIn& row, RowSums& sums) {
    constexpr std::int32_t greatest = 0x7149F2CA; // 1e30: squares of sums stay finite in double, averages in float
    constexpr std::int32_t one_bits = 0x3F800000;
    std::int32_t colour_most[24 + 8];
    std::int32_t fill_most[24 + 8];
    for (int i = 0; i < 32; ++i) {
        colour_most[i] = i % 4 == 3 ? one_bits : greatest;
        fill_most[i] = greatest;
    }
    if (!between(row.colour, 4 * row.count, colour_most) || !finite(row.depth, 2 * row.count) ||
        (row.fill != nullptr && !between(row.fill, 3 * row.count, fill_most))) {
        return false;
    }
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const V zero = hn::Zero(d);
    V sum_r = zero;
    V sum_g = zero;
    V sum_b = zero;
    V sum_a = zero;
    V sum_d = zero;
    V most = zero;
    Tail<4> colour_tail;
    Tail<3> fill_tail;
    Tail<4> fill_out_tail;
    Tail<2> depth_tail;
    Tail<1> alpha_tail;
    Tail<1> depth_1_tail;
    for (int x = 0; x < row.count; x += lanes) {
        const int n = row.count - x;
        V r;
        V g;
        V b;
        V a;
        hn::LoadInterleaved4(d, colour_tail.read(row.colour + 4 * x, n, lanes), r, g, b, a);
        V any = hn::Max(hn::Max(r, g), b);
        if (row.fill != nullptr) {
            V fr;
            V fg;
            V fb;
            hn::LoadInterleaved3(d, fill_tail.read(row.fill + 3 * x, n, lanes), fr, fg, fb);
            hn::StoreInterleaved4(fr, fg, fb, zero, d, fill_out_tail.place(row.fill_out + 4 * x, n, lanes));
            fill_out_tail.write(row.fill_out + 4 * x, n, lanes);
            r = hn::Add(r, fr);
            g = hn::Add(g, fg);
            b = hn::Add(b, fb);
            any = hn::Max(hn::Max(r, g), b);
        }
        V d1;
        V d2;
        hn::LoadInterleaved2(d, depth_tail.read(row.depth + 2 * x, n, lanes), d1, d2);
        const M solid = hn::Gt(a, zero);
        d1 = hn::Min(hn::Max(d1, hn::Neg(a)), a);
        const V least = hn::Div(hn::Mul(d1, d1), hn::IfThenElse(solid, a, hn::Set(d, 1.0F)));
        d2 = hn::Min(hn::Max(hn::IfThenElseZero(solid, d2), least), a);
        hn::StoreInterleaved2(d1, d2, d, depth_tail.place(row.depth + 2 * x, n, lanes));
        depth_tail.write(row.depth + 2 * x, n, lanes);
        if (row.alpha != nullptr) {
            hn::StoreU(a, d, alpha_tail.place(row.alpha + x, n, lanes));
            alpha_tail.write(row.alpha + x, n, lanes);
            hn::StoreU(d1, d, depth_1_tail.place(row.depth_1 + x, n, lanes));
            depth_1_tail.write(row.depth_1 + x, n, lanes);
        }
        most = hn::Max(most, any);
        if (!hn::AllTrue(d, hn::Le(hn::Max(any, a), zero))) {
            row.occupied[x / 8] = 1;
        }
        sum_r = hn::Add(sum_r, r);
        sum_g = hn::Add(sum_g, g);
        sum_b = hn::Add(sum_b, b);
        sum_a = hn::Add(sum_a, a);
        sum_d = hn::Add(sum_d, d1);
    }
    const auto total = [&](V v) HWY_ATTR { return static_cast<double>(hn::GetLane(hn::SumOfLanes(d, v))); };
    sums.colour[0] += total(sum_r);
    sums.colour[1] += total(sum_g);
    sums.colour[2] += total(sum_b);
    sums.colour[3] += total(sum_a);
    sums.depth_1 += total(sum_d);
    sums.most = std::max(sums.most, hn::GetLane(hn::MaxOfLanes(d, most)));
    return true;
}

void halve_kernel(const float* from, int from_stride, int width, int height, const TexelRect& box, int channels,
                  float* to, int to_stride) {
    const D d;
    const hn::CappedTag<float, 4> d4;
    const auto lanes4 = static_cast<int>(hn::Lanes(d4));
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const int x_end = std::min(box.x1, width);
    const int y_end = std::min(box.y1, height);
    for (int y = box.y0 / 2; 2 * y < y_end; ++y) {
        const float* above = from + static_cast<std::ptrdiff_t>(2 * y) * from_stride * channels;
        const bool odd = 2 * y + 1 >= height; // transparency below
        const float* below = odd ? above : above + static_cast<std::ptrdiff_t>(from_stride) * channels;
        const float share = odd ? 0.0F : 0.25F;
        float* out = to + static_cast<std::ptrdiff_t>(y) * to_stride * channels;
        int x = box.x0 / 2;
        if (channels == 4) {
            const auto quarter = hn::Set(d4, 0.25F);
            const auto lower = hn::Set(d4, share);
            for (; 2 * x + 1 < x_end; ++x) {
                for (int c = 0; c < 4; c += lanes4) {
                    const int at = 8 * x + c;
                    const auto top = hn::Add(hn::LoadU(d4, above + at), hn::LoadU(d4, above + at + 4));
                    const auto bottom = hn::Add(hn::LoadU(d4, below + at), hn::LoadU(d4, below + at + 4));
                    hn::StoreU(hn::MulAdd(top, quarter, hn::Mul(bottom, lower)), d4, out + 4 * x + c);
                }
            }
        } else if (channels == 2) {
            for (; 2 * (x + lanes) <= x_end; x += lanes) {
                V a0;
                V a1;
                V a2;
                V a3;
                V b0;
                V b1;
                V b2;
                V b3;
                hn::LoadInterleaved4(d, above + 4 * x, a0, a1, a2, a3);
                hn::LoadInterleaved4(d, below + 4 * x, b0, b1, b2, b3);
                const V quarter = hn::Set(d, 0.25F);
                const V lower = hn::Set(d, share);
                hn::StoreInterleaved2(hn::MulAdd(hn::Add(a0, a2), quarter, hn::Mul(hn::Add(b0, b2), lower)),
                                      hn::MulAdd(hn::Add(a1, a3), quarter, hn::Mul(hn::Add(b1, b3), lower)), d,
                                      out + 2 * x);
            }
        } else {
            for (; 2 * (x + lanes) <= x_end; x += lanes) {
                V a0;
                V a1;
                V b0;
                V b1;
                hn::LoadInterleaved2(d, above + 2 * x, a0, a1);
                hn::LoadInterleaved2(d, below + 2 * x, b0, b1);
                hn::StoreU(hn::MulAdd(hn::Add(a0, a1), hn::Set(d, 0.25F), hn::Mul(hn::Add(b0, b1), hn::Set(d, share))),
                           d, out + x);
            }
        }
        for (; 2 * x < x_end; ++x) {
            const bool last = 2 * x + 1 >= width; // transparency beyond
            for (int c = 0; c < channels; ++c) {
                const int at = 2 * x * channels + c;
                const int next = last ? at : at + channels;
                const float other = last ? 0.0F : 1.0F;
                out[x * channels + c] =
                    0.25F * (above[at] + other * above[next]) + share * (below[at] + other * below[next]);
            }
        }
    }
}

void push_kernel(const Push& p) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const V near = hn::Set(d, 0.75F);
    const V far = hn::Set(d, 0.25F);
    const V trust = hn::Set(d, 0.004F); // an alpha that speaks for itself: about one step of 8 bits
    float* line = p.scratch + 8;        // the coarse level at this row
    float* below = p.scratch + p.width + 32;
    for (int y = 0; y < p.height; ++y) {
        const int k = y / 2;
        const int other = std::clamp(y % 2 == 0 ? k - 1 : k + 1, 0, p.coarse_height - 1);
        const float* a = p.coarse + static_cast<std::ptrdiff_t>(k) * p.coarse_width;
        const float* b = p.coarse + static_cast<std::ptrdiff_t>(other) * p.coarse_width;
        int i = 0;
        for (; i + lanes <= p.coarse_width; i += lanes) {
            hn::StoreU(hn::MulAdd(near, hn::LoadU(d, a + i), hn::Mul(far, hn::LoadU(d, b + i))), d, line + i);
        }
        for (; i < p.coarse_width; ++i) {
            line[i] = 0.75F * a[i] + 0.25F * b[i];
        }
        line[-1] = line[0];
        line[p.coarse_width] = line[p.coarse_width - 1];
        for (i = 0; i < p.coarse_width; i += lanes) {
            const V middle = hn::Mul(near, hn::LoadU(d, line + i));
            hn::StoreInterleaved2(hn::MulAdd(far, hn::LoadU(d, line + i - 1), middle),
                                  hn::MulAdd(far, hn::LoadU(d, line + i + 1), middle), d, below + 2 * i);
        }
        const auto row = static_cast<std::ptrdiff_t>(y) * p.width;
        const float* alpha = p.alpha + row;
        const float* depth = p.depth_1 + row;
        float* out = p.map + row;
        int x = 0;
        for (; x + lanes <= p.width; x += lanes) {
            hn::StoreU(hn::Div(hn::MulAdd(trust, hn::LoadU(d, below + x), hn::LoadU(d, depth + x)),
                               hn::Add(hn::LoadU(d, alpha + x), trust)),
                       d, out + x);
        }
        for (; x < p.width; ++x) {
            out[x] = (depth[x] + 0.004F * below[x]) / (alpha[x] + 0.004F);
        }
    }
}

HWY_INLINE V sharpened(V c, V l, V r, V u, V b) {
    const D d;
    const V least = hn::Min(hn::Min(c, hn::Min(l, r)), hn::Min(u, b));
    const V most = hn::Max(hn::Max(c, hn::Max(l, r)), hn::Max(u, b));
    const V around = hn::Add(hn::Add(l, r), hn::Add(u, b));
    const V sharp = hn::MulAdd(hn::MulSub(hn::Set(d, 4.0F), c, around), hn::Set(d, 1.0F / 12.0F), c);
    return hn::Min(hn::Max(sharp, least), most);
}

void layer_pass_kernel(const LayerPass& p, double* sums) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.0F);
    const std::ptrdiff_t stride = p.width + 32;
    const auto plane = [&](int y, int k) { return p.scratch + (y % 3 * ring_planes + k) * stride + 8; };
    float* blank = p.scratch + 3 * ring_planes * stride + 8;
    std::fill(blank - 8, blank - 8 + stride, 0.0F);
    const int x_last = p.box.x0 + (p.box.x1 - p.box.x0 + lanes - 1) / lanes * lanes; // lanes past the box hold zero
    const int keys = p.fill != nullptr ? 7 : 4;
    Tail<4> colour_tail;
    Tail<4> fill_tail;
    Tail<2> depth_tail;
    Tail<1> warp_tail;

    const auto load = [&](int y) HWY_ATTR {
        const float* colour = p.colour + 4 * static_cast<std::ptrdiff_t>(y) * p.width;
        const float* fill = p.fill != nullptr ? p.fill + 4 * static_cast<std::ptrdiff_t>(y) * p.width : nullptr;
        float* whole = p.whole + 4 * static_cast<std::ptrdiff_t>(y) * p.whole_stride;
        float* whole_fill =
            fill != nullptr ? p.whole_fill + 4 * static_cast<std::ptrdiff_t>(y) * p.whole_stride : nullptr;
        const V scale = hn::Set(d, p.radiance_scale);
        for (int x = p.box.x0; x < p.box.x1; x += lanes) {
            const int n = p.box.x1 - x;
            V r;
            V g;
            V b;
            V a;
            hn::LoadInterleaved4(d, colour_tail.read(colour + 4 * x, n, lanes), r, g, b, a);
            hn::StoreU(r, d, plane(y, 0) + x);
            hn::StoreU(g, d, plane(y, 1) + x);
            hn::StoreU(b, d, plane(y, 2) + x);
            hn::StoreU(a, d, plane(y, 3) + x);
            V wr;
            V wg;
            V wb;
            V wa;
            hn::LoadInterleaved4(d, whole + 4 * x, wr, wg, wb, wa);
            const V left = hn::Sub(one, wa);
            hn::StoreInterleaved4(hn::MulAdd(left, r, wr), hn::MulAdd(left, g, wg), hn::MulAdd(left, b, wb),
                                  hn::MulAdd(left, a, wa), d, whole + 4 * x);
            if (fill != nullptr) {
                V fr;
                V fg;
                V fb;
                V none;
                hn::LoadInterleaved4(d, fill_tail.read(fill + 4 * x, n, lanes), fr, fg, fb, none);
                hn::StoreU(fr, d, plane(y, 4) + x);
                hn::StoreU(fg, d, plane(y, 5) + x);
                hn::StoreU(fb, d, plane(y, 6) + x);
                hn::LoadInterleaved4(d, whole_fill + 4 * x, wr, wg, wb, none);
                hn::StoreInterleaved4(hn::MulAdd(left, fr, wr), hn::MulAdd(left, fg, wg), hn::MulAdd(left, fb, wb),
                                      none, d, whole_fill + 4 * x);
                r = hn::Add(r, fr);
                g = hn::Add(g, fg);
                b = hn::Add(b, fb);
            }
            const V seen = hn::Mul(left, scale);
            hn::StoreU(hn::Mul(seen, r), d, plane(y, 7) + x);
            hn::StoreU(hn::Mul(seen, g), d, plane(y, 8) + x);
            hn::StoreU(hn::Mul(seen, b), d, plane(y, 9) + x);
            hn::StoreU(hn::Mul(left, a), d, plane(y, 10) + x);
        }
        for (int k = 0; k < ring_planes; ++k) {
            const bool held = k < 7 && p.open_edges;
            plane(y, k)[p.box.x0 - 1] = held && p.box.x0 == 0 ? plane(y, k)[0] : 0.0F;
            plane(y, k)[x_last] = 0.0F;
            if (held && p.box.x1 == p.width) {
                plane(y, k)[p.width] = plane(y, k)[p.width - 1];
            }
        }
    };

    V sum[12];
    const auto work = [&](int y) HWY_ATTR {
        const bool top = y == p.box.y0;
        const bool bottom = y + 1 == p.box.y1;
        float* colour = p.colour + 4 * static_cast<std::ptrdiff_t>(y) * p.width;
        float* fill = p.fill != nullptr ? p.fill + 4 * static_cast<std::ptrdiff_t>(y) * p.width : nullptr;
        float* depth = p.depth + 2 * static_cast<std::ptrdiff_t>(y) * p.width;
        const float* warp = p.warp != nullptr ? p.warp + static_cast<std::ptrdiff_t>(y) * p.width : nullptr;
        const V ty = hn::Set(d, p.top + p.step_y * static_cast<float>(y));
        for (V& v : sum) {
            v = zero;
        }
        for (int x = p.box.x0; x < p.box.x1; x += lanes) {
            const int n = p.box.x1 - x;
            const V alpha = hn::LoadU(d, plane(y, 3) + x);
            V d1;
            V d2;
            hn::LoadInterleaved2(d, depth_tail.read(depth + 2 * x, n, lanes), d1, d2);
            M solid = hn::Gt(alpha, hn::Set(d, 1e-6F));
            if (n < lanes) { // beyond the rim an open edge goes on
                solid = hn::And(solid, hn::FirstN(d, static_cast<std::size_t>(n)));
            }
            if (!hn::AllFalse(d, solid)) {
                const V inverse = hn::Div(one, hn::IfThenElse(solid, alpha, one));
                const V mean = hn::Mul(d1, inverse);
                const V variance = hn::Max(zero, hn::NegMulAdd(mean, mean, hn::Mul(d2, inverse)));
                const V s = hn::Max(mean, hn::Set(d, p.s_floor));
                const V shown =
                    warp != nullptr
                        ? hn::Min(hn::Max(hn::LoadU(d, warp_tail.read(warp + x, n, lanes)), hn::Set(d, p.s_near)),
                                  hn::Set(d, p.s_far))
                        : hn::Set(d, p.s_plane);
                const V scale = hn::Set(d, p.scale);
                const V origin = hn::Set(d, p.origin);
                const V iz = hn::Div(one, hn::MulAdd(scale, s, origin));
                const V off = hn::Div(hn::Mul(hn::Sub(shown, s), iz), hn::MulAdd(scale, shown, origin));
                const V iz2 = hn::Mul(iz, iz);
                const V rho = hn::IfThenElseZero(solid, hn::MulAdd(off, off, hn::Mul(variance, hn::Mul(iz2, iz2))));
                const V tx = hn::MulAdd(hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<float>(x))),
                                        hn::Set(d, p.step_x), hn::Set(d, p.left));
                const V aspect = hn::Set(d, p.aspect);
                V xx = zero;
                V xy = zero;
                V yy = zero;
                const auto add = [&](int at) HWY_ATTR {
                    xx = hn::Mul(xx, rho);
                    xy = hn::Mul(xy, rho);
                    yy = hn::Mul(yy, rho);
                    const V xz = hn::MulAdd(tx, xx, hn::Mul(ty, xy));
                    const V yz = hn::MulAdd(tx, xy, hn::Mul(ty, yy));
                    sum[at] = hn::Add(sum[at], xx);
                    sum[at + 1] = hn::Add(sum[at + 1], xy);
                    sum[at + 2] = hn::Add(sum[at + 2], yy);
                    sum[at + 3] = hn::Sub(sum[at + 3], xz);
                    sum[at + 4] = hn::Sub(sum[at + 4], yz);
                    sum[at + 5] = hn::MulAdd(tx, xz, hn::MulAdd(ty, yz, sum[at + 5]));
                };
                for (int k = 7; k < ring_planes; ++k) {
                    if (k == 10) { // alpha
                        add(0);
                        xx = xy = yy = zero;
                    }
                    const float* here = plane(y, k) + x;
                    const float* above = top ? blank + x : plane(y + 2, k) + x;
                    const float* below = bottom ? blank + x : plane(y + 1, k) + x;
                    const V gx = hn::Sub(hn::LoadU(d, here + 1), hn::LoadU(d, here - 1));
                    const V gy = hn::Mul(aspect, hn::Sub(hn::LoadU(d, above), hn::LoadU(d, below)));
                    xx = hn::MulAdd(gx, gx, xx);
                    xy = hn::MulAdd(gx, gy, xy);
                    yy = hn::MulAdd(gy, gy, yy);
                }
                add(6);
            }
            if (!p.sharpen) {
                continue;
            }
            const bool hold_top = y == 0 && p.open_edges;
            const bool hold_bottom = y + 1 == p.height && p.open_edges;
            V out[7];
            for (int k = 0; k < keys; ++k) {
                const float* here = plane(y, k) + x;
                const float* above = hold_top ? here : top ? blank + x : plane(y + 2, k) + x;
                const float* below = hold_bottom ? here : bottom ? blank + x : plane(y + 1, k) + x;
                out[k] = sharpened(hn::LoadU(d, here), hn::LoadU(d, here - 1), hn::LoadU(d, here + 1),
                                   hn::LoadU(d, above), hn::LoadU(d, below));
            }
            hn::StoreInterleaved4(out[0], out[1], out[2], out[3], d, colour_tail.place(colour + 4 * x, n, lanes));
            colour_tail.write(colour + 4 * x, n, lanes);
            if (fill != nullptr) {
                hn::StoreInterleaved4(out[4], out[5], out[6], zero, d, fill_tail.place(fill + 4 * x, n, lanes));
                fill_tail.write(fill + 4 * x, n, lanes);
            }
            const M any = hn::Gt(alpha, zero);
            const V ratio = hn::IfThenElseZero(any, hn::Div(out[3], hn::IfThenElse(any, alpha, one)));
            hn::StoreInterleaved2(hn::Mul(d1, ratio), hn::Mul(d2, ratio), d, depth_tail.place(depth + 2 * x, n, lanes));
            depth_tail.write(depth + 2 * x, n, lanes);
        }
        for (int k = 0; k < 12; ++k) {
            sums[k] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[k])));
        }
    };
    for (int y = p.box.y0; y < p.box.y1; ++y) {
        load(y);
        if (y > p.box.y0) {
            work(y - 1);
        }
    }
    work(p.box.y1 - 1);
}

void curvature_kernel(const float* whole, const float* whole_fill, int stride, const TexelRect& box,
                      float radiance_scale, Curvature& out) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    float pattern[12];
    for (int i = 0; i < 12; ++i) {
        pattern[i] = i % 4 == 3 ? 1.0F : radiance_scale;
    }
    const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(stride);
    for (int y = box.y0; y < box.y1; ++y) {
        V energy[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)}; // by channel where a vector holds no texel
        V curved[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        const auto sum = [&](auto&& at) HWY_ATTR {
            for (int x = 4 * box.x0; x < 4 * box.x1; x += lanes) {
                const std::ptrdiff_t i = y * row + x;
                const V scale = hn::LoadU(d, pattern + x % 4);
                const int of = x % 4;
                const V twice = hn::Mul(hn::Set(d, -2.0F), at(i));
                const V c = hn::Mul(scale, at(i));
                V xx = hn::Mul(scale, hn::Add(twice, hn::Add(at(i - 4), at(i + 4))));
                V yy = hn::Mul(scale, hn::Add(twice, hn::Add(at(i - row), at(i + row))));
                if (x + lanes > 4 * box.x1) {
                    const M inside = hn::FirstN(d, static_cast<std::size_t>(4 * box.x1 - x));
                    xx = hn::IfThenElseZero(inside, xx);
                    yy = hn::IfThenElseZero(inside, yy);
                }
                energy[of] = hn::MulAdd(c, c, energy[of]);
                curved[of] = hn::MulAdd(xx, xx, hn::MulAdd(yy, yy, curved[of]));
            }
        };
        if (whole_fill == nullptr) {
            sum([&](std::ptrdiff_t i) HWY_ATTR { return hn::LoadU(d, whole + i); });
        } else {
            sum([&](std::ptrdiff_t i)
                    HWY_ATTR { return hn::Add(hn::LoadU(d, whole + i), hn::LoadU(d, whole_fill + i)); });
        }
        for (int of = 0; of < 4; ++of) {
            alignas(64) float e[8];
            alignas(64) float k[8];
            hn::Store(energy[of], d, e);
            hn::Store(curved[of], d, k);
            for (int i = 0; i < lanes; ++i) {
                const bool alpha = (of + i) % 4 == 3;
                (alpha ? out.energy_alpha : out.energy) += static_cast<double>(e[i]);
                (alpha ? out.curvature_alpha : out.curvature) += static_cast<double>(k[i]);
            }
        }
    }
}

// log(1 - a) for 0 < a <= 0.9999, to 1e-4 of itself.
HWY_INLINE V log_left(V a) {
    const D d;
    const V third = hn::Set(d, 1.0F / 3.0F);
    const V small = hn::Neg(hn::Mul(a, hn::MulAdd(a, hn::MulAdd(a, third, hn::Set(d, 0.5F)), hn::Set(d, 1.0F))));
    const V exact = hn::Log(d, hn::Sub(hn::Set(d, 1.0F), a));
    return hn::IfThenElse(hn::Lt(a, hn::Set(d, 2e-3F)), small, exact);
}

// 1 - exp(x) for x <= 0.
HWY_INLINE V one_less_exp(V x) {
    const D d;
    const V one = hn::Set(d, 1.0F);
    const V sixth = hn::Set(d, 1.0F / 6.0F);
    const V small = hn::Neg(hn::Mul(x, hn::MulAdd(x, hn::MulAdd(x, sixth, hn::Set(d, 0.5F)), one)));
    const V exact = hn::Sub(one, hn::Exp(d, hn::Max(x, hn::Set(d, -80.0F))));
    return hn::IfThenElse(hn::Gt(x, hn::Set(d, -2e-3F)), small, exact);
}

void match_mips_kernel(const MatchMips& m) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.0F);
    const V least = hn::Set(d, 1e-6F);
    const V most = hn::Set(d, 0.9999F);
    const V half = hn::Set(d, 0.5F);
    Tail<4> colour_tail;
    Tail<2> depth_tail;
    for (std::size_t first = m.first; first < m.last; first += static_cast<std::size_t>(lanes)) {
        const int n = static_cast<int>(std::min(m.last - first, static_cast<std::size_t>(lanes)));
        V tr;
        V tg;
        V tb;
        V ta;
        hn::LoadInterleaved4(d, colour_tail.read(m.target + 4 * first, n, lanes), tr, tg, tb, ta);
        V left = one;
        V r;
        V g;
        V b;
        V a;
        for (int k = 0; k < m.count; ++k) {
            hn::LoadInterleaved4(d, colour_tail.read(m.layers[k].colour + 4 * first, n, lanes), r, g, b, a);
            left = hn::NegMulAdd(left, a, left);
        }
        const V have = hn::Min(hn::Sub(one, left), most);
        const V want = hn::Min(ta, most);
        const M match = hn::And(hn::Gt(have, least), hn::Gt(want, least));
        if (hn::AllFalse(d, match)) {
            continue;
        }
        const V power = hn::IfThenElse(
            match, hn::Div(log_left(hn::IfThenElse(match, want, half)), log_left(hn::IfThenElse(match, have, half))),
            one);
        V sr = zero;
        V sg = zero;
        V sb = zero;
        V sa = zero;
        V fr = zero;
        V fg = zero;
        V fb = zero;
        V none;
        for (int k = 0; k < m.count; ++k) {
            const MatchMips::One& layer = m.layers[k];
            hn::LoadInterleaved4(d, colour_tail.read(layer.colour + 4 * first, n, lanes), r, g, b, a);
            const M thin = hn::Lt(a, least);
            const V some = hn::IfThenElse(thin, half, hn::Min(a, most));
            V scale = hn::Div(one_less_exp(hn::Mul(power, log_left(some))), some);
            scale = hn::IfThenElse(thin, power, hn::IfThenElse(hn::Ge(a, most), one, scale));
            scale = hn::IfThenElse(match, scale, one);
            r = hn::Mul(r, scale);
            g = hn::Mul(g, scale);
            b = hn::Mul(b, scale);
            a = hn::Min(hn::Mul(a, scale), one);
            const V behind = hn::Sub(one, sa);
            sr = hn::MulAdd(behind, r, sr);
            sg = hn::MulAdd(behind, g, sg);
            sb = hn::MulAdd(behind, b, sb);
            sa = hn::MulAdd(behind, a, sa);
            hn::StoreInterleaved4(r, g, b, a, d, colour_tail.place(layer.colour + 4 * first, n, lanes));
            colour_tail.write(layer.colour + 4 * first, n, lanes);
            hn::LoadInterleaved2(d, depth_tail.read(layer.depth + 2 * first, n, lanes), r, g);
            hn::StoreInterleaved2(hn::Mul(r, scale), hn::Mul(g, scale), d,
                                  depth_tail.place(layer.depth + 2 * first, n, lanes));
            depth_tail.write(layer.depth + 2 * first, n, lanes);
            if (layer.fill != nullptr) {
                hn::LoadInterleaved4(d, colour_tail.read(layer.fill + 4 * first, n, lanes), r, g, b, none);
                r = hn::Mul(r, scale);
                g = hn::Mul(g, scale);
                b = hn::Mul(b, scale);
                fr = hn::MulAdd(behind, r, fr);
                fg = hn::MulAdd(behind, g, fg);
                fb = hn::MulAdd(behind, b, fb);
                hn::StoreInterleaved4(r, g, b, none, d, colour_tail.place(layer.fill + 4 * first, n, lanes));
                colour_tail.write(layer.fill + 4 * first, n, lanes);
            }
        }
        const auto ratio = [&](V wanted, V got) HWY_ATTR {
            const M some = hn::Gt(got, hn::Set(d, 1e-30F));
            const V q = hn::Div(hn::IfThenElse(some, wanted, one), hn::IfThenElse(some, got, one));
            return hn::Min(hn::Max(q, hn::Set(d, 0.25F)), hn::Set(d, 4.0F));
        };
        const V kr = ratio(tr, sr);
        const V kg = ratio(tg, sg);
        const V kb = ratio(tb, sb);
        V lr = one;
        V lg = one;
        V lb = one;
        if (m.target_fill != nullptr) {
            hn::LoadInterleaved4(d, colour_tail.read(m.target_fill + 4 * first, n, lanes), tr, tg, tb, none);
            lr = ratio(tr, fr);
            lg = ratio(tg, fg);
            lb = ratio(tb, fb);
        }
        for (int k = 0; k < m.count; ++k) {
            const MatchMips::One& layer = m.layers[k];
            hn::LoadInterleaved4(d, colour_tail.read(layer.colour + 4 * first, n, lanes), r, g, b, a);
            hn::StoreInterleaved4(hn::Mul(r, kr), hn::Mul(g, kg), hn::Mul(b, kb), a, d,
                                  colour_tail.place(layer.colour + 4 * first, n, lanes));
            colour_tail.write(layer.colour + 4 * first, n, lanes);
            if (layer.fill != nullptr) {
                hn::LoadInterleaved4(d, colour_tail.read(layer.fill + 4 * first, n, lanes), r, g, b, none);
                hn::StoreInterleaved4(hn::Mul(r, lr), hn::Mul(g, lg), hn::Mul(b, lb), none, d,
                                      colour_tail.place(layer.fill + 4 * first, n, lanes));
                colour_tail.write(layer.fill + 4 * first, n, lanes);
            }
        }
    }
}

void add_node_row_kernel(const float* map, const float* colour, float weight, int width, float* sum, float* weights) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    Tail<4> colour_tail;
    Tail<1> map_tail;
    for (int x = 0; x < width; x += lanes) {
        const int n = width - x;
        V r;
        V g;
        V b;
        V a;
        hn::LoadInterleaved4(d, colour_tail.read(colour + 4 * x, n, lanes), r, g, b, a);
        const V w = hn::Mul(hn::Set(d, weight), hn::Add(a, hn::Set(d, 1e-3F)));
        const V s = hn::LoadU(d, map_tail.read(map + x, n, lanes));
        hn::StoreU(hn::MulAdd(w, s, hn::LoadU(d, sum + x)), d, sum + x);
        hn::StoreU(hn::Add(w, hn::LoadU(d, weights + x)), d, weights + x);
    }
}

} // namespace alpenglow::impostors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::impostors {
HWY_EXPORT(read_row_kernel);
HWY_EXPORT(halve_kernel);
HWY_EXPORT(push_kernel);
HWY_EXPORT(layer_pass_kernel);
HWY_EXPORT(curvature_kernel);
HWY_EXPORT(match_mips_kernel);
HWY_EXPORT(add_node_row_kernel);

bool read_row(const RowIn& row, RowSums& sums) {
    return HWY_DYNAMIC_DISPATCH(read_row_kernel)(row, sums);
}

void halve(const float* from, int from_stride, int width, int height, const TexelRect& box, int channels, float* to,
           int to_stride) {
    HWY_DYNAMIC_DISPATCH(halve_kernel)(from, from_stride, width, height, box, channels, to, to_stride);
}

void push(const Push& level) {
    HWY_DYNAMIC_DISPATCH(push_kernel)(level);
}

std::size_t layer_scratch(int width) {
    return static_cast<std::size_t>(width + 32) * 34; // three rows of eleven planes, and a blank one
}

void layer_pass(const LayerPass& pass, double sums[12]) {
    HWY_DYNAMIC_DISPATCH(layer_pass_kernel)(pass, sums);
}

Curvature curvature(const float* whole, const float* whole_fill, int stride, const TexelRect& box,
                    float radiance_scale) {
    Curvature out;
    HWY_DYNAMIC_DISPATCH(curvature_kernel)(whole, whole_fill, stride, box, radiance_scale, out);
    return out;
}

void match_mips(const MatchMips& level) {
    HWY_DYNAMIC_DISPATCH(match_mips_kernel)(level);
}

void add_node_row(const float* map, const float* colour, float weight, int width, float* sum, float* weights) {
    HWY_DYNAMIC_DISPATCH(add_node_row_kernel)(map, colour, weight, width, sum, weights);
}

} // namespace alpenglow::impostors
#endif
