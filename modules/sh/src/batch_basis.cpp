// Evaluation: the basis, and its dot product with coefficients without storing it.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_basis.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include "simd-inl.h"

#include "folded.hpp"

#include <hwy/cache_control.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

using detail::Folded;

struct EvaluateBasis {
    ConstBatch directions;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        for (std::size_t k = 0; k < directions.count; k += lanes()) {
            StoreSink sink{out.data + k, out.stride};
            basis<Order>(load(directions.row(0) + k), load(directions.row(1) + k), load(directions.row(2) + k), sink);
        }
    }
};

// Four partial sums, so that additions do not wait for each other.
struct Sums {
    V sum[4];
    HWY_INLINE Sums() {
        for (V& s : sum) {
            s = hn::Zero(d);
        }
    }
    HWY_INLINE V total() const { return hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])); }
};

struct OwnDot : Sums {
    const float* coefficients;
    std::size_t stride;
    HWY_INLINE OwnDot(const float* c, std::size_t s) : coefficients(c), stride(s) {}
    template <int I>
    HWY_INLINE void put(V y) {
        sum[I % 4] = hn::MulAdd(y, load(coefficients + I * stride), sum[I % 4]);
    }
};

template <int Degree>
HWY_INLINE V horner(const float* c, V z) {
    V sum = hn::Set(d, c[Degree]);
    HWY_UNROLL(16)
    for (int k = Degree - 1; k >= 0; --k) {
        sum = hn::MulAdd(sum, z, hn::Set(d, c[k]));
    }
    return sum;
}

template <int Order, int M_>
HWY_INLINE V folded_sum(const Folded& f, V x, V y, V z, V re, V im, V sum) {
    if constexpr (M_ < Order) {
        sum = hn::MulAdd(re, horner<Order - 1 - M_>(f.cosine[M_], z), sum);
        sum = hn::MulAdd(im, horner<Order - 1 - M_>(f.sine[M_], z), sum);
        if constexpr (M_ + 1 < Order) {
            const V next_re = hn::MulSub(x, re, hn::Mul(y, im));
            const V next_im = hn::MulAdd(x, im, hn::Mul(y, re));
            return folded_sum<Order, M_ + 1>(f, x, y, z, next_re, next_im, sum);
        }
    }
    return sum;
}

struct EvaluateShared {
    const float* coefficients;
    ConstBatch directions;
    Batch values;
    template <int Order>
    HWY_INLINE void run() const {
        const Folded folded(Order, coefficients);
        for (std::size_t k = 0; k < directions.count; k += lanes()) {
            const V x = hn::Neg(load(directions.row(0) + k)), y = hn::Neg(load(directions.row(1) + k));
            const V z = load(directions.row(2) + k);
            const V zonal = horner<Order - 1>(folded.cosine[0], z);
            store(folded_sum<Order, 1>(folded, x, y, z, x, y, zonal), values.data + k);
        }
    }
};

struct EvaluateOwn {
    ConstBatch coefficients, directions;
    Batch values;
    template <int Order>
    HWY_INLINE void run() const {
        for (std::size_t k = 0; k < directions.count; k += lanes()) {
            OwnDot sink(coefficients.data + k, coefficients.stride);
            basis<Order>(load(directions.row(0) + k), load(directions.row(1) + k), load(directions.row(2) + k), sink);
            store(sink.total(), values.data + k);
        }
    }
};

struct ScaleBands {
    const float* factors;
    ConstBatch in;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        for (int l = 0; l < Order; ++l) {
            const V factor = hn::Set(d, factors[l]);
            for (std::size_t row = static_cast<std::size_t>(l * l); row < static_cast<std::size_t>((l + 1) * (l + 1));
                 ++row) {
                for (std::size_t k = 0; k < in.count; k += lanes()) {
                    store(hn::Mul(factor, load(in.row(row) + k)), out.row(row) + k);
                }
            }
        }
    }
};

void evaluate_basis_kernel(int order, ConstBatch directions, Batch out) {
    for_order(order, EvaluateBasis{directions, out});
}
void evaluate_shared_kernel(int order, const float* coefficients, ConstBatch directions, Batch values) {
    for_order(order, EvaluateShared{coefficients, directions, values});
}
void evaluate_own_kernel(int order, ConstBatch coefficients, ConstBatch directions, Batch values) {
    for_order(order, EvaluateOwn{coefficients, directions, values});
}
void scale_bands_kernel(int order, const float* factors, ConstBatch in, Batch out) {
    for_order(order, ScaleBands{factors, in, out});
}

void blend_kernel(std::size_t coefficients, const float* probes, std::size_t stride, const std::uint32_t* corners,
                  const float* weights, std::size_t receivers, float* out) {
    for (std::size_t r = 0; r < receivers; ++r, corners += 8, weights += 8, out += stride) {
        // Corners of the receivers to come: the grid is larger than the nearest caches.
        if (r + 4 < receivers) {
            for (int c = 32; c < 40; ++c) {
                hwy::Prefetch(probes + corners[c] * stride);
            }
        }
        std::size_t i = 0;
        for (; i + lanes() < coefficients; i += 2 * lanes()) {
            V a = hn::Zero(d), b = a;
            HWY_UNROLL(8)
            for (int c = 0; c < 8; ++c) {
                const float* probe = probes + corners[c] * stride + i;
                const V w = hn::Set(d, weights[c]);
                a = hn::MulAdd(w, load(probe), a);
                b = hn::MulAdd(w, load(probe + lanes()), b);
            }
            store(a, out + i);
            store(b, out + i + lanes());
        }
        for (; i < coefficients; i += lanes()) {
            V a = hn::Zero(d);
            for (int c = 0; c < 8; ++c) {
                a = hn::MulAdd(hn::Set(d, weights[c]), load(probes + corners[c] * stride + i), a);
            }
            store(a, out + i);
        }
    }
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(evaluate_basis_kernel);
HWY_EXPORT(evaluate_shared_kernel);
HWY_EXPORT(evaluate_own_kernel);
HWY_EXPORT(scale_bands_kernel);
HWY_EXPORT(blend_kernel);

void evaluate_basis(int order, ConstBatch directions, Batch out) {
    assert(order >= 1 && order <= max_order && out.count == directions.count);
    HWY_DYNAMIC_DISPATCH(evaluate_basis_kernel)(order, directions, out);
}

void evaluate(int order, std::span<const float> coefficients, ConstBatch directions, Batch values) {
    assert(order >= 1 && order <= max_order && values.count == directions.count);
    assert(coefficients.size() >= static_cast<std::size_t>(coefficient_count(order)));
    HWY_DYNAMIC_DISPATCH(evaluate_shared_kernel)(order, coefficients.data(), directions, values);
}

void evaluate(int order, ConstBatch coefficients, ConstBatch directions, Batch values) {
    assert(order >= 1 && order <= max_order && values.count == directions.count);
    assert(coefficients.count == directions.count);
    HWY_DYNAMIC_DISPATCH(evaluate_own_kernel)(order, coefficients, directions, values);
}

void scale_bands(int order, std::span<const float> factors, ConstBatch in, Batch out) {
    assert(order >= 1 && order <= max_order && in.count == out.count);
    assert(factors.size() >= static_cast<std::size_t>(order));
    HWY_DYNAMIC_DISPATCH(scale_bands_kernel)(order, factors.data(), in, out);
}

void blend(std::size_t coefficients, const float* probes, std::size_t probe_stride,
           std::span<const std::uint32_t> corners, std::span<const float> weights, float* out) {
    assert(corners.size() == weights.size() && corners.size() % 8 == 0 && padded(coefficients) <= probe_stride);
    HWY_DYNAMIC_DISPATCH(blend_kernel)
    (coefficients, probes, probe_stride, corners.data(), weights.data(), corners.size() / 8, out);
}

} // namespace alpenglow::sh
#endif
