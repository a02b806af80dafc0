#include "scattering_simd.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scattering_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "exponential-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sky::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, march_lanes>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;

struct Cell {
    hn::Vec<DI> index;
    V fraction;
};

// Where the signed root of `x` lies in a row.
HWY_INLINE Cell cell_of(const AngleRow& row, V x) {
    const D d;
    const V w = hn::CopySign(hn::Sqrt(hn::Abs(x)), x);
    const V at = hn::Max(hn::Min(hn::Mul(hn::Sub(w, hn::Set(d, row.low)), hn::Set(d, row.scale)), hn::Set(d, row.last)),
                         hn::Zero(d));
    const auto index = hn::ConvertTo(DI(), at);
    return {index, hn::Sub(at, hn::ConvertTo(d, index))};
}

HWY_INLINE V lookup(const float* values, const Cell& cell) {
    const D d;
    const V a = hn::GatherIndex(d, values, cell.index);
    const V b = hn::GatherIndex(d, values + 1, cell.index);
    return hn::MulAdd(cell.fraction, hn::Sub(b, a), a);
}

template <std::size_t Kinds>
HWY_INLINE void single(const MarchStep* steps, std::size_t count, const AngleRow* sun, const float* r0_mu_s,
                       const float* nu, float (*out)[3][march_lanes]) {
    const D d;
    for (std::size_t lane = 0; lane < march_lanes; lane += hn::Lanes(d)) {
        const V base = hn::LoadU(d, r0_mu_s + lane);
        const V cosine = hn::LoadU(d, nu + lane);
        V sum[Kinds + 1][3]; // molecules; aerosol by kind
        for (std::size_t k = 0; k <= Kinds; ++k) {
            for (std::size_t c = 0; c < 3; ++c) {
                sum[k][c] = hn::Zero(d);
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            const MarchStep& step = steps[i];
            const V local = hn::Mul(hn::MulAdd(hn::Set(d, step.distance_km), cosine, base), hn::Set(d, step.inverse_r));
            const Cell cell = cell_of(sun[i], hn::Sub(local, hn::Set(d, step.mu_horizon)));
            for (std::size_t c = 0; c < 3; ++c) {
                const V light = lookup(sun[i].values + c * sun[i].stride, cell);
                const V mie = hn::Set(d, step.mie[c]);
                sum[0][c] = hn::MulAdd(hn::Set(d, step.rayleigh[c]), light, sum[0][c]);
                sum[1][c] = hn::MulAdd(mie, light, sum[1][c]);
                for (std::size_t k = 1; k < Kinds; ++k) {
                    sum[k + 1][c] =
                        hn::MulAdd(mie, lookup(sun[i].values + (3 * k + c) * sun[i].stride, cell), sum[k + 1][c]);
                }
            }
        }
        for (std::size_t k = 0; k <= Kinds; ++k) {
            for (std::size_t c = 0; c < 3; ++c) {
                hn::StoreU(sum[k][c], d, &out[k][c][lane]);
            }
        }
    }
}

void MarchSingle(const MarchStep* steps, std::size_t count, const AngleRow* sun, std::size_t kinds,
                 const float* r0_mu_s, const float* nu, float (*out)[3][march_lanes]) {
    if (kinds == 1) {
        single<1>(steps, count, sun, r0_mu_s, nu, out);
    } else {
        single<2>(steps, count, sun, r0_mu_s, nu, out);
    }
}

void MarchField(const MarchStep* steps, std::size_t count, const AngleRow* field, std::size_t functions, float r0,
                float mu, const float* mu_s, const float* nu, float (*out)[march_lanes]) {
    const D d;
    for (std::size_t lane = 0; lane < march_lanes; lane += hn::Lanes(d)) {
        const V sun = hn::LoadU(d, mu_s + lane);
        const V cosine = hn::LoadU(d, nu + lane);
        const V base = hn::Mul(hn::Set(d, r0), sun);
        V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (std::size_t i = 0; i < count; ++i) {
            const MarchStep& step = steps[i];
            const V local = hn::Mul(hn::MulAdd(hn::Set(d, step.distance_km), cosine, base), hn::Set(d, step.inverse_r));
            const Cell cell = cell_of(field[i], hn::Sub(local, hn::Set(d, step.mu_horizon)));
            // The ray in the step's own frame: z up, x towards the sun.
            const float z0 = (r0 * mu + step.distance_km) * step.inverse_r;
            const V z = hn::Set(d, z0);
            const V sine = hn::Sqrt(hn::Max(hn::NegMulAdd(local, local, hn::Set(d, 1.0F)), hn::Set(d, 1e-8F)));
            const V x = hn::Div(hn::NegMulAdd(local, z, cosine), sine);
            // Y_l^m without the phase's sign twice: the field was projected on the same functions.
            V y[6];
            y[0] = hn::Set(d, 0.2820947918F);
            y[1] = hn::Set(d, 0.4886025119F * z0);
            y[2] = hn::Mul(hn::Set(d, 0.4886025119F), x);
            y[3] = hn::Set(d, 0.3153915653F * (3.0F * z0 * z0 - 1.0F));
            y[4] = hn::Mul(hn::Set(d, 1.0925484306F * z0), x);
            y[5] = hn::Mul(hn::Set(d, 0.5462742153F), hn::MulAdd(hn::Add(x, x), x, hn::Set(d, z0 * z0 - 1.0F)));
            for (std::size_t f = 0; f < functions; ++f) {
                for (std::size_t c = 0; c < 3; ++c) {
                    const V value = lookup(field[i].values + (f * 3 + c) * field[i].stride, cell);
                    sum[c] = hn::MulAdd(y[f], value, sum[c]);
                }
            }
        }
        for (std::size_t c = 0; c < 3; ++c) {
            hn::StoreU(sum[c], d, &out[c][lane]);
        }
    }
}

// Nodes and weights of 12-point Gauss-Legendre on 0 .. 1.
constexpr float gauss_x[12] = {0.009219683F, 0.047941372F, 0.115048663F, 0.206341023F, 0.316084251F, 0.437383296F,
                               0.562616704F, 0.683915749F, 0.793658977F, 0.884951337F, 0.952058628F, 0.990780317F};
constexpr float gauss_w[12] = {0.023587668F, 0.053469663F, 0.080039164F, 0.101583713F, 0.116746268F, 0.124573523F,
                               0.124573523F, 0.116746268F, 0.101583713F, 0.080039164F, 0.053469663F, 0.023587668F};

void ShellTransmittance(const ShellKernel& shell, float height_km, const float* mu, float (*out)[march_lanes]) {
    const D d;
    const float r = shell.radius_km + height_km;
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.0F);
    for (std::size_t lane = 0; lane < march_lanes; lane += hn::Lanes(d)) {
        const V m = hn::LoadU(d, mu + lane);
        const V along = hn::Mul(hn::Set(d, r), m);
        const float above = (shell.top_km - height_km) * (shell.top_km + height_km + 2.0F * shell.radius_km);
        const V end = hn::Sub(hn::Sqrt(hn::Max(hn::MulAdd(along, along, hn::Set(d, above)), zero)), along);
        const V lowest = hn::Max(hn::Neg(along), zero);
        V rayleigh = zero;
        V mie = zero;
        V ozone = zero;
        for (int side = 0; side < 2; ++side) {
            const V length = side == 0 ? hn::Sub(end, lowest) : hn::Neg(lowest);
            const V size = hn::Abs(length);
            for (int k = 0; k < 12; ++k) {
                const float t = gauss_x[k];
                const V s = hn::MulAdd(length, hn::Set(d, t * t), lowest);
                const V squared = hn::Mul(s, hn::MulAdd(hn::Set(d, 2.0F), along, s));
                const V root = hn::Sqrt(hn::Max(hn::Add(squared, hn::Set(d, r * r)), zero));
                const V h =
                    hn::Max(hn::Add(hn::Set(d, height_km), hn::Div(squared, hn::Add(root, hn::Set(d, r)))), zero);
                const V w = hn::Mul(size, hn::Set(d, gauss_w[k] * 2.0F * t));
                rayleigh =
                    hn::MulAdd(w, exponential(hn::Mul(h, hn::Set(d, -1.0F / shell.rayleigh_height_km))), rayleigh);
                mie = hn::MulAdd(w, exponential(hn::Mul(h, hn::Set(d, -1.0F / shell.mie_height_km))), mie);
                const V tent = hn::NegMulAdd(hn::Abs(hn::Sub(h, hn::Set(d, 25.0F))), hn::Set(d, 1.0F / 15.0F), one);
                ozone = hn::MulAdd(w, hn::Max(tent, zero), ozone);
            }
        }
        for (std::size_t c = 0; c < 3; ++c) {
            const V depth =
                hn::MulAdd(rayleigh, hn::Set(d, shell.rayleigh[c]),
                           hn::MulAdd(mie, hn::Set(d, shell.mie[c]), hn::Mul(ozone, hn::Set(d, shell.ozone[c]))));
            const V t = exponential(hn::Neg(depth));
            const V around = hn::Mul(mie, hn::Set(d, shell.mie_scattering[c]));
            hn::StoreU(t, d, &out[c][lane]);
            hn::StoreU(hn::Mul(t, around), d, &out[3 + c][lane]);
            hn::StoreU(hn::Mul(hn::Mul(around, around), hn::Mul(t, hn::Set(d, 0.5F))), d, &out[6 + c][lane]);
        }
    }
}

} // namespace
} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sky {

HWY_EXPORT(MarchSingle);
HWY_EXPORT(MarchField);
HWY_EXPORT(ShellTransmittance);

void march_single(const MarchStep* steps, std::size_t count, const AngleRow* sun, std::size_t kinds,
                  const float* r0_mu_s, const float* nu, float (*out)[3][march_lanes]) {
    HWY_DYNAMIC_DISPATCH(MarchSingle)(steps, count, sun, kinds, r0_mu_s, nu, out);
}
void march_field(const MarchStep* steps, std::size_t count, const AngleRow* field, std::size_t functions, float r0,
                 float mu, const float* mu_s, const float* nu, float (*out)[march_lanes]) {
    HWY_DYNAMIC_DISPATCH(MarchField)(steps, count, field, functions, r0, mu, mu_s, nu, out);
}
void shell_transmittance(const ShellKernel& shell, float height_km, const float* mu, float (*out)[march_lanes]) {
    HWY_DYNAMIC_DISPATCH(ShellTransmittance)(shell, height_km, mu, out);
}

} // namespace alpenglow::sky
#endif
