// What a cube projector hands to its kernels.
#pragma once

#include <cstddef>

namespace alpenglow::sh::detail {

struct CubeTables {
    const float* table;
    const float* centre; // null: the basis is tabulated
    std::size_t row_floats;
};

} // namespace alpenglow::sh::detail
