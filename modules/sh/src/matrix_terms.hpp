// The product matrix as sparse sums, entry by entry.
#pragma once

#include <alpenglow/sh/product.hpp>

#include <cstddef>
#include <vector>

namespace alpenglow::sh::detail {

// The upper triangle of "multiply by f": entry (row, column) is the sum over terms [end of the one before, end) of
// factor times coefficient `row` of f.
struct MatrixEntry {
    std::size_t row, column, end;
};
struct MatrixTerms {
    std::vector<MatrixEntry> entries; // those without terms are zero
    std::vector<std::size_t> rows;
    std::vector<float> factors;
};

// Made of the Gaunt table on first use, order 1 .. max_order.
[[nodiscard]] const MatrixTerms& matrix_terms(int order);

} // namespace alpenglow::sh::detail
