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

// Own coefficients: those of each m are summed over l against Q_l^m first, so that the azimuth is multiplied in once.
template <int M_, int Order, int L>
HWY_INLINE void own_column(const float* f, std::size_t stride, V z, V z2, V previous, V before, V& cosine, V& sine) {
    if constexpr (L < Order) {
        const V q = legendre<L, M_>(z, z2, previous, before);
        const V a = load(f + index(L, M_) * stride);
        cosine = L == M_ ? hn::Mul(q, a) : hn::MulAdd(q, a, cosine);
        if constexpr (M_ > 0) {
            const V b = load(f + index(L, -M_) * stride);
            sine = L == M_ ? hn::Mul(q, b) : hn::MulAdd(q, b, sine);
        }
        own_column<M_, Order, L + 1>(f, stride, z, z2, q, previous, cosine, sine);
    }
}

// Two partial sums, so that additions do not wait for each other.
template <int M_, int Order>
HWY_INLINE V own_columns(const float* f, std::size_t stride, V x, V y, V z, V z2, V re, V im, V even, V odd) {
    if constexpr (M_ < Order) {
        V cosine = even, sine = even;
        own_column<M_, Order, M_>(f, stride, z, z2, z, z, cosine, sine);
        V& sum = M_ % 2 == 0 ? even : odd;
        sum = hn::MulAdd(re, cosine, hn::MulAdd(im, sine, sum));
        const V next_re = hn::MulSub(x, re, hn::Mul(y, im));
        const V next_im = hn::MulAdd(x, im, hn::Mul(y, re));
        return own_columns<M_ + 1, Order>(f, stride, x, y, z, z2, next_re, next_im, even, odd);
    }
    return hn::Add(even, odd);
}

// Order 3 with each monomial taken once.
HWY_INLINE V own_quadratic(const float* f, std::size_t stride, V x, V y, V z) {
    constexpr double k0 = detail::basis_tables.seed[0], k1 = detail::basis_tables.poly[1][0][0];
    constexpr double k2 = 2.0 * detail::basis_tables.seed[2];
    constexpr double c20 = detail::basis_tables.poly[2][0][0], k20 = detail::basis_tables.poly[2][0][1];
    const auto row = [&](std::size_t i) HWY_ATTR { return load(f + i * stride); };
    const V half = hn::Mul(constant(0.5), row(8));
    const V linear = hn::NegMulAdd(x, row(3), hn::NegMulAdd(y, row(1), hn::Mul(z, row(2))));
    const V by_x = hn::MulAdd(y, row(4), hn::NegMulAdd(z, row(7), hn::Mul(x, half)));
    const V by_y = hn::MulAdd(z, row(5), hn::Mul(y, half));
    const V quadratic = hn::NegMulAdd(y, by_y, hn::Mul(x, by_x));
    const V zonal = hn::MulAdd(hn::Mul(constant(k20), z), z, constant(c20));
    return hn::MulAdd(constant(k2), quadratic,
                      hn::MulAdd(constant(k1), linear, hn::MulAdd(zonal, row(6), hn::Mul(constant(k0), row(0)))));
}

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
            const float* f = coefficients.data + k;
            const std::size_t stride = coefficients.stride;
            V x = load(directions.row(0) + k), y = load(directions.row(1) + k);
            const V z = load(directions.row(2) + k);
            V value;
            if constexpr (Order == 3) {
                value = own_quadratic(f, stride, x, y, z);
            } else {
                const V z2 = hn::Mul(z, z), zero = hn::Zero(d);
                V zonal = zero, unused = zero;
                own_column<0, Order, 0>(f, stride, z, z2, z, z, zonal, unused);
                x = hn::Neg(x);
                y = hn::Neg(y);
                value = own_columns<1, Order>(f, stride, x, y, z, z2, x, y, zonal, zero);
            }
            store(value, values.data + k);
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
