// Dome models over many directions. Angles come from the chord to the sun, exponentials from a polynomial; both hold to
// 4e-7 relative.
#include <alpenglow/sky/dome.hpp>

#include <cassert>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dome_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "exponential-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sky::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

// Angle between unit vectors: 2 asin(chord / 2) to the nearer of the sun and its opposite.
HWY_INLINE V angle(V x, V y, V z, V sx, V sy, V sz, V cosine) {
    const D d;
    const auto behind = hn::Lt(cosine, hn::Zero(d));
    const V sign = hn::IfThenElse(behind, hn::Set(d, -1.0F), hn::Set(d, 1.0F));
    const V dx = hn::NegMulAdd(sign, sx, x);
    const V dy = hn::NegMulAdd(sign, sy, y);
    const V dz = hn::NegMulAdd(sign, sz, z);
    const V q =
        hn::Mul(hn::Set(d, 0.25F), hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)))); // sin^2 of the half
    // asin(s) / s on 0 .. 1/2 in q = s^2, error 1.6e-8.
    V p = hn::Set(d, 0.111960899F);
    p = hn::MulAdd(p, q, hn::Set(d, -0.0940462759F));
    p = hn::MulAdd(p, q, hn::Set(d, 0.078228919F));
    p = hn::MulAdd(p, q, hn::Set(d, 0.0158279045F));
    p = hn::MulAdd(p, q, hn::Set(d, 0.0466362156F));
    p = hn::MulAdd(p, q, hn::Set(d, 0.074868471F));
    p = hn::MulAdd(p, q, hn::Set(d, 0.166669932F));
    p = hn::MulAdd(p, q, hn::Set(d, 1.0F));
    const V a = hn::Mul(hn::Mul(hn::Set(d, 2.0F), hn::Sqrt(q)), p);
    return hn::IfThenElse(behind, hn::Sub(hn::Set(d, 3.14159265F), a), a);
}

struct Splat {
    V scale, g0, g1, a, b, s0, c, d, e;
};
// b and d times log2(e): exponentials are powers of two here.
HWY_INLINE Splat splat(const DomeTerm<float>& t) {
    const D d;
    constexpr float log2_e = 1.44269504F;
    return {hn::Set(d, t.scale), hn::Set(d, t.g0), hn::Set(d, t.g1),         hn::Set(d, t.a), hn::Set(d, t.b * log2_e),
            hn::Set(d, t.s0),    hn::Set(d, t.c),  hn::Set(d, t.d * log2_e), hn::Set(d, t.e)};
}

template <bool Linear>
HWY_INLINE V term(const Splat& t, V cosine, V inverse, V gamma, V squared) {
    V gradation = hn::MulAdd(t.a, power_of_two(hn::Mul(t.b, inverse)), t.g0);
    if (Linear) {
        gradation = hn::MulAdd(t.g1, cosine, gradation);
    }
    const V indicatrix = hn::MulAdd(t.c, power_of_two(hn::Mul(t.d, gamma)), hn::MulAdd(t.e, squared, t.s0));
    const V zero = hn::Zero(D());
    return hn::Mul(t.scale, hn::Mul(hn::Max(gradation, zero), hn::Max(indicatrix, zero)));
}

template <bool Plain>
HWY_INLINE void loop(const SkyDome<float>& dome, const float* HWY_RESTRICT xs, const float* HWY_RESTRICT ys,
                     const float* HWY_RESTRICT zs, std::size_t count, float* HWY_RESTRICT rs, float* HWY_RESTRICT gs,
                     float* HWY_RESTRICT bs) {
    const D d;
    const V sx = hn::Set(d, dome.to_sun.x);
    const V sy = hn::Set(d, dome.to_sun.y);
    const V sz = hn::Set(d, dome.to_sun.z);
    const Splat first = splat(dome.luminance[0]);
    const Splat second = splat(dome.luminance[1]);
    const auto chroma = [&](int k, float zenith) HWY_ATTR {
        const PerezCoefficients<float>& p = dome.chromaticity[static_cast<std::size_t>(k)];
        return splat({zenith, 1.0F, 0.0F, p.a, p.b, 1.0F, p.c, p.d, p.e, false});
    };
    const Splat cx = chroma(0, dome.zenith_xy.x);
    const Splat cy = chroma(1, dome.zenith_xy.y);
    const V grey = hn::Set(d, dome.grey);
    const V one = hn::Set(d, 1.0F);
    const V minus = hn::Set(d, -1.0F);
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = 0; i < count; i += lanes) {
        const std::size_t left = count - i;
        const auto load = [&](const float* p) HWY_ATTR {
            const V v = left >= lanes ? hn::LoadU(d, p + i) : hn::MaskedLoad(hn::FirstN(d, left), d, p + i);
            return hn::Max(hn::Min(v, one), minus);
        };
        const V x = load(xs);
        const V y = load(ys);
        const V z = load(zs);
        const V cosine = hn::MulAdd(x, sx, hn::MulAdd(y, sy, hn::Mul(z, sz)));
        const V held = hn::Max(hn::Min(cosine, one), minus);
        const V squared = hn::Mul(held, held);
        const V gamma = angle(x, y, z, sx, sy, sz, held);
        const V cos_theta = hn::Max(z, hn::Set(d, 1e-3F));
        const V inverse = hn::Div(one, cos_theta);
        V luminance = term<!Plain>(first, cos_theta, inverse, gamma, squared);
        if (!Plain) {
            luminance = hn::Add(luminance, term<true>(second, cos_theta, inverse, gamma, squared));
        }
        V u = term<false>(cx, cos_theta, inverse, gamma, squared);
        V v = term<false>(cy, cos_theta, inverse, gamma, squared);
        if (!Plain) {
            u = hn::MulAdd(grey, hn::Sub(hn::Set(d, 0.3127F), u), u);
            v = hn::MulAdd(grey, hn::Sub(hn::Set(d, 0.3290F), v), v);
        }
        const V scale = hn::Div(luminance, hn::Max(v, hn::Set(d, 1e-6F)));
        const V X = hn::Mul(u, scale);
        const V Z = hn::Mul(hn::Sub(hn::Sub(one, u), v), scale);
        const V Y = luminance;
        const V r = hn::MulAdd(hn::Set(d, 3.24096994F), X,
                               hn::MulAdd(hn::Set(d, -1.53738318F), Y, hn::Mul(hn::Set(d, -0.49861076F), Z)));
        const V g = hn::MulAdd(hn::Set(d, -0.96924364F), X,
                               hn::MulAdd(hn::Set(d, 1.87596750F), Y, hn::Mul(hn::Set(d, 0.04155506F), Z)));
        const V b = hn::MulAdd(hn::Set(d, 0.05563008F), X,
                               hn::MulAdd(hn::Set(d, -0.20397696F), Y, hn::Mul(hn::Set(d, 1.05697151F), Z)));
        // Into the gamut, as into_gamut does.
        const V least = hn::Min(r, hn::Min(g, b));
        const V white =
            hn::MulAdd(hn::Set(d, 0.2126F), r, hn::MulAdd(hn::Set(d, 0.7152F), g, hn::Mul(hn::Set(d, 0.0722F), b)));
        const V zero = hn::Zero(d);
        V out_r = r;
        V out_g = g;
        V out_b = b;
        const auto outside = hn::Lt(least, zero);
        if (HWY_UNLIKELY(!hn::AllFalse(d, outside))) {
            const V tiny = hn::Set(d, 1e-30F);
            const V keep =
                hn::IfThenElse(outside, hn::Div(hn::Max(white, zero), hn::Max(hn::Sub(white, least), tiny)), one);
            out_r = hn::Max(hn::MulAdd(keep, hn::Sub(r, white), white), zero);
            out_g = hn::Max(hn::MulAdd(keep, hn::Sub(g, white), white), zero);
            out_b = hn::Max(hn::MulAdd(keep, hn::Sub(b, white), white), zero);
        }
        if (left >= lanes) {
            hn::StoreU(out_r, d, rs + i);
            hn::StoreU(out_g, d, gs + i);
            hn::StoreU(out_b, d, bs + i);
        } else {
            const auto mask = hn::FirstN(d, left);
            hn::BlendedStore(out_r, mask, d, rs + i);
            hn::BlendedStore(out_g, mask, d, gs + i);
            hn::BlendedStore(out_b, mask, d, bs + i);
        }
    }
}

void Batch(const SkyDome<float>& dome, const float* x, const float* y, const float* z, std::size_t count, float* r,
           float* g, float* b) {
    const bool plain = dome.luminance[1].scale == 0.0F && dome.luminance[0].g1 == 0.0F && dome.grey == 0.0F;
    if (plain) {
        loop<true>(dome, x, y, z, count, r, g, b);
    } else {
        loop<false>(dome, x, y, z, count, r, g, b);
    }
}

} // namespace
} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sky {

HWY_EXPORT(Batch);

void radiance(const SkyDome<float>& dome, const Directions& v, const Radiances& out) {
    const std::size_t count = v.x.size();
    assert(v.y.size() == count && v.z.size() == count && out.r.size() == count && out.g.size() == count &&
           out.b.size() == count);
    if (dome.luminance[0].intermediate || dome.luminance[1].intermediate) {
        for (std::size_t i = 0; i < count; ++i) { // no product form: one at a time
            const glm::vec3 rgb = radiance(dome, glm::vec3(v.x[i], v.y[i], v.z[i]));
            out.r[i] = rgb.x;
            out.g[i] = rgb.y;
            out.b[i] = rgb.z;
        }
        return;
    }
    HWY_DYNAMIC_DISPATCH(Batch)
    (dome, v.x.data(), v.y.data(), v.z.data(), count, out.r.data(), out.g.data(), out.b.data());
}

} // namespace alpenglow::sky
#endif
