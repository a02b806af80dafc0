// Deringing of many probes in structure-of-arrays form.
#pragma once

#include <alpenglow/components/light_probe.hpp>
#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/dering.hpp>

#include <span>

namespace alpenglow::probes {

inline constexpr std::size_t dering_rows_at_most = 128; // items in one call

[[nodiscard]] sh::DeringOptions dering_options(Deringing deringing, int order) noexcept;

// rows holds 3 * order^2 rows, channel by channel, of at most dering_rows_at_most items; replaces them by the deringed
// ones, all channels of an item by the same factors. window[k] = the factor of band 1; 0 rows for an item that is not
// finite, and window NaN.
void dering_rows(int order, Deringing deringing, sh::Batch rows, std::span<float> window);

} // namespace alpenglow::probes
