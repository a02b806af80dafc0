#include "fit_simd.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sky::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

HWY_INLINE const float* weights_of(const FitRows& in, const float* w, std::size_t degree) {
    return in.position != nullptr ? w : w + in.first[degree];
}

// N vectors of functions. The first loop sums rows of one degree, the others over all degrees.
template <std::size_t N>
HWY_INLINE void sum_rows(const FitRows& in, std::size_t offset, const float* HWY_RESTRICT w, float* HWY_RESTRICT sums) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = 0; i < in.degrees; ++i) {
        V acc[N];
        for (std::size_t n = 0; n < N; ++n) {
            acc[n] = hn::Zero(d);
        }
        const float* weight_at = weights_of(in, w, i);
        for (std::int32_t r = in.first[i]; r < in.first[i + 1]; ++r) {
            const V weight = hn::Set(d, *weight_at++);
            const float* row = in.rows + static_cast<std::size_t>(r) * fit_stride + offset;
            for (std::size_t n = 0; n < N; ++n) {
                acc[n] = hn::MulAdd(weight, hn::Load(d, row + n * lanes), acc[n]);
            }
        }
        for (std::size_t n = 0; n < N; ++n) {
            hn::Store(acc[n], d, sums + i * fit_stride + offset + n * lanes);
        }
    }
}

// U rows at a time, each with accumulators of its own: one sum alone would wait for its last addition.
template <std::size_t N, std::size_t U, class W>
HWY_INLINE void sum_all(const float* HWY_RESTRICT rows, const W& weight_of, std::size_t count,
                        float* HWY_RESTRICT out) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    V all[U][N];
    for (std::size_t u = 0; u < U; ++u) {
        for (std::size_t n = 0; n < N; ++n) {
            all[u][n] = hn::Zero(d);
        }
    }
    std::size_t r = 0;
    for (; r + U <= count; r += U) {
        for (std::size_t u = 0; u < U; ++u) {
            const V weight = hn::Set(d, weight_of(r + u));
            const float* row = rows + (r + u) * fit_stride;
            for (std::size_t n = 0; n < N; ++n) {
                all[u][n] = hn::MulAdd(weight, hn::Load(d, row + n * lanes), all[u][n]);
            }
        }
    }
    for (; r < count; ++r) {
        const V weight = hn::Set(d, weight_of(r));
        const float* row = rows + r * fit_stride;
        for (std::size_t n = 0; n < N; ++n) {
            all[0][n] = hn::MulAdd(weight, hn::Load(d, row + n * lanes), all[0][n]);
        }
    }
    for (std::size_t n = 0; n < N; ++n) {
        V sum = all[0][n];
        for (std::size_t u = 1; u < U; ++u) {
            sum = hn::Add(sum, all[u][n]);
        }
        hn::StoreU(sum, d, out + n * lanes);
    }
}

// Calls f(count, offset) with as many vectors as cover the functions, at most six at a time.
template <class F>
HWY_INLINE void in_groups(std::size_t functions, const F& f) {
    const std::size_t lanes = hn::Lanes(D());
    std::size_t vectors = (functions + lanes - 1) / lanes;
    std::size_t offset = 0;
    while (vectors > 0) {
        const std::size_t now = vectors < 6 ? vectors : 6;
        switch (now) {
        case 1:
            f(std::integral_constant<std::size_t, 1>(), offset);
            break;
        case 2:
            f(std::integral_constant<std::size_t, 2>(), offset);
            break;
        case 3:
            f(std::integral_constant<std::size_t, 3>(), offset);
            break;
        case 4:
            f(std::integral_constant<std::size_t, 4>(), offset);
            break;
        case 5:
            f(std::integral_constant<std::size_t, 5>(), offset);
            break;
        default:
            f(std::integral_constant<std::size_t, 6>(), offset);
            break;
        }
        vectors -= now;
        offset += now * lanes;
    }
}

void SumRows(const FitRows& in, const float* w, std::size_t functions, float* sums) {
    in_groups(functions,
              [&](auto n, std::size_t offset) HWY_ATTR { sum_rows<decltype(n)::value>(in, offset, w, sums); });
}

HWY_INLINE void expand(const float* HWY_RESTRICT functions, float k, float cos_a, float sin_a, int bands,
                       float* HWY_RESTRICT out) {
    float c[8];
    float s[8];
    c[0] = k;
    s[0] = 0.0F;
    for (int m = 1; m < bands; ++m) {
        c[m] = c[m - 1] * cos_a - s[m - 1] * sin_a;
        s[m] = s[m - 1] * cos_a + c[m - 1] * sin_a;
    }
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
    // Four floats at a time, ascending, so that the fourth is overwritten by the next; the very last stands alone.
    const hn::CappedTag<float, 4> d;
    for (int l = 0; l < bands; ++l) {
        const float* in = functions + 3 * (l * (l + 1) / 2);
        float* at = out + 3 * (l * l);
        for (int m = l; m > 0; --m, at += 3) {
            hn::StoreU(hn::Mul(hn::LoadU(d, in + 3 * m), hn::Set(d, s[m])), d, at);
        }
        const int vectors = l + 1 < bands ? l + 1 : l;
        for (int m = 0; m < vectors; ++m, at += 3) {
            hn::StoreU(hn::Mul(hn::LoadU(d, in + 3 * m), hn::Set(d, c[m])), d, at);
        }
        for (int m = vectors; m <= l; ++m, at += 3) {
            at[0] = in[3 * m] * c[m];
            at[1] = in[3 * m + 1] * c[m];
            at[2] = in[3 * m + 2] * c[m];
        }
    }
#else
    for (int l = 0; l < bands; ++l) {
        const float* in = functions + 3 * (l * (l + 1) / 2);
        for (int m = -l; m <= l; ++m) {
            const int a = m < 0 ? -m : m;
            const float turn = m < 0 ? s[a] : c[a];
            for (int q = 0; q < 3; ++q) {
                out[3 * (l * (l + 1) + m) + q] = in[3 * a + q] * turn;
            }
        }
    }
#endif
}

constexpr std::size_t max_degrees = 64;

HWY_INLINE std::size_t functions_of(int bands) {
    return static_cast<std::size_t>(3 * bands * (bands + 1) / 2);
}

constexpr std::size_t series_terms = 16;

// Few degrees at once: a count that the compiler knows stays in registers.
HWY_INLINE void chebyshev_of(float x, std::size_t degrees, float* t) {
    if (HWY_LIKELY(degrees <= series_terms)) {
        chebyshev(x, series_terms, t);
    } else {
        chebyshev(x, degrees, t);
    }
}

HWY_INLINE float factor_of(const FitSun& sun, const float* t) {
    if (sun.factor_series == nullptr) {
        return sun.factor;
    }
    const hn::CappedTag<float, series_terms> d;
    auto sum = hn::Zero(d);
    for (std::size_t k = 0; k < series_terms; k += hn::Lanes(d)) {
        sum = hn::MulAdd(hn::LoadU(d, sun.factor_series + k), hn::LoadU(d, t + k), sum);
    }
    return hn::GetLane(hn::SumOfLanes(d, sum));
}

void FromSums(const float* sums, std::size_t degrees, const FitSun& sun) {
    float t[max_degrees + 2];
    chebyshev_of(sun.x, degrees, t);
    HWY_ALIGN float out[fit_stride];
    in_groups(functions_of(sun.bands), [&](auto n, std::size_t offset) HWY_ATTR {
        constexpr std::size_t vectors = decltype(n)::value;
        sum_all<vectors, (vectors <= 3 ? 4 : 2)>(
            sums + offset, [&](std::size_t i) HWY_ATTR { return t[i]; }, degrees, out + offset);
    });
    expand(out, factor_of(sun, t), sun.cos_a, sun.sin_a, sun.bands, sun.out);
}

void FromRows(const FitRows& in, const float* w, const FitSun& sun) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    float t[max_degrees + 2];
    chebyshev_of(sun.x, in.degrees, t);
    // A table of products of whole, aligned vectors: rows read from it at once what was just stored.
    HWY_ALIGN float weights[max_degrees * fit_weights];
    std::int16_t own[max_fit_rows];
    const std::int16_t* position = in.position;
    if (position != nullptr) {
        for (std::size_t i = 0; i < in.degrees; ++i) {
            const V degree = hn::Set(d, t[i]);
            const auto rows = static_cast<std::size_t>(in.first[i + 1] - in.first[i]);
            for (std::size_t k = 0; k < rows; k += lanes) {
                hn::Store(hn::Mul(degree, hn::Load(d, w + k)), d, weights + i * fit_weights + k);
            }
        }
    } else {
        for (std::size_t i = 0; i < in.degrees; ++i) {
            for (std::int32_t r = in.first[i]; r < in.first[i + 1]; ++r) {
                weights[r] = t[i] * w[r];
                own[r] = static_cast<std::int16_t>(r);
            }
        }
        position = own;
    }
    const auto count = static_cast<std::size_t>(in.first[in.degrees]);
    HWY_ALIGN float out[fit_stride];
    in_groups(functions_of(sun.bands), [&](auto n, std::size_t offset) HWY_ATTR {
        constexpr std::size_t vectors = decltype(n)::value;
        sum_all<vectors, (vectors <= 3 ? 4 : 2)>(
            in.rows + offset, [&](std::size_t r) HWY_ATTR { return weights[position[r]]; }, count, out + offset);
    });
    expand(out, sun.factor, sun.cos_a, sun.sin_a, sun.bands, sun.out);
}

} // namespace
} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sky {

HWY_EXPORT(SumRows);
HWY_EXPORT(FromSums);
HWY_EXPORT(FromRows);

void fit_sum_rows(const FitRows& rows, const float* w, std::size_t functions, float* sums) {
    HWY_DYNAMIC_DISPATCH(SumRows)(rows, w, functions, sums);
}
void fit_from_sums(const float* sums, std::size_t degrees, const FitSun& sun) {
    HWY_DYNAMIC_DISPATCH(FromSums)(sums, degrees, sun);
}
void fit_from_rows(const FitRows& rows, const float* w, const FitSun& sun) {
    HWY_DYNAMIC_DISPATCH(FromRows)(rows, w, sun);
}

} // namespace alpenglow::sky
#endif
