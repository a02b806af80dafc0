// Which probes of a grid to update in a frame, and their update.
#pragma once

#include <alpenglow/components/probe_grid.hpp>
#include <alpenglow/core/result.hpp>
#include <alpenglow/probes/capture.hpp>

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

// Readies `light` for this frame's mark_needed() and update_grid(): prepares it where the grid's revision is another,
// and forgets which probes were needed. An Error, and nothing changed, where check() finds one.
[[nodiscard]] Status begin_frame(const ProbeGrid& grid, ProbeGridSh& light);

// The probes that light receivers at these positions are needed. Positions outside of the grid ask for nothing. Returns
// whether any was inside.
bool mark_needed(const ProbeGrid& grid, ProbeGridSh& light, std::span<const glm::vec3> positions_m);

struct UpdateCounts {
    std::uint32_t considered = 0; // probes
    std::uint32_t updated = 0;
    std::uint32_t skipped = 0; // nobody needs them, they are invalid, or near enough to the light; the rest waits
    double error_bound = 0.0;  // over the skipped probes that somebody needs, as ProbeGrid::max_error
};

// Updates the needed probes that are further than max_error from `sources`, at most grid.budget of them: those that
// were never made first, then round robin. Where the light has moved past max_error since the last target, it becomes
// the next target; all probes are made from the same target, so that neighbours match while they are brought up to it.
// With n probes needed and a light that stands still, all are within max_error after ceil(n / budget) frames, the
// budget of captures counting for grids that capture. `sources` is usable().
UpdateCounts update_grid(const ProbeGrid& grid, ProbeGridSh& light, const ProbeSources& sources,
                         const Capture& capture = {});

} // namespace alpenglow::probes
