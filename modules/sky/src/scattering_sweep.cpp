#include "scattering_sweep.hpp"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scattering_sweep.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sky::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
template <class T>
using Tag = hn::CappedTag<T, 16>;
template <class T>
using Vec = hn::Vec<Tag<T>>;

template <class T>
struct Phases {
    Vec<T> rayleigh, mie, twice;
};
template <class T>
HWY_INLINE Phases<T> phases(const SweepShape<T>& shape, T a, const T* x, T b, const T* y) {
    const Tag<T> d;
    const auto one = hn::Set(d, T(1));
    const T g = shape.g;
    const T h = shape.twice;
    const T cs = T(0.1193662073189215) * (T(1) - g) * (T(1) + g) / (T(2) + g * g);
    const T hg = T(0.07957747154594767) * (T(1) - h) * (T(1) + h);
    auto nu = hn::MulAdd(hn::Set(d, a), hn::LoadU(d, x), hn::Mul(hn::Set(d, b), hn::LoadU(d, y)));
    nu = hn::Max(hn::Min(nu, one), hn::Neg(one));
    const auto square = hn::MulAdd(nu, nu, one);
    const auto away = hn::Sub(one, nu);
    const auto e = hn::MulAdd(hn::Set(d, T(2) * g), away, hn::Set(d, (T(1) - g) * (T(1) - g)));
    const auto f = hn::MulAdd(hn::Set(d, T(2) * h), away, hn::Set(d, (T(1) - h) * (T(1) - h)));
    return {hn::Mul(hn::Set(d, T(0.05968310365946075)), square),
            hn::Div(hn::Mul(hn::Set(d, cs), square), hn::Mul(e, hn::Sqrt(e))),
            hn::Div(hn::Set(d, hg), hn::Mul(f, hn::Sqrt(f)))};
}

template <class T>
HWY_INLINE void single(const SweepShape<T>& p, T mu, T s, const T* mu_s, const T* sine_s, const T* sun, T* rayleigh,
                       T* mie) {
    const Tag<T> d;
    for (std::size_t n = 0; n < p.azimuths; ++n) {
        for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
            const Phases<T> phase = phases(p, mu, mu_s + j, s * p.cosine[n][1], sine_s + j);
            for (std::size_t c = 0; c < 3; ++c) {
                const auto light = hn::LoadU(d, sun + c * p.count + j);
                hn::StoreU(hn::Mul(phase.rayleigh, light), d, rayleigh + (n * 3 + c) * p.row + j);
                hn::StoreU(hn::Mul(phase.mie, light), d, mie + (n * 3 + c) * p.row + j);
            }
        }
    }
}
template <class T>
HWY_INLINE void without(const SweepShape<T>& p, T mu, T s, const T* mu_s, const T* sine_s, const T* aureole,
                        const T* light, T* to) {
    const Tag<T> d;
    for (std::size_t n = 0; n < p.azimuths; ++n) {
        for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
            const Phases<T> phase = phases(p, mu, mu_s + j, s * p.cosine[n][1], sine_s + j);
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t at = (n * 3 + c) * p.row + j;
                hn::StoreU(hn::NegMulAdd(phase.mie, hn::LoadU(d, aureole + c * p.count + j), hn::LoadU(d, light + at)),
                           d, to + at);
            }
        }
    }
}
template <class T>
HWY_INLINE void twice(const SweepShape<T>& p, T mu, T s, const T* mu_s, const T* sine_s, const T* aureole, T* mie) {
    const Tag<T> d;
    for (std::size_t n = 0; n < p.azimuths; ++n) {
        for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
            const Phases<T> phase = phases(p, mu, mu_s + j, s * p.cosine[n][1], sine_s + j);
            const auto peak = hn::NegMulAdd(hn::Set(d, p.forward), phase.mie, phase.twice);
            for (std::size_t c = 0; c < 3; ++c) {
                T* to = mie + (n * 3 + c) * p.row + j;
                hn::StoreU(hn::MulAdd(peak, hn::LoadU(d, aureole + c * p.count + j), hn::LoadU(d, to)), d, to);
            }
        }
    }
}

template <class T>
HWY_INLINE void expand(const SweepShape<T>& p, const T* y, const T* of_rayleigh, const T* of_mie, T* rayleigh, T* mie) {
    const Tag<T> d;
    const std::size_t apart = 3 * p.count;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
            Vec<T> mode[most_field_bands];
            Vec<T> few[3];
            const T* from = of_mie + c * p.count + j;
            const T* also = of_rayleigh + c * p.count + j;
            std::size_t f = 0;
            for (std::size_t m = 0; m < p.bands; ++m) {
                if (m < 3) {
                    const std::size_t second = f + 2 - m;
                    few[m] = hn::Mul(hn::Set(d, y[second]), hn::LoadU(d, also + second * apart));
                    if (m == 0) {
                        few[0] = hn::MulAdd(hn::Set(d, y[0]), hn::LoadU(d, also), few[0]);
                    }
                }
                auto sum = hn::Zero(d);
                for (std::size_t l = m; l < p.bands; ++l, ++f) {
                    sum = hn::MulAdd(hn::Set(d, y[f]), hn::LoadU(d, from + f * apart), sum);
                }
                mode[m] = sum;
            }
            // Mirrored azimuths differ by the sign of odd m.
            for (std::size_t n = 0; n < p.azimuths / 2; ++n) {
                const T* cosine = p.cosine[n];
                auto even = mode[0];
                auto odd = hn::Mul(hn::Set(d, cosine[1]), mode[1]);
                for (std::size_t m = 2; m + 1 < p.bands; m += 2) {
                    even = hn::MulAdd(hn::Set(d, cosine[m]), mode[m], even);
                    odd = hn::MulAdd(hn::Set(d, cosine[m + 1]), mode[m + 1], odd);
                }
                if (p.bands % 2 == 1) {
                    even = hn::MulAdd(hn::Set(d, cosine[p.bands - 1]), mode[p.bands - 1], even);
                }
                const std::size_t at = (n * 3 + c) * p.row + j;
                const std::size_t mirror = ((p.azimuths - 1 - n) * 3 + c) * p.row + j;
                hn::StoreU(hn::Add(even, odd), d, mie + at);
                hn::StoreU(hn::Sub(even, odd), d, mie + mirror);
                even = hn::MulAdd(hn::Set(d, cosine[2]), few[2], few[0]);
                odd = hn::Mul(hn::Set(d, cosine[1]), few[1]);
                hn::StoreU(hn::Add(even, odd), d, rayleigh + at);
                hn::StoreU(hn::Sub(even, odd), d, rayleigh + mirror);
            }
        }
    }
}

template <class T>
HWY_INLINE void carry(const SweepShape<T>& p, const CarryWeights<T>& k, double shift_per_cosine, const T* rayleigh_near,
                      const T* mie_near, const T* rayleigh_far, const T* mie_far, T* light, T* scratch) {
    const Tag<T> d;
    T* far = scratch + row_pad;
    for (std::size_t n = 0; n < p.azimuths; ++n) {
        const double x = shift_per_cosine * static_cast<double>(p.cosine[n][1]);
        const double whole = std::floor(x);
        const double u = x - whole;
        const auto w0 = hn::Set(d, static_cast<T>(-u * (u - 1.0) * (u - 2.0) / 6.0));
        const auto w1 = hn::Set(d, static_cast<T>((u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0));
        const auto w2 = hn::Set(d, static_cast<T>(-(u + 1.0) * u * (u - 2.0) / 2.0));
        const auto w3 = hn::Set(d, static_cast<T>((u + 1.0) * u * (u - 1.0) / 6.0));
        const T* from = far + static_cast<std::ptrdiff_t>(whole) - 1;
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = (n * 3 + c) * p.row;
            for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
                auto sum = hn::Mul(hn::Set(d, k.left[c]), hn::LoadU(d, light + at + j));
                sum = hn::MulAdd(hn::Set(d, k.rayleigh_far[c]), hn::LoadU(d, rayleigh_far + at + j), sum);
                sum = hn::MulAdd(hn::Set(d, k.mie_far[c]), hn::LoadU(d, mie_far + at + j), sum);
                hn::StoreU(sum, d, far + j);
            }
            // Straight on before the first angle; nothing after the last.
            const T slope = far[0] - far[1];
            for (std::size_t i = 1; i <= row_pad; ++i) {
                far[-static_cast<std::ptrdiff_t>(i)] = far[0] + slope * static_cast<T>(i);
            }
            for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
                auto sum = hn::Mul(w0, hn::LoadU(d, from + j));
                sum = hn::MulAdd(w1, hn::LoadU(d, from + j + 1), sum);
                sum = hn::MulAdd(w2, hn::LoadU(d, from + j + 2), sum);
                sum = hn::Max(hn::MulAdd(w3, hn::LoadU(d, from + j + 3), sum), hn::Zero(d));
                sum = hn::MulAdd(hn::Set(d, k.rayleigh_near[c]), hn::LoadU(d, rayleigh_near + at + j), sum);
                sum = hn::MulAdd(hn::Set(d, k.mie_near[c]), hn::LoadU(d, mie_near + at + j), sum);
                hn::StoreU(sum, d, light + at + j);
            }
        }
    }
}

template <class T>
HWY_INLINE void gather(const SweepShape<T>& p, const T* y, const T* light, T* field, T ground_weight, T* ground) {
    const Tag<T> d;
    const std::size_t apart = 3 * p.count;
    const std::size_t half = p.azimuths / 2;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t j = 0; j < p.count; j += hn::Lanes(d)) {
            // Cosines of mirrored azimuths differ by the sign of odd m alone.
            Vec<T> even[most_azimuths];
            Vec<T> odd[most_azimuths];
            const T* from = light + c * p.row + j;
            for (std::size_t n = 0; n < half; ++n) {
                const auto a = hn::LoadU(d, from + n * 3 * p.row);
                const auto b = hn::LoadU(d, from + (p.azimuths - 1 - n) * 3 * p.row);
                even[n] = hn::Add(a, b);
                odd[n] = hn::Sub(a, b);
            }
            T* to = field + c * p.count + j;
            std::size_t f = 0;
            for (std::size_t m = 0; m < p.bands; ++m) {
                const Vec<T>* sums = m % 2 == 0 ? even : odd;
                auto mode = hn::Mul(hn::Set(d, p.cosine[0][m]), sums[0]);
                for (std::size_t n = 1; n < half; ++n) {
                    mode = hn::MulAdd(hn::Set(d, p.cosine[n][m]), sums[n], mode);
                }
                if (m == 0 && ground_weight != T(0)) {
                    T* g = ground + c * p.count + j;
                    hn::StoreU(hn::MulAdd(hn::Set(d, ground_weight), mode, hn::LoadU(d, g)), d, g);
                }
                for (std::size_t l = m; l < p.bands; ++l, ++f) {
                    hn::StoreU(hn::MulAdd(hn::Set(d, y[f]), mode, hn::LoadU(d, to + f * apart)), d, to + f * apart);
                }
            }
        }
    }
}

#define ALPENGLOW_SWEEP(T, Name)                                                                                       \
    void Single##Name(const SweepShape<T>& p, T mu, T s, const T* x, const T* y, const T* sun, T* a, T* b) {           \
        single(p, mu, s, x, y, sun, a, b);                                                                             \
    }                                                                                                                  \
    void Without##Name(const SweepShape<T>& p, T mu, T s, const T* x, const T* y, const T* e, const T* l, T* to) {     \
        without(p, mu, s, x, y, e, l, to);                                                                             \
    }                                                                                                                  \
    void Twice##Name(const SweepShape<T>& p, T mu, T s, const T* x, const T* y, const T* e, T* to) {                   \
        twice(p, mu, s, x, y, e, to);                                                                                  \
    }                                                                                                                  \
    void Expand##Name(const SweepShape<T>& p, const T* y, const T* r, const T* m, T* a, T* b) {                        \
        expand(p, y, r, m, a, b);                                                                                      \
    }                                                                                                                  \
    void Carry##Name(const SweepShape<T>& p, const CarryWeights<T>& k, double by, const T* a, const T* b, const T* c,  \
                     const T* e, T* light, T* scratch) {                                                               \
        carry(p, k, by, a, b, c, e, light, scratch);                                                                   \
    }                                                                                                                  \
    void Gather##Name(const SweepShape<T>& p, const T* y, const T* light, T* field, T weight, T* ground) {             \
        gather(p, y, light, field, weight, ground);                                                                    \
    }
ALPENGLOW_SWEEP(float, Float)
ALPENGLOW_SWEEP(double, Double)
#undef ALPENGLOW_SWEEP

} // namespace
} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sky {

#define ALPENGLOW_SWEEP(T, Name)                                                                                       \
    HWY_EXPORT(Single##Name);                                                                                          \
    HWY_EXPORT(Without##Name);                                                                                         \
    HWY_EXPORT(Twice##Name);                                                                                           \
    HWY_EXPORT(Expand##Name);                                                                                          \
    HWY_EXPORT(Carry##Name);                                                                                           \
    HWY_EXPORT(Gather##Name);                                                                                          \
    template <>                                                                                                        \
    void single_source(const SweepShape<T>& p, T mu, T s, const T* x, const T* y, const T* sun, T* a, T* b) {          \
        HWY_DYNAMIC_DISPATCH(Single##Name)(p, mu, s, x, y, sun, a, b);                                                 \
    }                                                                                                                  \
    template <>                                                                                                        \
    void without_aureole(const SweepShape<T>& p, T mu, T s, const T* x, const T* y, const T* e, const T* l, T* to) {   \
        HWY_DYNAMIC_DISPATCH(Without##Name)(p, mu, s, x, y, e, l, to);                                                 \
    }                                                                                                                  \
    template <>                                                                                                        \
    void aureole_source(const SweepShape<T>& p, T mu, T s, const T* x, const T* y, const T* e, T* to) {                \
        HWY_DYNAMIC_DISPATCH(Twice##Name)(p, mu, s, x, y, e, to);                                                      \
    }                                                                                                                  \
    template <>                                                                                                        \
    void field_source(const SweepShape<T>& p, const T* y, const T* r, const T* m, T* a, T* b) {                        \
        HWY_DYNAMIC_DISPATCH(Expand##Name)(p, y, r, m, a, b);                                                          \
    }                                                                                                                  \
    template <>                                                                                                        \
    void carry_light(const SweepShape<T>& p, const CarryWeights<T>& k, double by, const T* a, const T* b, const T* c,  \
                     const T* e, T* light, T* scratch) {                                                               \
        HWY_DYNAMIC_DISPATCH(Carry##Name)(p, k, by, a, b, c, e, light, scratch);                                       \
    }                                                                                                                  \
    template <>                                                                                                        \
    void gather_light(const SweepShape<T>& p, const T* y, const T* light, T* field, T weight, T* ground) {             \
        HWY_DYNAMIC_DISPATCH(Gather##Name)(p, y, light, field, weight, ground);                                        \
    }
ALPENGLOW_SWEEP(float, Float)
ALPENGLOW_SWEEP(double, Double)
#undef ALPENGLOW_SWEEP

} // namespace alpenglow::sky
#endif
