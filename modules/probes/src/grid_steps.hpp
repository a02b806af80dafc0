// How probes are laid out in memory, for the scalar and the vectorised blending.
#pragma once

#include <alpenglow/components/probe_grid.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace alpenglow::probes {

inline constexpr int max_packed_order = 3; // what PackedProbe has room for

[[nodiscard]] std::size_t bytes_per_probe(int order) noexcept;

// A visibility as given, or 1; 0 for NaN.
inline float visibility(const std::vector<float>& values, std::size_t probe) noexcept {
    const float v = values.empty() ? 1.0F : values[probe];
    return std::isgreater(v, 0.0F) ? std::min(v, 1.0F) : 0.0F;
}

// An occlusion is a function between 0 and 1, so that no coefficient is above sqrt(4 pi). By the bits: a comparison
// with NaN would raise a floating-point exception.
inline bool occlusion_coefficient(float v) noexcept {
    return (std::bit_cast<std::uint32_t>(v) & 0x7fffffffU) <= std::bit_cast<std::uint32_t>(4.0F);
}
inline bool albedo_component(float v) noexcept {
    return std::bit_cast<std::uint32_t>(v + 0.0F) <= std::bit_cast<std::uint32_t>(1.0F);
}

// Index distance of neighbours along each axis.
inline std::array<std::uint32_t, 3> axis_steps(const ProbeGrid& grid) noexcept {
    const auto nx = static_cast<std::uint32_t>(grid.count.x);
    return {1, nx, nx * static_cast<std::uint32_t>(grid.count.y)};
}

// The cells between probes; an axis with one probe has one cell, both ends of which are that probe.
struct Cells {
    std::array<float, 3> min{}, max{}, scale{}; // offset in cells = (position - min) * scale
    std::array<float, 3> last{}, last_cell{};   // the last probe, and the last cell's first probe
    std::array<std::uint32_t, 3> stride{};      // index distance of cells
    std::array<std::uint32_t, 3> step{};        // index distance of a cell's ends: 0 along an axis with one probe
};
inline Cells cells_of(const ProbeGrid& grid) noexcept {
    Cells cells;
    cells.stride = axis_steps(grid);
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const int n = grid.count[axis];
        cells.min[a] = grid.min_m[axis];
        cells.max[a] = grid.max_m[axis];
        cells.scale[a] = n > 1 ? static_cast<float>(n - 1) / (grid.max_m[axis] - grid.min_m[axis]) : 0.0F;
        cells.last[a] = static_cast<float>(n - 1);
        cells.last_cell[a] = static_cast<float>(std::max(n - 2, 0));
        cells.step[a] = n > 1 ? cells.stride[a] : 0;
    }
    return cells;
}
inline std::uint32_t corner_offset(const Cells& cells, std::uint32_t corner) noexcept {
    return ((corner & 1U) != 0 ? cells.step[0] : 0) + ((corner & 2U) != 0 ? cells.step[1] : 0) +
           ((corner & 4U) != 0 ? cells.step[2] : 0);
}

// The cell that a position is in, by its first corner, and where in it, 0 .. 1 along each axis. Positions outside of
// the grid, and components that are not finite, are brought to its bounds.
struct Located {
    std::uint32_t first = 0;
    std::array<float, 3> fraction{};
};
inline Located locate(const Cells& cells, const glm::vec3& position_m) noexcept {
    Located at;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const float p = std::isfinite(position_m[axis]) ? position_m[axis] : cells.min[a];
        const float offset =
            std::min((std::clamp(p, cells.min[a], cells.max[a]) - cells.min[a]) * cells.scale[a], cells.last[a]);
        const float cell = std::min(std::floor(offset), cells.last_cell[a]);
        at.fraction[a] = offset - cell;
        at.first += static_cast<std::uint32_t>(cell) * cells.stride[a];
    }
    return at;
}

} // namespace alpenglow::probes
