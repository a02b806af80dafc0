// Deringing of many probes at a time.
#pragma once

#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/dering.hpp>

namespace alpenglow::sh {

// Order 3: find_window and apply_dering for every item. `in` and `out` (which may be the same) have 9 rows a channel,
// channel c's coefficient i in row 9 c + i; the channels of an item share one window. options.family is blend, gauss or
// sloan, the cap the whole sphere, and the paper's bound has both sides. Float throughout; no value of a windowed
// signal is below -1e-6 of its average. Outcomes as in dering.hpp: a NaN makes its own item zero and no other.
// `outcomes`: empty, or one for each item. `factors`: no data, or two rows, the factors of bands 1 and 2.
void dering(int channels, ConstBatch in, Batch out, const DeringOptions& options = {},
            std::span<DeringOutcome> outcomes = {}, Batch factors = {});

// Orders 3 to 6, the exact method and the blend family: order * order rows a channel, order - 1 rows of factors. The
// window follows from a certified lower bound of the minimum: no value of a windowed signal is below -1e-6 of its
// average, none is windowed whose minimum is above -1e-4 of it by less than rounding, and the window is within 3e-4 of
// the least possible. Irradiance has no third band, so that order 4 is as fast as order 3.
void dering(int order, int channels, ConstBatch in, Batch out, const DeringOptions& options,
            std::span<DeringOutcome> outcomes = {}, Batch factors = {});

// Certified minima of many vectors, orders 2 to 6, over the sphere: `out` has the rows lower bound, value, and x, y, z
// of the direction with that value. lower bound <= minimum <= value + 1e-6 of the norm, and value - lower bound is at
// most `tolerance` (1e-5 .. 0.1) of the average minus the minimum, or 1e-5 of the norm. `floors`, if not empty: one for
// each item; where nothing is below its floor, the lower bound need only say so. Coefficients are finite.
void certified_minimum(int order, ConstBatch coefficients, float tolerance, Batch out,
                       std::span<const float> floors = {});

} // namespace alpenglow::sh
