// Deringing of many order 3 probes at a time.
#pragma once

#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/dering.hpp>

namespace alpenglow::sh {

// find_window and apply_dering for every item. `in` and `out` (which may be the same) have 9 rows a channel, channel
// c's coefficient i in row 9 c + i; the channels of an item share one window. options.family is blend, gauss or sloan,
// the cap the whole sphere, and the paper's bound has both sides. Float throughout; no value of a windowed signal is
// below -1e-6 of its average. Outcomes as in dering.hpp: a NaN makes its own item zero and no other. `outcomes`: empty,
// or one for each item. `factors`: no data, or two rows, the factors of bands 1 and 2.
void dering(int channels, ConstBatch in, Batch out, const DeringOptions& options = {},
            std::span<DeringOutcome> outcomes = {}, Batch factors = {});

} // namespace alpenglow::sh
