// Parts of glossy, neighbourhood and volume bakes: what the rays of a range of points say by themselves. Any batch
// scheduler makes them in any order; the `finish_` function of the kind joins them, does what needs all points
// (bounces, the inside of neighbourhoods), and gives what the whole bake would give, bit for bit. Diffuse bakes:
// BakePart.
#pragma once

#include <alpenglow/prt/transfer_table.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace alpenglow::prt {

struct FieldPart {
    TransferKind kind = TransferKind::glossy;
    std::uint64_t input_hash = 0;    // of the mesh or the density, and the grid
    std::uint64_t settings_hash = 0; // of all that changes a result
    std::size_t first = 0;           // points [first, first + count)
    std::size_t count = 0;
    std::vector<float> values;        // [point][row][coefficient]
    std::vector<std::uint8_t> inside; // [point], neighbourhoods: most of what is seen are backs
    std::uint64_t rays = 0;
    std::size_t dark_points = 0;
    double cpu_s = 0.0;
};

// All points' values from parts in any order. An Error says which are missing, there twice, or of another bake.
[[nodiscard]] Result<FieldPart> joined(std::vector<FieldPart> parts, TransferKind kind, std::uint64_t input_hash,
                                       std::uint64_t settings_hash, std::size_t points, std::size_t width);

} // namespace alpenglow::prt
