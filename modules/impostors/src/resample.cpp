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

struct Colour {
    V r, g, b, a;
};

// Four texels around (x, y), in texels of this mip with centres at halves; transparent outside, or held to the rim.
HWY_INLINE Colour bilinear(const ResampleInput& in, const ResampleMip& mip, V x, V y) {
    const D d;
    const DI di;
    const V half = hn::Set(d, 0.5F);
    const V one = hn::Set(d, 1.0F);
    // Far outside nothing is read; the clamp keeps integers in their range.
    const V px = hn::Min(hn::Max(hn::Sub(x, half), hn::Set(d, -2.0F)), hn::Set(d, static_cast<float>(mip.width + 1)));
    const V py = hn::Min(hn::Max(hn::Sub(y, half), hn::Set(d, -2.0F)), hn::Set(d, static_cast<float>(mip.height + 1)));
    const V fx = hn::Floor(px);
    const V fy = hn::Floor(py);
    const V s = hn::Sub(px, fx);
    const V t = hn::Sub(py, fy);
    const VI ix = hn::ConvertTo(di, fx);
    const VI iy = hn::ConvertTo(di, fy);
    const VI zero = hn::Zero(di);
    const VI right = hn::Set(di, mip.width - 1);
    const VI bottom = hn::Set(di, mip.height - 1);
    const VI x0 = hn::Min(hn::Max(ix, zero), right);
    const VI x1 = hn::Min(hn::Max(hn::Add(ix, hn::Set(di, 1)), zero), right);
    const VI y0 = hn::Min(hn::Max(iy, zero), bottom);
    const VI y1 = hn::Min(hn::Max(hn::Add(iy, hn::Set(di, 1)), zero), bottom);
    V wx0 = hn::Sub(one, s);
    V wx1 = s;
    V wy0 = hn::Sub(one, t);
    V wy1 = t;
    if (!in.open_edges) {
        const auto inside = [&](VI clamped, VI index, V weight) {
            return hn::IfThenElseZero(hn::RebindMask(d, hn::Eq(clamped, index)), weight);
        };
        wx0 = inside(x0, ix, wx0);
        wx1 = inside(x1, hn::Add(ix, hn::Set(di, 1)), wx1);
        wy0 = inside(y0, iy, wy0);
        wy1 = inside(y1, hn::Add(iy, hn::Set(di, 1)), wy1);
    }
    const VI width = hn::Set(di, mip.width);
    const VI row0 = hn::Mul(y0, width);
    const VI row1 = hn::Mul(y1, width);
    const VI at[4] = {hn::ShiftLeft<2>(hn::Add(row0, x0)), hn::ShiftLeft<2>(hn::Add(row0, x1)),
                      hn::ShiftLeft<2>(hn::Add(row1, x0)), hn::ShiftLeft<2>(hn::Add(row1, x1))};
    const V weight[4] = {hn::Mul(wx0, wy0), hn::Mul(wx1, wy0), hn::Mul(wx0, wy1), hn::Mul(wx1, wy1)};
    const auto channel = [&](const float* texels) {
        V sum = hn::Mul(weight[0], hn::GatherIndex(d, texels, at[0]));
        sum = hn::MulAdd(weight[1], hn::GatherIndex(d, texels, at[1]), sum);
        sum = hn::MulAdd(weight[2], hn::GatherIndex(d, texels, at[2]), sum);
        return hn::MulAdd(weight[3], hn::GatherIndex(d, texels, at[3]), sum);
    };
    Colour c{hn::Mul(channel(mip.colour), hn::Set(d, in.key[0])),
             hn::Mul(channel(mip.colour + 1), hn::Set(d, in.key[1])),
             hn::Mul(channel(mip.colour + 2), hn::Set(d, in.key[2])), channel(mip.colour + 3)};
    if (mip.fill != nullptr) {
        c.r = hn::MulAdd(channel(mip.fill), hn::Set(d, in.fill[0]), c.r);
        c.g = hn::MulAdd(channel(mip.fill + 1), hn::Set(d, in.fill[1]), c.g);
        c.b = hn::MulAdd(channel(mip.fill + 2), hn::Set(d, in.fill[2]), c.b);
    }
    return c;
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

void row_kernel(const ResampleInput& in, const ResampleRow& row, float* rgba) {
    const D d;
    const DI di;
    const V one = hn::Set(d, 1.0F);
    const V zero = hn::Zero(d);
    const auto lanes = static_cast<int>(hn::Lanes(d));
    alignas(64) std::int32_t block[16];
    alignas(64) float out[4][16];
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
        const M live = hn::And(hn::Not(level), hn::Lt(i, hn::Set(d, static_cast<float>(row.pixels))));
        Colour sum{zero, zero, zero, zero};
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
                for (int step = 0; step < 3; ++step) {
                    const V s = warp_at(layer, hn::MulAdd(u1, w, u0), hn::MulAdd(v1, w, v0));
                    z = hn::MulAdd(s, hn::Set(d, in.depth_scale_m), hn::Set(d, in.depth_origin_m));
                    z = hn::Min(hn::Max(z, hn::Set(d, layer.near_m)), hn::Set(d, layer.far_m));
                    w = hn::Div(one, z);
                }
            }
            const V u = hn::MulAdd(u1, w, u0);
            const V v = hn::MulAdd(v1, w, v0);
            const V beyond = hn::Set(d, in.open_edges ? 0.0F : 1.0F);
            M seen = hn::And(live, hn::Gt(hn::Mul(hn::Sub(z, hn::Set(d, in.eye_z)), vz), zero));
            seen = hn::And(seen, hn::And(hn::Ge(u, hn::Neg(beyond)), hn::Ge(v, hn::Neg(beyond))));
            seen = hn::And(seen, hn::And(hn::Le(u, hn::Add(hn::Set(d, static_cast<float>(layer.width)), beyond)),
                                         hn::Le(v, hn::Add(hn::Set(d, static_cast<float>(layer.height)), beyond))));
            if (hn::AllFalse(d, seen)) {
                continue;
            }
            const V su = hn::IfThenElseZero(seen, u); // of the rest nothing is kept
            const V sv = hn::IfThenElseZero(seen, v);
            const V left = hn::IfThenElseZero(seen, hn::Sub(one, sum.a));
            for (int m = 0; m < layer.mip_count; ++m) {
                const ResampleMip& mip = layer.mips[m];
                const V scale = hn::Set(d, mip.scale);
                const Colour c = bilinear(in, mip, hn::Mul(su, scale), hn::Mul(sv, scale));
                const V share = hn::Mul(left, hn::Set(d, mip.weight));
                sum.r = hn::MulAdd(share, c.r, sum.r);
                sum.g = hn::MulAdd(share, c.g, sum.g);
                sum.b = hn::MulAdd(share, c.b, sum.b);
                sum.a = hn::MulAdd(share, c.a, sum.a);
            }
            if (hn::AllTrue(d, hn::Or(hn::Gt(sum.a, hn::Set(d, 0.9995F)), hn::Not(live)))) {
                break;
            }
        }
        const V weight = hn::Set(d, in.weight);
        hn::Store(hn::Mul(sum.r, weight), d, out[0]);
        hn::Store(hn::Mul(sum.g, weight), d, out[1]);
        hn::Store(hn::Mul(sum.b, weight), d, out[2]);
        hn::Store(hn::Mul(sum.a, weight), d, out[3]);
        for (int lane = 0; lane < lanes && first + lane < row.pixels; ++lane) {
            float* pixel = rgba + 4 * static_cast<std::ptrdiff_t>(first + lane);
            for (int c = 0; c < 4; ++c) {
                pixel[c] += out[c][lane];
            }
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
