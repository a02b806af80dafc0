#include "dering_rows.hpp"

#include <alpenglow/sh/dering_batch.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace alpenglow::probes {

sh::DeringOptions dering_options(Deringing deringing, int order) noexcept {
    sh::DeringOptions options;
    // The paper's bound is for order 3; above it there is the exact way alone.
    options.method = deringing == Deringing::paper && order <= 3 ? sh::DeringMethod::paper : sh::DeringMethod::exact;
    return options;
}

namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Orders 3 to 5, by the batch.
void dering_batch(int order, Deringing deringing, sh::Batch rows, std::span<float> window) {
    std::array<sh::DeringOutcome, dering_rows_at_most> outcomes{};
    std::array<float, (max_probe_order - 1) * dering_rows_at_most> factors{};
    assert(rows.count <= dering_rows_at_most);
    const sh::DeringOptions options = dering_options(deringing, order);
    const std::span<sh::DeringOutcome> became = std::span(outcomes).first(rows.count);
    const sh::Batch kept{factors.data(), rows.count, dering_rows_at_most};
    if (order == 3) {
        sh::dering(3, rows, rows, options, became, kept);
    } else {
        sh::dering(order, 3, rows, rows, options, became, kept);
    }
    for (std::size_t k = 0; k < rows.count; ++k) {
        window[k] = outcomes[k] == sh::DeringOutcome::not_finite ? nan : factors[k];
    }
}

} // namespace

void dering_rows(int order, Deringing deringing, sh::Batch rows, std::span<float> window) {
    if (order >= 3 && deringing != Deringing::none) {
        dering_batch(order, deringing, rows, window);
        return;
    }
    const auto n = static_cast<std::size_t>(3 * order * order);
    const sh::DeringOptions options = dering_options(deringing, order);
    std::array<double, 3 * max_probe_coefficients> item{};
    const std::span<double> channels(item.data(), n);
    for (std::size_t k = 0; k < rows.count; ++k) {
        for (std::size_t i = 0; i < n; ++i) {
            item[i] = static_cast<double>(rows.row(i)[k]);
        }
        if (!std::all_of(channels.begin(), channels.end(), [](double v) { return std::isfinite(v); })) {
            std::fill(channels.begin(), channels.end(), 0.0);
            window[k] = nan;
        } else if (deringing == Deringing::none) {
            window[k] = 1.0F;
            continue;
        } else {
            const sh::Dering dering = sh::find_window(order, channels, options);
            sh::apply_dering(order, dering, channels, channels);
            window[k] = order > 1 ? static_cast<float>(dering.factors[1]) : 1.0F;
        }
        for (std::size_t i = 0; i < n; ++i) {
            rows.row(i)[k] = static_cast<float>(item[i]);
        }
    }
}

} // namespace alpenglow::probes
