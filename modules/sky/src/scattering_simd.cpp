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

HWY_INLINE Cell cell_of(V at, float last) {
    const D d;
    const V held = hn::Max(hn::Min(at, hn::Set(d, last)), hn::Zero(d));
    const auto index = hn::ConvertTo(DI(), held);
    return {index, hn::Sub(held, hn::ConvertTo(d, index))};
}

HWY_INLINE V lookup(const float* values, const Cell& cell) {
    const D d;
    const V a = hn::GatherIndex(d, values, cell.index);
    const V b = hn::GatherIndex(d, values + 1, cell.index);
    return hn::MulAdd(cell.fraction, hn::Sub(b, a), a);
}

// The part of a disc over an edge, x its centre's height over its radius: 1/2 + (x sqrt(1 - x^2) + asin x) / pi as a
// polynomial, error 2e-3.
HWY_INLINE V disc_part(V x) {
    const D d;
    const V held = hn::Max(hn::Min(x, hn::Set(d, 1.0F)), hn::Set(d, -1.0F));
    const V q = hn::Mul(held, held);
    V p = hn::MulAdd(hn::Set(d, -0.014598F), q, hn::Set(d, -0.015915F));
    p = hn::MulAdd(p, q, hn::Set(d, -0.106103F));
    p = hn::MulAdd(p, q, hn::Set(d, 0.636620F));
    return hn::Max(hn::MulAdd(held, p, hn::Set(d, 0.5F)), hn::Zero(d));
}

void MarchSingle(const ShellKernel& shell, const MarchStep* steps, std::size_t count, const SunRow* sun,
                 const float* r0_mu_s, const float* nu, float (*out)[3][march_lanes]) {
    const D d;
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.0F);
    const bool straight = shell.forward > 1e-6F;
    for (std::size_t lane = 0; lane < march_lanes; lane += hn::Lanes(d)) {
        const V base = hn::LoadU(d, r0_mu_s + lane);
        const V cosine = hn::LoadU(d, nu + lane);
        V sum[3][3];
        for (auto& kind : sum) {
            for (V& v : kind) {
                v = zero;
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            const MarchStep& step = steps[i];
            const V local = hn::Mul(hn::MulAdd(hn::Set(d, step.distance_km), cosine, base), hn::Set(d, step.inverse_r));
            const V over = hn::Sub(local, hn::Set(d, step.mu_horizon));
            const V part = disc_part(hn::Mul(over, hn::Set(d, step.inverse_sine * shell.inverse_disc)));
            if (hn::AllTrue(d, hn::Le(part, zero))) {
                continue;
            }
            const Cell cell = cell_of(hn::Mul(hn::Sqrt(hn::Max(over, zero)), hn::Set(d, sun[i].scale)), sun[i].last);
            const V molecules = lookup(sun[i].values, cell);
            const V aerosol = lookup(sun[i].values + sun[i].stride, cell);
            const V ozone = lookup(sun[i].values + 2 * sun[i].stride, cell);
            for (std::size_t c = 0; c < 3; ++c) {
                const V depth = hn::MulAdd(
                    molecules, hn::Set(d, shell.rayleigh[c]),
                    hn::MulAdd(aerosol, hn::Set(d, shell.mie[c]), hn::Mul(ozone, hn::Set(d, shell.ozone[c]))));
                const V light = hn::Mul(part, exponential(hn::Neg(depth)));
                const V scattered = hn::Mul(aerosol, hn::Set(d, shell.mie_scattering[c]));
                V around = hn::Mul(light, scattered);
                if (straight) {
                    const V x = hn::Mul(scattered, hn::Set(d, shell.forward));
                    // expm1 x: small x by its series.
                    const V series =
                        hn::Mul(x, hn::MulAdd(x, hn::MulAdd(x, hn::Set(d, 1.0F / 6.0F), hn::Set(d, 0.5F)), one));
                    const V grown = hn::IfThenElse(hn::Lt(x, hn::Set(d, 0.02F)), series, hn::Sub(exponential(x), one));
                    // Where light is nothing, grown may be huge: keep their product finite.
                    around =
                        hn::Mul(hn::Mul(light, hn::Min(grown, hn::Set(d, 1e30F))), hn::Set(d, 1.0F / shell.forward));
                }
                const V mie = hn::Set(d, step.mie[c]);
                sum[0][c] = hn::MulAdd(hn::Set(d, step.rayleigh[c]), light, sum[0][c]);
                sum[1][c] = hn::MulAdd(mie, light, sum[1][c]);
                sum[2][c] = hn::MulAdd(mie, around, sum[2][c]);
            }
        }
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t c = 0; c < 3; ++c) {
                hn::StoreU(sum[k][c], d, &out[k][c][lane]);
            }
        }
    }
}

// acos, error 7e-5 (Abramowitz and Stegun 1964, 4.4.45).
HWY_INLINE V angle_of(V x) {
    const D d;
    const V a = hn::Min(hn::Abs(x), hn::Set(d, 1.0F));
    V p = hn::MulAdd(hn::Set(d, -0.0187293F), a, hn::Set(d, 0.0742610F));
    p = hn::MulAdd(p, a, hn::Set(d, -0.2121144F));
    p = hn::MulAdd(p, a, hn::Set(d, 1.5707288F));
    const V angle = hn::Mul(p, hn::Sqrt(hn::Sub(hn::Set(d, 1.0F), a)));
    return hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 3.14159265F), angle), angle);
}

void MarchField(const MarchStep* steps, std::size_t count, const FieldRow* field, std::size_t modes, float r0, float mu,
                const float* mu_s, const float* nu, float (*out)[march_lanes]) {
    const D d;
    const V one = hn::Set(d, 1.0F);
    for (std::size_t lane = 0; lane < march_lanes; lane += hn::Lanes(d)) {
        const V sun = hn::LoadU(d, mu_s + lane);
        const V cosine = hn::LoadU(d, nu + lane);
        const V base = hn::Mul(hn::Set(d, r0), sun);
        V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (std::size_t i = 0; i < count; ++i) {
            const MarchStep& step = steps[i];
            const FieldRow& row = field[i];
            const V local = hn::Mul(hn::MulAdd(hn::Set(d, step.distance_km), cosine, base), hn::Set(d, step.inverse_r));
            const Cell cell =
                cell_of(hn::Mul(hn::Sub(angle_of(local), hn::Set(d, row.low_rad)), hn::Set(d, row.scale)), row.last);
            // The ray's azimuth from the sun in the step's own frame.
            const float z = (r0 * mu + step.distance_km) * step.inverse_r;
            const V sines = hn::Mul(hn::Set(d, 1.0F - z * z), hn::NegMulAdd(local, local, one));
            V x = hn::Div(hn::NegMulAdd(local, hn::Set(d, z), cosine), hn::Sqrt(hn::Max(sines, hn::Set(d, 1e-12F))));
            x = hn::Max(hn::Min(x, one), hn::Neg(one));
            // cos m phi by Chebyshev's recurrence.
            V now = one;
            V next = x;
            for (std::size_t m = 0; m < modes; ++m) {
                for (std::size_t c = 0; c < 3; ++c) {
                    sum[c] = hn::MulAdd(now, lookup(row.values + (m * 3 + c) * row.stride, cell), sum[c]);
                }
                const V after = hn::MulSub(hn::Add(x, x), next, now);
                now = next;
                next = after;
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

// The ozone's tent along a ray that rises from s = `lowest` to `end`, up to 40 km, piece by piece between its kinks:
// heights are close to parabolas in s, for which three Gauss-Legendre nodes are exact.
V OzoneColumn(float r, float height_km, V along, V lowest, V end) {
    const D d;
    constexpr float nodes[3] = {0.112701665F, 0.5F, 0.887298335F};
    constexpr float weights[3] = {0.277777778F, 0.444444444F, 0.277777778F};
    const auto reaches = [&](float h) {
        const V rise = hn::Set(d, (h - height_km) * (2.0F * r + h - height_km));
        const V root = hn::Sqrt(hn::Max(hn::MulAdd(along, along, rise), hn::Zero(d)));
        return hn::Min(hn::Max(hn::Sub(root, along), lowest), end);
    };
    V column = hn::Zero(d);
    V from = reaches(10.0F);
    for (int piece = 0; piece < 2; ++piece) {
        const V to = reaches(piece == 0 ? 25.0F : 40.0F);
        const V length = hn::Sub(to, from);
        for (int k = 0; k < 3; ++k) {
            const V s = hn::MulAdd(length, hn::Set(d, nodes[k]), from);
            const V squared = hn::Mul(s, hn::MulAdd(hn::Set(d, 2.0F), along, s));
            const V root = hn::Sqrt(hn::Max(hn::Add(squared, hn::Set(d, r * r)), hn::Zero(d)));
            const V h = hn::Add(hn::Set(d, height_km), hn::Div(squared, hn::Add(root, hn::Set(d, r))));
            const V tent =
                hn::NegMulAdd(hn::Abs(hn::Sub(h, hn::Set(d, 25.0F))), hn::Set(d, 1.0F / 15.0F), hn::Set(d, 1.0F));
            column = hn::MulAdd(hn::Mul(length, hn::Set(d, weights[k])), hn::Max(tent, hn::Zero(d)), column);
        }
        from = to;
    }
    return column;
}

void ShellColumns(const ShellKernel& shell, float height_km, const float* mu, float (*out)[march_lanes]) {
    const D d;
    const float r = shell.radius_km + height_km;
    const V zero = hn::Zero(d);
    for (std::size_t lane = 0; lane < march_lanes; lane += hn::Lanes(d)) {
        const V m = hn::LoadU(d, mu + lane);
        const V along = hn::Mul(hn::Set(d, r), m);
        const float above = (shell.top_km - height_km) * (shell.top_km + height_km + 2.0F * shell.radius_km);
        const V end = hn::Sub(hn::Sqrt(hn::Max(hn::MulAdd(along, along, hn::Set(d, above)), zero)), along);
        const V lowest = hn::Max(hn::Neg(along), zero);
        V rayleigh = zero;
        V mie = zero;
        // Rays that go down first come up to their height once more.
        V ozone = OzoneColumn(r, height_km, along, lowest, end);
        if (!hn::AllTrue(d, hn::Eq(lowest, zero))) {
            ozone = hn::Add(ozone, OzoneColumn(r, height_km, along, lowest, hn::Add(lowest, lowest)));
        }
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
            }
        }
        hn::StoreU(rayleigh, d, &out[0][lane]);
        hn::StoreU(mie, d, &out[1][lane]);
        hn::StoreU(ozone, d, &out[2][lane]);
    }
}

void BlendRows(const float* low, const float* high, const float* low_weights, const float* high_weights,
               std::size_t stride, std::size_t terms, std::size_t count, float* to) {
    const D d;
    for (std::size_t j = 0; j < count; j += hn::Lanes(d)) {
        V sum = hn::Zero(d);
        for (std::size_t k = 0; k < terms; ++k) {
            sum = hn::MulAdd(hn::Set(d, low_weights[k]), hn::LoadU(d, low + k * stride + j), sum);
            sum = hn::MulAdd(hn::Set(d, high_weights[k]), hn::LoadU(d, high + k * stride + j), sum);
        }
        hn::StoreU(sum, d, to + j);
    }
}

} // namespace
} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sky {

HWY_EXPORT(MarchSingle);
HWY_EXPORT(MarchField);
HWY_EXPORT(ShellColumns);
HWY_EXPORT(BlendRows);

void march_single(const ShellKernel& shell, const MarchStep* steps, std::size_t count, const SunRow* sun,
                  const float* r0_mu_s, const float* nu, float (*out)[3][march_lanes]) {
    HWY_DYNAMIC_DISPATCH(MarchSingle)(shell, steps, count, sun, r0_mu_s, nu, out);
}
void march_field(const MarchStep* steps, std::size_t count, const FieldRow* field, std::size_t modes, float r0,
                 float mu, const float* mu_s, const float* nu, float (*out)[march_lanes]) {
    HWY_DYNAMIC_DISPATCH(MarchField)(steps, count, field, modes, r0, mu, mu_s, nu, out);
}
void shell_columns(const ShellKernel& shell, float height_km, const float* mu, float (*out)[march_lanes]) {
    HWY_DYNAMIC_DISPATCH(ShellColumns)(shell, height_km, mu, out);
}
void blend_rows(const float* low, const float* high, const float* low_weights, const float* high_weights,
                std::size_t stride, std::size_t terms, std::size_t count, float* to) {
    HWY_DYNAMIC_DISPATCH(BlendRows)(low, high, low_weights, high_weights, stride, terms, count, to);
}

} // namespace alpenglow::sky
#endif
