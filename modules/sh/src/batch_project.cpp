// Projection of weighted samples.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_project.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include "simd-inl.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

constexpr std::size_t tile = 8; // vectors of samples whose basis is kept at a time

// The basis of one vector of samples, into its place in the rows of the tile.
struct TileSink {
    float* out;
    std::size_t stride;
    template <int I>
    HWY_INLINE void put(V v) const {
        hn::Store(v, d, out + I * stride);
    }
};

template <std::size_t Channels>
struct Project {
    ConstBatch directions, values;
    const float* weights;
    double* out;

    template <int Order>
    HWY_INLINE void run() const {
        constexpr std::size_t n = Order * Order;
        constexpr std::size_t width = tile * hn::MaxLanes(d); // a row of the tile
        HWY_ALIGN float basis_rows[n * width];
        HWY_ALIGN float weighted[Channels * width];
        HWY_ALIGN float partial[n * Channels * hn::MaxLanes(d)];
        const std::size_t step = tile * lanes();
        std::fill_n(out, n * Channels, 0.0);
        std::fill_n(partial, n * Channels * hn::MaxLanes(d), 0.0F);
        int tiles = 0;
        for (std::size_t first = 0; first < directions.count; first += step) {
            const std::size_t last = std::min(directions.count, first + step);
            for (std::size_t k = first; k < last; k += lanes()) {
                const std::size_t at = k - first;
                TileSink sink{basis_rows + at, width};
                basis<Order>(load(directions.row(0) + k), load(directions.row(1) + k), load(directions.row(2) + k),
                             sink);
                // Past the end weights are zero, and so are values, lest zero meet NaN.
                V w, v[Channels];
                if (k + lanes() <= last) {
                    w = load(weights + k);
                    for (std::size_t c = 0; c < Channels; ++c) {
                        v[c] = load(values.row(c) + k);
                    }
                } else {
                    const M inside = hn::FirstN(d, last - k);
                    HWY_ALIGN float padded_weights[16] = {};
                    std::copy_n(weights + k, last - k, padded_weights);
                    w = hn::Load(d, padded_weights);
                    for (std::size_t c = 0; c < Channels; ++c) {
                        v[c] = hn::IfThenElseZero(inside, load(values.row(c) + k));
                    }
                    for (std::size_t i = 0; i < n; ++i) {
                        float* row = basis_rows + i * width + at;
                        hn::Store(hn::IfThenElseZero(inside, hn::Load(d, row)), d, row);
                    }
                }
                for (std::size_t c = 0; c < Channels; ++c) {
                    hn::Store(hn::Mul(w, v[c]), d, weighted + c * width + at);
                }
            }
            for (std::size_t i = 0; i < n; ++i) {
                V sum[Channels];
                for (std::size_t c = 0; c < Channels; ++c) {
                    sum[c] = hn::Load(d, partial + (Channels * i + c) * lanes());
                }
                for (std::size_t at = 0; at < last - first; at += lanes()) {
                    const V y = hn::Load(d, basis_rows + i * width + at);
                    HWY_UNROLL(4)
                    for (std::size_t c = 0; c < Channels; ++c) {
                        sum[c] = hn::MulAdd(y, hn::Load(d, weighted + c * width + at), sum[c]);
                    }
                }
                for (std::size_t c = 0; c < Channels; ++c) {
                    hn::Store(sum[c], d, partial + (Channels * i + c) * lanes());
                }
            }
            // Float sums of 32 terms, then double.
            if (++tiles == 4 || last == directions.count) {
                tiles = 0;
                for (std::size_t i = 0; i < n; ++i) {
                    for (std::size_t c = 0; c < Channels; ++c) {
                        float* p = partial + (Channels * i + c) * lanes();
                        out[c * n + i] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, hn::Load(d, p))));
                        hn::Store(hn::Zero(d), d, p);
                    }
                }
            }
        }
    }
};

void project_kernel(int order, ConstBatch directions, ConstBatch values, int channels, const float* weights,
                    double* out) {
    // One channel, or three at a time where there are.
    const std::size_t n = static_cast<std::size_t>(coefficient_count(order));
    int c = 0;
    for (; c + 3 <= channels; c += 3) {
        const auto first = static_cast<std::size_t>(c);
        for_order(order, Project<3>{directions, values.from_row(first), weights, out + first * n});
    }
    for (; c < channels; ++c) {
        const auto first = static_cast<std::size_t>(c);
        for_order(order, Project<1>{directions, values.from_row(first), weights, out + first * n});
    }
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(project_kernel);

void project_samples(int order, ConstBatch directions, ConstBatch values, int channels, std::span<const float> weights,
                     std::span<double> out) {
    assert(order >= 1 && order <= max_order && channels >= 1 && values.count == directions.count);
    assert(weights.size() >= directions.count &&
           out.size() >= static_cast<std::size_t>(channels * coefficient_count(order)));
    HWY_DYNAMIC_DISPATCH(project_kernel)(order, directions, values, channels, weights.data(), out.data());
}

} // namespace alpenglow::sh
#endif
