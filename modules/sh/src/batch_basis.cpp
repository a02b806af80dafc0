// Evaluation: the basis, and its dot product with coefficients without storing it.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_basis.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include "simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

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

struct SharedDot : Sums {
    const float* coefficients;
    explicit HWY_INLINE SharedDot(const float* c) : coefficients(c) {}
    template <int I>
    HWY_INLINE void put(V y) {
        sum[I % 4] = hn::MulAdd(y, hn::Set(d, coefficients[I]), sum[I % 4]);
    }
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

struct EvaluateShared {
    const float* coefficients;
    ConstBatch directions;
    Batch values;
    template <int Order>
    HWY_INLINE void run() const {
        for (std::size_t k = 0; k < directions.count; k += lanes()) {
            SharedDot sink(coefficients);
            basis<Order>(load(directions.row(0) + k), load(directions.row(1) + k), load(directions.row(2) + k), sink);
            store(sink.total(), values.data + k);
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
        for (std::size_t i = 0; i < coefficients; i += lanes()) {
            V sum = hn::Mul(hn::Set(d, weights[0]), load(probes + corners[0] * stride + i));
            for (int c = 1; c < 8; ++c) {
                sum = hn::MulAdd(hn::Set(d, weights[c]), load(probes + corners[c] * stride + i), sum);
            }
            store(sum, out + i);
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
