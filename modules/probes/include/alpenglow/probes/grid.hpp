// The geometry of a probe grid: where probes stand, which ones count, and trilinear blending among them.
#pragma once

#include <alpenglow/components/probe_grid.hpp>
#include <alpenglow/core/result.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

// Names the field that is out of range, if one is: no probes, inverted or non-finite bounds, an order or budget out of
// range, arrays of another length than the grid, or more than max_bytes of memory (the message says how
// much it would take). Does not look into visibilities and occlusion: see assemble().
[[nodiscard]] Status check(const ProbeGrid& grid, std::size_t max_bytes = std::size_t{4} << 30U);

// Probes of a grid; 0 where a count is below 1.
[[nodiscard]] std::size_t probe_count(const ProbeGrid& grid) noexcept;

// What ProbeGridSh holds for a grid. At order 3 214 bytes a probe.
[[nodiscard]] std::size_t memory_bytes(const ProbeGrid& grid) noexcept;

[[nodiscard]] glm::vec3 probe_position_m(const ProbeGrid& grid, std::size_t probe) noexcept;
[[nodiscard]] bool contains(const ProbeGrid& grid, const glm::vec3& position_m) noexcept;

// Sizes the books of `light` for a grid that check() has passed, forgets all probes that were made, and finds the
// nearest valid probe of each (in steps along the axes; the lowest index among equals).
void prepare(const ProbeGrid& grid, ProbeGridSh& light);

// The eight probes around a position and their trilinear weights, which sum to 1. Corner c is offset by bit 0 of c
// along x, bit 1 along y, bit 2 along z. Outside of the grid: those of the nearest point of its bounds.
struct Corners {
    std::array<std::uint32_t, 8> probe{};
    std::array<float, 8> weight{};
};
[[nodiscard]] Corners trilinear_corners(const ProbeGrid& grid, const glm::vec3& position_m) noexcept;

// The same among the probes that count: valid and made. The others get the weight 0 and the index of one that counts,
// and the rest is scaled to a sum of 1, so that no light leaks out of terrain. Where none counts: the nearest valid
// probe of the corner of greatest weight, and where that was never made, or the position is not finite, the probe in
// the open.
[[nodiscard]] Corners blend_corners(const ProbeGrid& grid, const ProbeGridSh& light,
                                    const glm::vec3& position_m) noexcept;

// out[r * light.lines ..]: the light at position r, blended of blend_corners(). Vectorised; blend_reference is the
// scalar path. Error below 1e-6 of the largest coefficient among the corners.
void blend(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
           std::span<ProbeLine> out);
void blend_reference(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
                     std::span<ProbeLine> out);

// The same out of ProbeGridSh::packed, orders up to 3: half the memory to fetch, which is what random places cost.
// Error below 2e-5 of the largest coefficient of any channel among the corners, 4e-5 for the mean, which is raised by
// what rounding may take from the irradiance, so that what was nowhere negative is not afterwards.
void blend_packed(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
                  std::span<ProbeLine> out);
// Brings ProbeGridSh::packed up to date for some probes; the one in the open has the index of the probes' number.
// assemble() and update_grid() do it.
void pack(ProbeGridSh& light, std::span<const std::uint32_t> probes);

// Coefficient i of a probe.
[[nodiscard]] inline glm::vec3 coefficient(const ProbeGridSh& light, std::size_t probe, int i) noexcept {
    const auto at = [&](std::size_t k) { return light.coefficients[probe * light.lines + k / 16].values[k % 16]; };
    const std::size_t first = 3 * static_cast<std::size_t>(i);
    return {at(first), at(first + 1), at(first + 2)};
}

} // namespace alpenglow::probes
