// Deringing by a search for the minimum: signals with more than a quadratic in them.
#pragma once

#include <alpenglow/sh/dering_batch.hpp>

namespace alpenglow::sh::detail {

void dering_by_search(int order, int channels, ConstBatch in, Batch out, Signal signal,
                      std::span<DeringOutcome> outcomes, Batch factors);

} // namespace alpenglow::sh::detail
