// Aerial perspective over many paths: aerial_perspective.glsl with lanes over the paths. Depths are kept times log2(e),
// so that their exponentials are powers of two.
#include <alpenglow/sky/aerial_perspective.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "aerial_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef ALPENGLOW_SKY_AERIAL_BATCH
#define ALPENGLOW_SKY_AERIAL_BATCH
namespace alpenglow::sky {

// What all paths share.
struct AerialView {
    float sun[3], g;
    float lux[3], ambient[3];
    float rayleigh_length[3], mie_length[3];   // scattering times scale height at the viewer's height, times log2(e)
    float share[3];                            // the aerosol's
    float drift[3];                            // times share (1 - share) rise depth: the slope of the share
    float rayleigh_per_height, mie_per_height; // log2(e) over the scale heights
    float mie_height_m;
};

} // namespace alpenglow::sky
#endif

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sky::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

HWY_INLINE V set(float x) {
    return hn::Set(D(), x);
}

// 1 - 2^-x without cancellation, for |x| <= 126; relative error 2e-5.
HWY_INLINE V fallen(V x) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    const V shifted = hn::Add(x, set(12582912.0F)); // rounds to a whole number in the low bits
    const V r = hn::Sub(x, hn::Sub(shifted, set(12582912.0F)));
    // 1 - 2^-r on -1/2 .. 1/2.
    V p = set(-0.00965671029F);
    p = hn::MulAdd(p, r, set(0.0558382829F));
    p = hn::MulAdd(p, r, set(-0.240225301F));
    p = hn::MulAdd(p, r, set(0.693136734F));
    const auto bits = hn::ShiftLeft<23>(hn::BitCast(du, shifted));
    const V scale = hn::BitCast(d, hn::Sub(hn::Set(du, 0x3f800000U), bits));
    return hn::MulAdd(hn::Mul(scale, r), p, hn::Sub(set(1.0F), scale));
}

// a / b for b within 1e-37 .. 1e37: a division costs as much as a dozen multiplications, so on x86 one Newton step on
// the instruction's 12 or 14 bits; others start from fewer bits and divide.
HWY_INLINE V over(V a, V b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
    const V r = hn::ApproximateReciprocal(b);
    return hn::Mul(hn::Mul(a, r), hn::NegMulAdd(b, r, set(2.0F)));
#else
    return hn::Div(a, b);
#endif
}

struct Stretch {
    V fallen_rayleigh, fallen_mie; // 1 - density at the end over density at the start
    V transmittance[3], in_scatter[3];
};

// A stretch that begins where the view has its densities, times rayleigh0 and mie0; at the viewer these are 1.
template <bool Near>
HWY_INLINE Stretch stretch(const AerialView& view, V rise, V inverse_rise, V distance, V rayleigh0, V mie0,
                           const V* rayleigh_source, const V* source_gain) {
    // 2^60 times the density at the start is ground, not air: what lies deeper is as opaque and stays finite here.
    const V limit = set(60.0F);
    const V climb = hn::Mul(rise, distance);
    const auto held = [&](float per_height)
                          HWY_ATTR { return hn::Max(hn::Min(hn::Mul(climb, set(per_height)), limit), hn::Neg(limit)); };
    Stretch out;
    out.fallen_rayleigh = fallen(held(view.rayleigh_per_height));
    out.fallen_mie = fallen(held(view.mie_per_height));
    V a = hn::Mul(out.fallen_rayleigh, inverse_rise);
    V b = hn::Mul(out.fallen_mie, inverse_rise);
    if (!Near) {
        a = hn::Mul(a, rayleigh0);
        b = hn::Mul(b, mie0);
    }
    const V tiny = set(1e-30F);
    const V zero = hn::Zero(D());
    for (std::size_t k = 0; k < 3; ++k) {
        const V mie = hn::Mul(b, set(view.mie_length[k]));
        const V depth = hn::MulAdd(a, set(view.rayleigh_length[k]), mie);
        V share = set(view.share[k]);
        V slope;
        if (Near) {
            slope = hn::Mul(hn::Mul(rise, set(view.drift[k] * view.share[k] * (1.0F - view.share[k]))), depth);
        } else {
            const V m = hn::Mul(share, mie0);
            const V r = hn::Mul(set(1.0F - view.share[k]), rayleigh0);
            const V inverse = over(set(1.0F), hn::Max(hn::Add(m, r), tiny));
            share = hn::Mul(m, inverse);
            const V both = hn::Mul(share, hn::Mul(r, inverse));
            slope = hn::Mul(hn::Mul(hn::Mul(rise, set(view.drift[k])), both), hn::Mul(depth, inverse));
        }
        const V drift = hn::Sub(over(mie, hn::Max(depth, tiny)), share);
        const V most = hn::Mul(drift, set(4.0F));
        slope = hn::Max(hn::Min(slope, hn::Max(most, zero)), hn::Min(most, zero));
        constexpr float ln2 = 0.69314718F;
        const V held_depth = hn::Min(depth, set(126.0F));
        const V below = hn::MulAdd(held_depth, hn::MulAdd(held_depth, set(ln2 * ln2), set(3.0F * ln2)), set(6.0F));
        const V first = over(hn::MulAdd(held_depth, set(ln2), set(3.0F)), below);
        const V second = hn::Mul(hn::Mul(first, first), hn::NegMulAdd(first, set(4.0F / 3.0F), set(2.0F)));
        const V bend = hn::MulAdd(slope, set(-1.5F), hn::Mul(drift, set(3.0F)));
        const V seen = hn::MulAdd(bend, second, hn::MulAdd(slope, first, share));
        const V gone = fallen(held_depth);
        out.transmittance[k] = hn::Sub(set(1.0F), gone);
        out.in_scatter[k] = hn::Mul(gone, hn::MulAdd(source_gain[k], seen, rayleigh_source[k]));
    }
    return out;
}

void Batch(const AerialView& view, const float* HWY_RESTRICT xs, const float* HWY_RESTRICT ys,
           const float* HWY_RESTRICT zs, const float* HWY_RESTRICT distances, std::size_t count,
           float* const* HWY_RESTRICT outs) {
    const D d;
    const V one = set(1.0F);
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = 0; i < count; i += lanes) {
        const std::size_t left = count - i;
        const auto load = [&](const float* p) HWY_ATTR {
            return left >= lanes ? hn::LoadU(d, p + i) : hn::MaskedLoad(hn::FirstN(d, left), d, p + i);
        };
        const V z = load(zs);
        const V distance = load(distances);
        V cosine = hn::MulAdd(load(xs), set(view.sun[0]),
                              hn::MulAdd(load(ys), set(view.sun[1]), hn::Mul(z, set(view.sun[2]))));
        cosine = hn::Max(hn::Min(cosine, one), hn::Neg(one));
        // Level paths as ones that climb a micrometre a metre.
        const V rise = hn::IfThenElse(hn::Lt(hn::Abs(z), set(1e-6F)), set(1e-6F), z);
        const V inverse_rise = over(one, rise);

        const V rayleigh_phase = hn::MulAdd(hn::Mul(cosine, cosine), set(0.0596831037F), set(0.0596831037F));
        const float g = view.g;
        const V q = hn::MulAdd(hn::Sub(one, cosine), set(2.0F * g), set((1.0F - g) * (1.0F - g)));
        const V mie_phase = over(set(0.0795774715F * (1.0F - g * g)), hn::Max(hn::Mul(q, hn::Sqrt(q)), set(1e-12F)));
        const V gain = hn::Sub(mie_phase, rayleigh_phase);
        V source[3];
        V source_gain[3];
        for (std::size_t k = 0; k < 3; ++k) {
            source[k] = hn::MulAdd(rayleigh_phase, set(view.lux[k]), set(view.ambient[k]));
            source_gain[k] = hn::Mul(gain, set(view.lux[k]));
        }
        const V climb = hn::Abs(hn::Mul(rise, distance));
        const V cut = set(2.0F * view.mie_height_m);
        const auto far = hn::Gt(climb, cut);
        Stretch all;
        if (HWY_LIKELY(hn::AllFalse(d, far))) {
            all = stretch<true>(view, rise, inverse_rise, distance, one, one, source, source_gain);
        } else {
            const V low = hn::Abs(hn::Mul(cut, inverse_rise));
            const V first =
                hn::IfThenElse(far, hn::IfThenElse(hn::Gt(rise, hn::Zero(d)), low, hn::Sub(distance, low)), distance);
            all = stretch<true>(view, rise, inverse_rise, first, one, one, source, source_gain);
            const Stretch beyond =
                stretch<false>(view, rise, inverse_rise, hn::Max(hn::Sub(distance, first), hn::Zero(d)),
                               hn::Sub(one, all.fallen_rayleigh), hn::Sub(one, all.fallen_mie), source, source_gain);
            for (std::size_t k = 0; k < 3; ++k) {
                all.in_scatter[k] = hn::MulAdd(all.transmittance[k], beyond.in_scatter[k], all.in_scatter[k]);
                all.transmittance[k] = hn::Mul(all.transmittance[k], beyond.transmittance[k]);
            }
        }
        const auto store = [&](V v, float* p) HWY_ATTR {
            if (left >= lanes) {
                hn::StoreU(v, d, p + i);
            } else {
                hn::BlendedStore(v, hn::FirstN(d, left), d, p + i);
            }
        };
        for (std::size_t k = 0; k < 3; ++k) {
            store(all.transmittance[k], outs[k]);
            store(all.in_scatter[k], outs[3 + k]);
        }
    }
}

} // namespace
} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sky {

HWY_EXPORT(Batch);

void aerial_perspective(const Air& air, float height_m, const glm::vec3& to_sun, const glm::vec3& sun_lux,
                        const glm::vec3& ambient_cd_m2, const AerialPaths& paths, const AerialPerspectives& out) {
    const std::size_t count = paths.x.size();
    assert(paths.y.size() == count && paths.z.size() == count && paths.distance_m.size() == count);
    assert(out.transmittance_r.size() == count && out.transmittance_g.size() == count &&
           out.transmittance_b.size() == count && out.in_scatter_r.size() == count &&
           out.in_scatter_g.size() == count && out.in_scatter_b.size() == count);
    AerialView view{};
    constexpr double log2_e = 1.4426950408889634;
    const double rayleigh_height = air.rayleigh_height_m;
    const double mie_height = air.mie_height_m;
    const double rayleigh_density = std::exp(std::clamp(-double(height_m) / rayleigh_height, -80.0, 2.0));
    const double mie_density = std::exp(std::clamp(-double(height_m) / mie_height, -80.0, 2.0));
    view.g = air.mie_g;
    view.rayleigh_per_height = static_cast<float>(log2_e / rayleigh_height);
    view.mie_per_height = static_cast<float>(log2_e / mie_height);
    view.mie_height_m = air.mie_height_m;
    for (int k = 0; k < 3; ++k) {
        const double rayleigh = double(air.rayleigh_per_m[k]) * rayleigh_density;
        const double mie = double(air.mie_per_m[k]) * mie_density;
        const double both = std::max(rayleigh + mie, 1e-30);
        const double share = mie / both;
        view.sun[k] = to_sun[k];
        view.lux[k] = sun_lux[k];
        view.ambient[k] = ambient_cd_m2[k];
        view.rayleigh_length[k] = static_cast<float>(rayleigh * rayleigh_height * log2_e);
        view.mie_length[k] = static_cast<float>(mie * mie_height * log2_e);
        view.share[k] = static_cast<float>(share);
        view.drift[k] = static_cast<float>((1.0 / rayleigh_height - 1.0 / mie_height) / (both * log2_e));
    }
    float* const outs[6] = {out.transmittance_r.data(), out.transmittance_g.data(), out.transmittance_b.data(),
                            out.in_scatter_r.data(),    out.in_scatter_g.data(),    out.in_scatter_b.data()};
    HWY_DYNAMIC_DISPATCH(Batch)
    (view, paths.x.data(), paths.y.data(), paths.z.data(), paths.distance_m.data(), count, outs);
}

} // namespace alpenglow::sky
#endif
