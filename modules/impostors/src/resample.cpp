#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "resample.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "resample.hpp"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::impostors::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

constexpr int most_lanes = 16;

// Taps of a filter for a vector of pixels: offsets in floats, and weights, along x and along y.
template <int taps>
struct Taps {
    alignas(64) std::int32_t column[taps][most_lanes];
    alignas(64) std::int32_t row[taps][most_lanes];
    alignas(64) float along[taps][most_lanes];
    alignas(64) float down[taps][most_lanes];
};

// One dimension: `at` in texels of this mip with centres at halves; transparent outside, or held to the rim.
template <int taps>
HWY_INLINE void place(V at, int size, int stride, bool open, float cubic_b, std::int32_t (*offset)[most_lanes],
                      float (*weight)[most_lanes]) {
    const D d;
    const DI di;
    const V one = hn::Set(d, 1.0F);
    // Far outside nothing is read; the clamp keeps integers in their range.
    const V p =
        hn::Min(hn::Max(hn::Sub(at, hn::Set(d, 0.5F)), hn::Set(d, -3.0F)), hn::Set(d, static_cast<float>(size + 2)));
    const V whole = hn::Floor(p);
    const V t = hn::Sub(p, whole);
    V w[taps];
    if constexpr (taps == 2) {
        w[0] = hn::Sub(one, t);
        w[1] = t;
    } else { // Mitchell and Netravali's cubics with 2 C + B = 1: Catmull and Rom's plus B of a blur
        const V t2 = hn::Mul(t, t);
        const V t3 = hn::Mul(t2, t);
        const V b = hn::Set(d, cubic_b * (1.0F / 6.0F));
        const auto cubic = [&](float k3, float k2, float k1, float k0) HWY_ATTR {
            return hn::MulAdd(hn::Set(d, k3), t3,
                              hn::MulAdd(hn::Set(d, k2), t2, hn::MulAdd(hn::Set(d, k1), t, hn::Set(d, k0))));
        };
        w[0] = hn::MulAdd(b, cubic(2.0F, -3.0F, 0.0F, 1.0F), cubic(-0.5F, 1.0F, -0.5F, 0.0F));
        w[1] = hn::MulAdd(b, cubic(-6.0F, 9.0F, 0.0F, -2.0F), cubic(1.5F, -2.5F, 0.0F, 1.0F));
        w[2] = hn::MulAdd(b, cubic(6.0F, -9.0F, 0.0F, 1.0F), cubic(-1.5F, 2.0F, 0.5F, 0.0F));
        w[3] = hn::MulAdd(b, cubic(-2.0F, 3.0F, 0.0F, 0.0F), cubic(0.5F, -0.5F, 0.0F, 0.0F));
    }
    const VI first = hn::ConvertTo(di, whole);
    for (int k = 0; k < taps; ++k) {
        const VI index = hn::Add(first, hn::Set(di, k + (taps == 2 ? 0 : -1)));
        const VI clamped = hn::Min(hn::Max(index, hn::Zero(di)), hn::Set(di, size - 1));
        hn::Store(hn::Mul(clamped, hn::Set(di, 4 * stride)), di, offset[k]);
        hn::Store(open ? w[k] : hn::IfThenElseZero(hn::RebindMask(d, hn::Eq(clamped, index)), w[k]), d, weight[k]);
    }
}

// The texels of one pixel, weighted: RGBA to `out`.
template <int taps>
HWY_INLINE void gather(const float* texels, const Taps<taps>& t, int lane, float* out) {
    const hn::CappedTag<float, 4> d4;
    const auto lanes4 = static_cast<int>(hn::Lanes(d4));
    for (int c = 0; c < 4; c += lanes4) {
        auto sum = hn::Zero(d4);
        for (int j = 0; j < taps; ++j) {
            const float* row = texels + t.row[j][lane] + c;
            auto line = hn::Mul(hn::Set(d4, t.along[0][lane]), hn::LoadU(d4, row + t.column[0][lane]));
            for (int i = 1; i < taps; ++i) {
                line = hn::MulAdd(hn::Set(d4, t.along[i][lane]), hn::LoadU(d4, row + t.column[i][lane]), line);
            }
            sum = hn::MulAdd(hn::Set(d4, t.down[j][lane]), line, sum);
        }
        if constexpr (taps == 4) { // a cubic overshoots: light and matter stay what they can be
            sum = hn::Max(sum, hn::Zero(d4));
        }
        hn::StoreU(sum, d4, out + c);
    }
}

// Sums of one pixel, front to back, of both lights apart.
struct Sums {
    alignas(16) float key[4];
    alignas(16) float fill[4];
};

HWY_INLINE void add(float share, const float* colour, float* sum) {
    const hn::CappedTag<float, 4> d4;
    const auto lanes4 = static_cast<int>(hn::Lanes(d4));
    for (int c = 0; c < 4; c += lanes4) {
        hn::StoreU(hn::MulAdd(hn::Set(d4, share), hn::LoadU(d4, colour + c), hn::LoadU(d4, sum + c)), d4, sum + c);
    }
}

// One layer for the pixels in `seen`: bits by lane.
template <int taps>
HWY_INLINE void add_layer(const ResampleInput& in, const ResampleLayer& layer, V u, V v, std::uint32_t seen,
                          Sums* sums) {
    const D d;
    Taps<taps> t;
    float left[most_lanes];
    for (std::uint32_t rest = seen, lane = 0; rest != 0; rest >>= 1, ++lane) {
        left[lane] = 1.0F - sums[lane].key[3];
    }
    for (int m = 0; m < layer.mip_count; ++m) {
        const ResampleMip& mip = layer.mips[m];
        const V scale = hn::Set(d, mip.scale);
        place<taps>(hn::Mul(u, scale), mip.width, 1, in.open_edges, mip.cubic_b, t.column, t.along);
        place<taps>(hn::Mul(v, scale), mip.height, mip.width, in.open_edges, mip.cubic_b, t.row, t.down);
        int lane = 0;
        for (std::uint32_t rest = seen; rest != 0; rest >>= 1, ++lane) {
            if ((rest & 1U) == 0) {
                continue;
            }
            alignas(16) float colour[4];
            const float share = left[lane] * mip.weight;
            gather(mip.colour, t, lane, colour);
            if constexpr (taps == 4) {
                colour[3] = colour[3] < 1.0F ? colour[3] : 1.0F;
            }
            add(share, colour, sums[lane].key);
            if (mip.fill != nullptr) {
                gather(mip.fill, t, lane, colour);
                add(share, colour, sums[lane].fill);
            }
        }
    }
}

HWY_INLINE V warp_at(const ResampleLayer& layer, V u, V v) {
    const D d;
    const DI di;
    const V half = hn::Set(d, 0.5F);
    const V zero = hn::Zero(d);
    const V x = hn::Min(hn::Max(hn::Sub(u, half), zero), hn::Set(d, static_cast<float>(layer.width - 1)));
    const V y = hn::Min(hn::Max(hn::Sub(v, half), zero), hn::Set(d, static_cast<float>(layer.height - 1)));
    const VI x0 = hn::ConvertTo(di, x);
    const VI y0 = hn::ConvertTo(di, y);
    const VI x1 = hn::Min(hn::Add(x0, hn::Set(di, 1)), hn::Set(di, layer.width - 1));
    const VI y1 = hn::Min(hn::Add(y0, hn::Set(di, 1)), hn::Set(di, layer.height - 1));
    const V s = hn::Sub(x, hn::ConvertTo(d, x0));
    const V t = hn::Sub(y, hn::ConvertTo(d, y0));
    const VI width = hn::Set(di, layer.width);
    const auto at = [&](VI i, VI j) { return hn::GatherIndex(d, layer.warp, hn::Add(hn::Mul(j, width), i)); };
    const V above = hn::MulAdd(s, hn::Sub(at(x1, y0), at(x0, y0)), at(x0, y0));
    const V below = hn::MulAdd(s, hn::Sub(at(x1, y1), at(x0, y1)), at(x0, y1));
    return hn::MulAdd(t, hn::Sub(below, above), above);
}

// See reproject.cpp.
template <class Above>
HWY_INLINE V first_crossing(const ResampleLayer& layer, const Above& above) {
    const D d;
    const V zero = hn::Zero(d);
    const float front = 1.0F / layer.near_m;
    const float back = 1.0F / layer.far_m;
    V w1 = hn::Set(d, front);
    V f1 = above(w1);
    V w0 = w1;
    V f0 = f1;
    for (int k = 1; k <= layer.search; ++k) {
        const M open = hn::Lt(f1, zero);
        if (hn::AllFalse(d, open)) {
            break;
        }
        const V w = hn::Set(d, front + (back - front) * (static_cast<float>(k) / static_cast<float>(layer.search)));
        const V f = above(w);
        w0 = hn::IfThenElse(open, w1, w0);
        f0 = hn::IfThenElse(open, f1, f0);
        w1 = hn::IfThenElse(open, w, w1);
        f1 = hn::IfThenElse(open, f, f1);
    }
    const auto between = [&]() HWY_ATTR {
        const V rise = hn::Sub(f1, f0);
        const M some = hn::Gt(rise, zero);
        const V share = hn::Div(hn::Neg(f0), hn::IfThenElse(some, rise, hn::Set(d, 1.0F)));
        return hn::IfThenElse(some, hn::MulAdd(hn::Sub(w1, w0), share, w0), w1);
    };
    const V w = between();
    const V f = above(w);
    const M before = hn::Lt(f, zero);
    w0 = hn::IfThenElse(before, w, w0);
    f0 = hn::IfThenElse(before, f, f0);
    w1 = hn::IfThenElse(before, w1, w);
    f1 = hn::IfThenElse(before, f1, f);
    return between();
}

void row_kernel(const ResampleInput& in, const ResampleRow& row, float* rgba) {
    const D d;
    const DI di;
    const V one = hn::Set(d, 1.0F);
    const V zero = hn::Zero(d);
    const auto lanes = static_cast<int>(hn::Lanes(d));
    alignas(64) std::int32_t block[most_lanes];
    Sums sums[most_lanes];
    for (int first = 0; first < row.pixels; first += lanes) {
        const V i = hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<float>(first)));
        const auto ramp = [&](const Ramp& r) { return hn::MulAdd(i, hn::Set(d, r.step), hn::Set(d, r.first)); };
        const V vz = ramp(row.vz);
        const M level = hn::Lt(hn::Abs(vz), hn::Set(d, 1e-9F)); // along the planes
        const V inverse = hn::Div(one, hn::IfThenElse(level, one, vz));
        const V u0 = hn::Mul(ramp(row.u), inverse);
        const V v0 = hn::Mul(ramp(row.v), inverse);
        const V u1 = hn::Mul(ramp(row.eu), inverse);
        const V v1 = hn::Mul(ramp(row.ev), inverse);
        const std::uint32_t pixels = row.pixels - first >= lanes
                                         ? (1U << static_cast<unsigned>(lanes)) - 1U
                                         : (1U << static_cast<unsigned>(row.pixels - first)) - 1U;
        const M live = hn::And(hn::Not(level), hn::Lt(i, hn::Set(d, static_cast<float>(row.pixels))));
        for (int lane = 0; lane < lanes; ++lane) {
            sums[lane] = {};
        }
        std::uint32_t open = 0xFFFFU; // pixels that let something through
        for (int l = 0; l < in.layer_count; ++l) {
            const ResampleLayer& layer = in.layers[l];
            V w = hn::Set(d, layer.w_plane);
            if (layer.skip_by_blocks) { // nothing here, nor in the blocks around: nothing to find
                const V reach =
                    layer.warp == nullptr ? zero : hn::Mul(hn::Max(hn::Abs(u1), hn::Abs(v1)), hn::Set(d, layer.spread));
                if (hn::AllTrue(d, hn::Or(hn::Lt(reach, hn::Set(d, 6.0F)), hn::Not(live)))) {
                    const V u =
                        hn::Min(hn::Max(hn::MulAdd(u1, w, u0), zero), hn::Set(d, static_cast<float>(layer.width - 1)));
                    const V v =
                        hn::Min(hn::Max(hn::MulAdd(v1, w, v0), zero), hn::Set(d, static_cast<float>(layer.height - 1)));
                    const VI at =
                        hn::Add(hn::Mul(hn::ShiftRight<3>(hn::ConvertTo(di, v)), hn::Set(di, layer.blocks_across)),
                                hn::ShiftRight<3>(hn::ConvertTo(di, u)));
                    hn::Store(at, di, block);
                    int any = 0;
                    for (int lane = 0; lane < lanes; ++lane) {
                        any |= layer.occupied[block[lane]];
                    }
                    if (any == 0) {
                        continue;
                    }
                }
            }
            V z = hn::Div(one, w);
            if (layer.warp != nullptr) {
                const auto depth_at = [&](V at) HWY_ATTR {
                    const V s = warp_at(layer, hn::MulAdd(u1, at, u0), hn::MulAdd(v1, at, v0));
                    const V depth = hn::MulAdd(s, hn::Set(d, in.depth_scale_m), hn::Set(d, in.depth_origin_m));
                    return hn::Min(hn::Max(depth, hn::Set(d, layer.near_m)), hn::Set(d, layer.far_m));
                };
                if (layer.search > 0) {
                    w = first_crossing(layer, [&](V at) HWY_ATTR { return hn::Sub(hn::Div(one, depth_at(at)), at); });
                    z = hn::Div(one, w);
                } else {
                    for (int step = 0; step < 3; ++step) {
                        z = depth_at(w);
                        w = hn::Div(one, z);
                    }
                }
            }
            const V u = hn::MulAdd(u1, w, u0);
            const V v = hn::MulAdd(v1, w, v0);
            const V beyond = hn::Set(d, in.open_edges ? 0.0F : 1.0F);
            M seen = hn::And(live, hn::Gt(hn::Mul(hn::Sub(z, hn::Set(d, in.eye_z)), vz), zero));
            seen = hn::And(seen, hn::And(hn::Ge(u, hn::Neg(beyond)), hn::Ge(v, hn::Neg(beyond))));
            seen = hn::And(seen, hn::And(hn::Le(u, hn::Add(hn::Set(d, static_cast<float>(layer.width)), beyond)),
                                         hn::Le(v, hn::Add(hn::Set(d, static_cast<float>(layer.height)), beyond))));
            std::uint8_t bits[8] = {};
            hn::StoreMaskBits(d, seen, bits);
            const std::uint32_t lit = (bits[0] | static_cast<std::uint32_t>(bits[1]) << 8U) & open;
            if (lit == 0) {
                continue;
            }
            const V su = hn::IfThenElseZero(seen, u); // of the rest nothing is kept
            const V sv = hn::IfThenElseZero(seen, v);
            if (in.cubic) {
                add_layer<4>(in, layer, su, sv, lit, sums);
            } else {
                add_layer<2>(in, layer, su, sv, lit, sums);
            }
            for (int lane = 0; lane < lanes; ++lane) {
                open &= ~(static_cast<std::uint32_t>(sums[lane].key[3] > 0.9995F) << static_cast<unsigned>(lane));
            }
            if ((open & pixels) == 0) {
                break;
            }
        }
        for (int lane = 0; lane < lanes && first + lane < row.pixels; ++lane) {
            float* pixel = rgba + 4 * static_cast<std::ptrdiff_t>(first + lane);
            const Sums& sum = sums[lane];
            for (int c = 0; c < 3; ++c) {
                pixel[c] += in.weight * (in.key[c] * sum.key[c] + in.fill[c] * sum.fill[c]);
            }
            pixel[3] += in.weight * sum.key[3];
        }
    }
}

} // namespace alpenglow::impostors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::impostors {
HWY_EXPORT(row_kernel);

void resample_row(const ResampleInput& input, const ResampleRow& row, float* rgba) {
    HWY_DYNAMIC_DISPATCH(row_kernel)(input, row, rgba);
}

} // namespace alpenglow::impostors
#endif
