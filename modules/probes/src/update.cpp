#include <alpenglow/probes/update.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/probes/assemble.hpp>
#include <alpenglow/probes/grid.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/zonal.hpp>

#include "grid_steps.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include <glm/common.hpp>

namespace alpenglow::probes {

namespace {

// Bounds, over all probes, of |1 - O| as a factor on the sky (O as it is, and mirrored at the horizon) and of the light
// that a ground illuminance of 1 makes.
void find_gains(const ProbeGrid& grid, ProbeGridSh& light) {
    const std::size_t count = probe_count(grid);
    const int order = grid.order;
    const auto n = static_cast<std::size_t>(sh::coefficient_count(order));
    std::array<double, max_probe_order> lower{};
    sh::zonal_hemisphere(order, 0.0, 1.0, lower);
    double lower_squared = 0.0;
    for (const double z : lower) {
        lower_squared += z * z;
    }
    const double peak = std::sqrt(static_cast<double>(n - 1) / (4.0 * pi)); // of a unit vector without band 0
    double sky = 1.0;
    double ground_squared = lower_squared;
    for (std::size_t p = 0; p < count && !grid.occlusion.empty(); ++p) {
        double rest = 0.0;
        double even = 0.0;
        double both = 0.0;
        bool usable = true;
        for (std::size_t i = 0; i < n; ++i) {
            usable = usable && occlusion_coefficient(grid.occlusion[i * count + p]);
        }
        if (!usable) {
            continue;
        }
        for (std::size_t i = 0; i < n; ++i) {
            const double o = static_cast<double>(grid.occlusion[i * count + p]);
            rest += i == 0 ? 0.0 : o * o;
            both += o * o;
        }
        for (int l = 1; l < order; ++l) {
            for (int m = -l; m <= l; m += 2) {
                const double o =
                    2.0 * static_cast<double>(grid.occlusion[static_cast<std::size_t>(sh::index(l, m)) * count + p]);
                even += o * o;
            }
        }
        for (int l = 0; l < order; ++l) {
            const std::size_t i = static_cast<std::size_t>(sh::index(l, 0));
            const double z = lower[static_cast<std::size_t>(l)];
            both += z * (z + 2.0 * static_cast<double>(grid.occlusion[i * count + p]));
        }
        const double mean = static_cast<double>(grid.occlusion[p]) / std::sqrt(4.0 * pi);
        sky = std::max(
            {sky, std::abs(1.0 - mean) + peak * std::sqrt(rest), std::abs(1.0 - 2.0 * mean) + peak * std::sqrt(even)});
        ground_squared = std::max(ground_squared, both);
    }
    glm::dvec3 albedo(grid.ground_albedo);
    for (const glm::vec3& a : grid.albedo) {
        for (int c = 0; c < 3; ++c) {
            albedo[c] = albedo_component(a[c]) ? std::max(albedo[c], static_cast<double>(a[c])) : albedo[c];
        }
    }
    light.sky_gain = sky;
    light.ground_gain = albedo * (std::sqrt(ground_squared) / pi);
}

// Lets the probe count, or not, in the cells that it is a corner of. Where it has no neighbour, the bit falls into a
// cell that lies outside of the grid and is never asked for.
void set_counting(const Cells& cells, ProbeGridSh& light, std::uint32_t probe, bool counts) {
    for (std::uint32_t c = 0; c < 8; ++c) {
        const std::uint32_t offset = corner_offset(cells, c);
        if (offset <= probe) {
            std::uint8_t& mask = light.cell_mask[probe - offset];
            mask = static_cast<std::uint8_t>(counts ? mask | 1U << c : mask & ~(1U << c));
        }
    }
}

void make_open_probe(const ProbeGrid& grid, ProbeGridSh& light) {
    ProbeInput input;
    input.albedo = grid.ground_albedo;
    const ProbeCoefficients open = assemble_reference(grid.order, grid.deringing, light.target, input);
    float* const out = light.coefficients[light.made_pass.size() * light.lines].values.data();
    for (int i = 0; i < sh::coefficient_count(grid.order); ++i) {
        for (int c = 0; c < 3; ++c) {
            out[3 * i + c] = open[static_cast<std::size_t>(i)][c];
        }
    }
    const auto index = static_cast<std::uint32_t>(light.made_pass.size());
    pack(light, std::span(&index, 1));
}

} // namespace

Status begin_frame(const ProbeGrid& grid, ProbeGridSh& light) {
    if (Status status = check(grid); !status) {
        return status;
    }
    if (light.grid_revision != grid.revision || light.made_pass.size() != probe_count(grid) ||
        light.order != grid.order) {
        prepare(grid, light);
        find_gains(grid, light);
    }
    std::fill(light.needed.begin(), light.needed.end(), std::uint8_t{0});
    return Ok{};
}

bool mark_needed(const ProbeGrid& grid, ProbeGridSh& light, std::span<const glm::vec3> positions_m) {
    const Cells cells = cells_of(grid);
    std::array<std::uint32_t, 8> offsets{};
    for (std::uint32_t c = 0; c < 8; ++c) {
        offsets[c] = corner_offset(cells, c);
    }
    bool any = false;
    for (const glm::vec3& p : positions_m) {
        if (!contains(grid, p)) {
            continue;
        }
        any = true;
        const std::uint32_t first = locate(cells, p).first;
        for (const std::uint32_t offset : offsets) {
            // An invalid probe lights nothing; the nearest valid one may have to stand in.
            light.needed[light.nearest[first + offset]] = 1;
        }
    }
    return any;
}

UpdateCounts update_grid(const ProbeGrid& grid, ProbeGridSh& light, const ProbeSources& sources,
                         const Capture& capture) {
    assert(light.grid_revision == grid.revision && usable(sources));
    const auto count = static_cast<std::uint32_t>(light.made_pass.size());
    UpdateCounts counts{.considered = count};
    DriftBound drift = drift_bound(grid, light, sources);
    const double limit = static_cast<double>(grid.max_error);
    const bool anyone = std::find(light.needed.begin(), light.needed.end(), 1) != light.needed.end();
    if (!anyone) {
        counts.skipped = count;
        return counts;
    }
    const bool moved = !(drift.sources <= limit);
    if (moved) {
        light.target = sources;
        ++light.pass;
        light.dering_gain = 0.0;
        make_open_probe(grid, light);
        ++light.revision;
        drift = drift_bound(grid, light, sources);
    }

    const bool captures = grid.source == ProbeSource::captured && capture.render;
    const std::size_t budget = captures ? std::min(grid.budget, capture.budget) : grid.budget;
    std::vector<std::uint32_t> fresh;
    std::vector<std::uint32_t> stale;
    std::uint32_t waiting = 0;
    const bool compare = !grid.sun_visibility.empty() || !grid.moon_visibility.empty();
    const auto consider = [&](std::uint32_t p) {
        if (light.needed[p] == 0 || (!grid.valid.empty() && grid.valid[p] == 0)) {
            return;
        }
        if (light.made_pass[p] == 0) {
            if (fresh.size() < budget) {
                fresh.push_back(p);
            } else {
                ++waiting;
            }
            return;
        }
        double bound = drift.sources;
        if (compare || light.made_sun_visibility[p] != 1.0F || light.made_moon_visibility[p] != 1.0F) {
            bound += drift.per_sun_visibility * std::abs(static_cast<double>(visibility(grid.sun_visibility, p)) -
                                                         static_cast<double>(light.made_sun_visibility[p])) +
                     drift.per_moon_visibility * std::abs(static_cast<double>(visibility(grid.moon_visibility, p)) -
                                                          static_cast<double>(light.made_moon_visibility[p]));
        }
        if (light.made_pass[p] == light.pass && bound <= limit) {
            counts.error_bound = std::max(counts.error_bound, bound);
            return;
        }
        if (stale.size() < budget) {
            stale.push_back(p);
        } else {
            ++waiting;
        }
    };
    for (std::uint32_t p = light.cursor; p < count; ++p) {
        consider(p);
    }
    for (std::uint32_t p = 0; p < std::min(light.cursor, count); ++p) {
        consider(p);
    }
    const std::size_t room = budget - fresh.size();
    if (stale.size() > room) {
        waiting += static_cast<std::uint32_t>(stale.size() - room);
        stale.resize(room);
    }
    if (!stale.empty()) {
        light.cursor = (stale.back() + 1) % count;
    }
    fresh.insert(fresh.end(), stale.begin(), stale.end());
    std::sort(fresh.begin(), fresh.end());
    if (!fresh.empty()) {
        std::vector<glm::vec3> captured;
        if (captures) {
            const auto n = static_cast<std::size_t>(sh::coefficient_count(grid.order));
            captured.resize(fresh.size() * n);
            for (std::size_t k = 0; k < fresh.size(); ++k) {
                capture_probe(probe_position_m(grid, fresh[k]), grid.order, capture.render,
                              std::span(captured).subspan(k * n, n));
            }
        }
        assemble(grid, fresh, light, captured);
        const Cells cells = cells_of(grid);
        for (const std::uint32_t p : fresh) {
            set_counting(cells, light, p, !std::isnan(light.window[p]));
        }
        ++light.revision;
    }
    counts.updated = static_cast<std::uint32_t>(fresh.size());
    counts.skipped = count - counts.updated - waiting;
    return counts;
}

} // namespace alpenglow::probes
