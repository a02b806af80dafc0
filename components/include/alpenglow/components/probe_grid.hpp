// A regular grid of light probes.
#pragma once

#include <alpenglow/components/light_probe.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow {

// Input. Probe (i, j, k) stands at min_m + (i, j, k) / (count - 1) (max_m - min_m) and has the index
// i + count.x (j + count.y k). The arrays hold one value a probe or are empty, for the default.
struct ProbeGrid {
    glm::vec3 min_m{0.0F}; // the first probe, local frame
    glm::vec3 max_m{1.0F}; // the last probe; greater along every axis that has more than one probe
    glm::ivec3 count{2};   // probes along each axis, 1 or more
    int order = 3;         // 1 .. max_probe_order
    Deringing deringing = Deringing::exact;
    ProbeSource source = ProbeSource::assembled;
    float max_error = 0.01F;       // of a probe's light, relative to that of a probe in the open, that may go unnoticed
    std::uint32_t budget = 4096;   // probes updated in one frame at most, 1 or more
    glm::vec3 ground_albedo{0.2F}; // linear Rec.709, 0 .. 1

    std::vector<std::uint8_t> valid;    // 0 where a probe is inside terrain or walls: it lights nothing. Default: valid
    std::vector<float> sun_visibility;  // 0 .. 1, default 1; NaN counts as 0
    std::vector<float> moon_visibility; // 0 .. 1, default 1; NaN counts as 0
    std::vector<glm::vec3> albedo;      // of the ground that the probe sees, default ground_albedo
    // What stands above the horizon as the probe sees it (1 blocked, 0 open; 0 below the horizon, where the ground is
    // seen in any case), on SH: coefficient i of probe p at [i * probes + p], order * order rows. Default: nothing.
    std::vector<float> occlusion;

    // To be raised after a change of anything above but the visibilities, max_error and budget: all probes are made
    // again. Changes of visibility are found probe by probe.
    std::uint32_t revision = 1;
};

// Sixteen floats, aligned: what probes are stored in.
struct alignas(64) ProbeLine {
    std::array<float, 16> values{};
};

// A probe of order 3 or less in one cache line: value i is values[i] * scale, in the order of
// ProbeGridSh::coefficients; the three after the last are what the means lack, in units of 2^-15.
struct alignas(64) PackedProbe {
    std::array<std::int16_t, 30> values{};
    float scale = 0.0F;
};

// Output of update_probes: the light of a grid's probes, and the books that are kept over them.
struct ProbeGridSh {
    int order = 0;
    std::size_t lines = 0; // ProbeLines a probe
    // Radiance, cd/m^2, deringed: coefficient i, channel c of probe p is float 3 i + c of its `lines` lines. One more
    // probe follows the last: the one in the open, which stands in for probes that were never made.
    std::vector<ProbeLine> coefficients;
    std::vector<PackedProbe> packed; // the same in 16 bits, for blending; empty above order 3
    std::vector<float> window;       // factor of band 1 in the probe's sky and bounce after deringing, 1: untouched;
                                     // NaN: its input was unusable, it lights nothing

    // The light that the probes are being brought up to, and how far they are.
    ProbeSources target;
    std::uint32_t pass = 0;               // counts targets
    std::vector<std::uint32_t> made_pass; // the pass a probe was made in; 0: never
    std::vector<float> made_sun_visibility, made_moon_visibility;
    std::uint32_t cursor = 0;    // where the round robin goes on
    double sky_gain = 1.0;       // how a probe's light may answer to a change of the sky, of the ground's
    glm::dvec3 ground_gain{0.0}; // illuminance (1 / sr, per channel), and through deringing: see drift_bound()
    double dering_gain = 0.0;

    // For blending.
    std::vector<std::uint8_t> needed;    // by a visible receiver, this frame
    std::vector<std::uint8_t> cell_mask; // of the cell whose first corner is the probe: bit c set where corner c counts
    std::vector<std::uint32_t> nearest;  // the valid probe nearest to each probe
    std::uint32_t grid_revision = 0;     // ProbeGrid::revision these were made from; 0: never
    std::uint32_t revision = 0;          // raised whenever a probe's light changes
};

} // namespace alpenglow
