#include "dering_orders.hpp"

#include <alpenglow/sh/irradiance.hpp>

#include "tables.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace alpenglow::sh {
namespace {

constexpr std::size_t chunk = 64;
constexpr float bound_tolerance = 2e-4F; // of the average minus the minimum
constexpr float floor_tolerance = 1e-4F; // negative values of this size relative to the average count as none
constexpr float margin = 1.0F - 1e-6F;   // for rounding in the windowed coefficients

// By the bits: a comparison with NaN would raise a floating-point exception.
bool is_finite(float v) {
    return (std::bit_cast<std::uint32_t>(v) & 0x7fffffffU) < 0x7f800000U;
}

// Scales one channel of the signal to 1; false where there is no window to find.
bool load_signal(const float* factors, int order, ConstBatch in, std::size_t item, Batch signal, std::size_t to,
                 DeringOutcome& outcome) {
    const auto n = static_cast<std::size_t>(coefficient_count(order));
    float largest = 0.0F;
    for (std::size_t i = 0; i < n; ++i) {
        const float v = in.row(i)[item];
        if (!is_finite(v)) {
            outcome = DeringOutcome::not_finite;
            return false;
        }
        largest = std::max(largest, std::abs(v));
    }
    if (largest == 0.0F || outcome == DeringOutcome::not_finite) {
        return false;
    }
    if (in.row(0)[item] <= 0.0F) {
        outcome = DeringOutcome::dark;
        return false;
    }
    int exponent = 0;
    static_cast<void>(std::frexp(largest, &exponent));
    for (int l = 0; l < order; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            signal.row(i)[to] = factors[l] * std::ldexp(in.row(i)[item], -exponent);
        }
    }
    return true;
}

} // namespace

namespace detail {

void dering_by_search(int order, int channels, ConstBatch in, Batch out, Signal signal,
                      std::span<DeringOutcome> outcomes, Batch factors) {
    const auto n = static_cast<std::size_t>(coefficient_count(order));
    std::array<float, max_order> bands{};
    for (int l = 0; l < order; ++l) {
        bands[static_cast<std::size_t>(l)] =
            signal == Signal::irradiance ? static_cast<float>(cosine_factor(l) / pi) : 1.0F;
    }
    BatchBuffer scaled(n, chunk), found(5, chunk);
    std::array<float, chunk> kept, floors;
    std::array<DeringOutcome, chunk> outcome;
    std::array<std::size_t, chunk> item;
    const float y0 = static_cast<float>(basis_tables.seed[0]);
    for (std::size_t begin = 0; begin < in.count; begin += chunk) {
        const std::size_t here = std::min(chunk, in.count - begin);
        kept.fill(1.0F);
        outcome.fill(DeringOutcome::unchanged);
        for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
            std::size_t count = 0;
            for (std::size_t k = 0; k < here; ++k) {
                if (load_signal(bands.data(), order, in.from_row(c * n), begin + k, scaled, count, outcome[k])) {
                    floors[count] = -floor_tolerance * y0 * scaled.row(0)[count];
                    item[count++] = k;
                }
            }
            certified_minimum(order, scaled.view().items(0, count), bound_tolerance, found.view().items(0, count),
                              floors);
            for (std::size_t k = 0; k < count; ++k) {
                const float mean = y0 * scaled.row(0)[k], least = found.row(0)[k];
                if (least < floors[k]) {
                    // Towards the average the minimum is linear. The average of the rest is zero, its minimum below.
                    kept[item[k]] = std::min(kept[item[k]], margin * mean / (mean - least));
                }
            }
        }
        for (std::size_t k = 0; k < here; ++k) {
            const bool out_of_use = outcome[k] == DeringOutcome::dark || outcome[k] == DeringOutcome::not_finite;
            if (out_of_use) {
                kept[k] = 0.0F;
            } else if (kept[k] < 1.0F) {
                outcome[k] = DeringOutcome::windowed;
            }
            for (std::size_t i = 0; i < n * static_cast<std::size_t>(channels); ++i) {
                const float v = in.row(i)[begin + k];
                out.row(i)[begin + k] = out_of_use ? 0.0F : i % n == 0 ? v : kept[k] * v;
            }
            for (std::size_t l = 1; l < static_cast<std::size_t>(order) && factors.data != nullptr; ++l) {
                factors.row(l - 1)[begin + k] = kept[k];
            }
            if (!outcomes.empty()) {
                outcomes[begin + k] = outcome[k];
            }
        }
    }
}

} // namespace detail
} // namespace alpenglow::sh
