#include <alpenglow/probes/grid.hpp>

#include "grid_steps.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::probes {

namespace {

constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

Error error(const std::string& field, const std::string& what, const std::string& expected) {
    return {.what = what, .where = "ProbeGrid::" + field, .expected = expected};
}

template <class T>
bool wrong_length(const std::vector<T>& array, std::size_t length) {
    return !array.empty() && array.size() != length;
}

Error length_error(const std::string& field, std::size_t length, std::size_t expected) {
    return error(field, "has " + std::to_string(length) + " values",
                 "none, or " + std::to_string(expected) + " for the grid");
}

std::size_t lines_of(int order) {
    return (static_cast<std::size_t>(3 * order * order) + 15) / 16;
}

// Breadth first from all valid probes at once.
void find_nearest(const ProbeGrid& grid, std::vector<std::uint32_t>& nearest) {
    const std::size_t count = probe_count(grid);
    nearest.resize(count);
    if (grid.valid.empty()) {
        for (std::size_t p = 0; p < count; ++p) {
            nearest[p] = static_cast<std::uint32_t>(p);
        }
        return;
    }
    constexpr std::uint32_t none = ~std::uint32_t{0};
    std::vector<std::uint32_t> front;
    for (std::size_t p = 0; p < count; ++p) {
        nearest[p] = grid.valid[p] != 0 ? static_cast<std::uint32_t>(p) : none;
        if (grid.valid[p] != 0) {
            front.push_back(static_cast<std::uint32_t>(p));
        }
    }
    if (front.empty()) { // nothing counts, and nothing will be made: the probe in the open stands in
        std::fill(nearest.begin(), nearest.end(), 0U);
        return;
    }
    const std::array<std::uint32_t, 3> steps = axis_steps(grid);
    std::vector<std::uint32_t> next;
    while (!front.empty()) {
        next.clear();
        for (const std::uint32_t p : front) {
            for (int axis = 0; axis < 3; ++axis) {
                const std::uint32_t step = steps[static_cast<std::size_t>(axis)];
                const auto along = static_cast<int>(p / step) % grid.count[axis];
                for (const int sign : {-1, 1}) {
                    if (along + sign < 0 || along + sign >= grid.count[axis]) {
                        continue;
                    }
                    const std::uint32_t q = sign < 0 ? p - step : p + step;
                    if (nearest[q] == none) {
                        nearest[q] = nearest[p];
                        next.push_back(q);
                    }
                }
            }
        }
        std::sort(next.begin(), next.end());
        front.swap(next);
    }
}

} // namespace

Status check(const ProbeGrid& grid, std::size_t max_bytes) {
    for (int axis = 0; axis < 3; ++axis) {
        const std::string name = axis_names[static_cast<std::size_t>(axis)];
        const int n = grid.count[axis];
        if (n < 1) {
            return error("count." + name, "is " + std::to_string(n), "1 or more probes along each axis");
        }
        const float low = grid.min_m[axis];
        const float high = grid.max_m[axis];
        if (!std::isfinite(low) || !std::isfinite(high)) {
            return error((std::isfinite(low) ? "max_m." : "min_m.") + name, "is not finite", "metres");
        }
        if (n > 1 ? !(high > low) : !(high >= low)) {
            return error("max_m." + name,
                         "is " + std::to_string(high) + ", with min_m." + name + " at " + std::to_string(low),
                         n > 1 ? "a greater max_m where an axis has more than one probe" : "max_m not below min_m");
        }
        const double extent = static_cast<double>(high) - static_cast<double>(low);
        if (extent > 1e30 || (n > 1 && extent / (n - 1) < 1e-30)) {
            return error("max_m." + name, "makes an extent of " + std::to_string(extent) + " m",
                         "a spacing over 1e-30 m and an extent under 1e30 m");
        }
    }
    if (grid.order < 1 || grid.order > max_probe_order) {
        return error("order", "is " + std::to_string(grid.order), "1 to " + std::to_string(max_probe_order));
    }
    if (grid.budget < 1) {
        return error("budget", "is 0", "1 or more probes a frame");
    }
    if (!(grid.max_error >= 0.0F)) {
        return error("max_error", "is " + std::to_string(grid.max_error), "0 or more");
    }
    for (int c = 0; c < 3; ++c) {
        if (!(grid.ground_albedo[c] >= 0.0F && grid.ground_albedo[c] <= 1.0F)) {
            return error("ground_albedo", "has a component of " + std::to_string(grid.ground_albedo[c]), "0 to 1");
        }
    }
    const double probes = static_cast<double>(grid.count.x) * grid.count.y * grid.count.z;
    const double bytes = probes * static_cast<double>(bytes_per_probe(grid.order));
    if (probes > 2e9 || bytes > static_cast<double>(max_bytes)) {
        return error("count",
                     "makes " + std::to_string(static_cast<long long>(std::min(probes, 9e18))) +
                         " probes, which take " +
                         std::to_string(static_cast<long long>(std::min(bytes / 1048576.0, 9e18))) + " MiB",
                     "at most " + std::to_string(max_bytes >> 20U) + " MiB and 2e9 probes");
    }
    const std::size_t count = probe_count(grid);
    if (wrong_length(grid.valid, count)) {
        return length_error("valid", grid.valid.size(), count);
    }
    if (wrong_length(grid.sun_visibility, count)) {
        return length_error("sun_visibility", grid.sun_visibility.size(), count);
    }
    if (wrong_length(grid.moon_visibility, count)) {
        return length_error("moon_visibility", grid.moon_visibility.size(), count);
    }
    if (wrong_length(grid.albedo, count)) {
        return length_error("albedo", grid.albedo.size(), count);
    }
    const std::size_t occlusion = count * static_cast<std::size_t>(grid.order * grid.order);
    if (wrong_length(grid.occlusion, occlusion)) {
        return length_error("occlusion", grid.occlusion.size(), occlusion);
    }
    return Ok{};
}

std::size_t bytes_per_probe(int order) noexcept {
    return lines_of(order) * sizeof(ProbeLine) + (order <= max_packed_order ? sizeof(PackedProbe) : 0) +
           4 * sizeof(float) + sizeof(std::uint32_t) + 2;
}

std::size_t probe_count(const ProbeGrid& grid) noexcept {
    if (grid.count.x < 1 || grid.count.y < 1 || grid.count.z < 1) {
        return 0;
    }
    return static_cast<std::size_t>(grid.count.x) * static_cast<std::size_t>(grid.count.y) *
           static_cast<std::size_t>(grid.count.z);
}

std::size_t memory_bytes(const ProbeGrid& grid) noexcept {
    return probe_count(grid) * bytes_per_probe(grid.order);
}

glm::vec3 probe_position_m(const ProbeGrid& grid, std::size_t probe) noexcept {
    const auto nx = static_cast<std::size_t>(grid.count.x);
    const auto ny = static_cast<std::size_t>(grid.count.y);
    const glm::vec3 at(static_cast<float>(probe % nx), static_cast<float>(probe / nx % ny),
                       static_cast<float>(probe / (nx * ny)));
    const glm::vec3 steps = glm::max(glm::vec3(grid.count - 1), glm::vec3(1.0F));
    return grid.min_m + at / steps * (grid.max_m - grid.min_m);
}

bool contains(const ProbeGrid& grid, const glm::vec3& p) noexcept {
    return p.x >= grid.min_m.x && p.x <= grid.max_m.x && p.y >= grid.min_m.y && p.y <= grid.max_m.y &&
           p.z >= grid.min_m.z && p.z <= grid.max_m.z;
}

void prepare(const ProbeGrid& grid, ProbeGridSh& light) {
    const std::size_t count = probe_count(grid);
    light.order = grid.order;
    light.lines = lines_of(grid.order);
    light.coefficients.assign((count + 1) * light.lines, ProbeLine{});
    light.packed.assign(grid.order <= max_packed_order ? count + 1 : 0, PackedProbe{});
    light.window.assign(count, 1.0F);
    light.made_pass.assign(count, 0);
    light.made_sun_visibility.assign(count, 0.0F);
    light.made_moon_visibility.assign(count, 0.0F);
    light.needed.assign(count, 0);
    light.cell_mask.assign(count, 0);
    light.cursor = 0;
    light.pass = 0;
    find_nearest(grid, light.nearest);
    light.grid_revision = grid.revision;
}

Corners trilinear_corners(const ProbeGrid& grid, const glm::vec3& position_m) noexcept {
    const Cells cells = cells_of(grid);
    const Located at = locate(cells, position_m);
    Corners corners;
    for (std::uint32_t c = 0; c < 8; ++c) {
        corners.probe[c] = at.first + corner_offset(cells, c);
        corners.weight[c] = ((c & 1U) != 0 ? at.fraction[0] : 1.0F - at.fraction[0]) *
                            ((c & 2U) != 0 ? at.fraction[1] : 1.0F - at.fraction[1]) *
                            ((c & 4U) != 0 ? at.fraction[2] : 1.0F - at.fraction[2]);
    }
    return corners;
}

Corners blend_corners(const ProbeGrid& grid, const ProbeGridSh& light, const glm::vec3& position_m) noexcept {
    const auto open = static_cast<std::uint32_t>(light.made_pass.size());
    Corners corners = trilinear_corners(grid, position_m);
    std::uint32_t stand_in = open;
    if (std::isfinite(position_m.x) && std::isfinite(position_m.y) && std::isfinite(position_m.z)) {
        const unsigned mask = light.cell_mask[corners.probe[0]];
        if (mask == 0xffU) {
            return corners;
        }
        float sum = 0.0F;
        std::size_t heaviest = 0;
        for (std::size_t c = 0; c < 8; ++c) {
            if ((mask >> c & 1U) != 0) {
                sum += corners.weight[c];
            }
            heaviest = corners.weight[c] > corners.weight[heaviest] ? c : heaviest;
        }
        if (sum > 1e-6F) {
            std::uint32_t counted = 0;
            for (std::size_t c = 0; c < 8; ++c) {
                counted = (mask >> c & 1U) != 0 ? corners.probe[c] : counted;
            }
            for (std::size_t c = 0; c < 8; ++c) {
                const bool counts = (mask >> c & 1U) != 0;
                corners.weight[c] = counts ? corners.weight[c] / sum : 0.0F;
                corners.probe[c] = counts ? corners.probe[c] : counted;
            }
            return corners;
        }
        const std::uint32_t nearest = light.nearest[corners.probe[heaviest]];
        if (light.made_pass[nearest] != 0 && !std::isnan(light.window[nearest])) {
            stand_in = nearest;
        }
    }
    corners.probe.fill(stand_in);
    corners.weight.fill(0.0F);
    corners.weight[0] = 1.0F;
    return corners;
}

void blend_reference(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
                     std::span<ProbeLine> out) {
    assert(out.size() >= positions_m.size() * light.lines);
    for (std::size_t r = 0; r < positions_m.size(); ++r) {
        const Corners corners = blend_corners(grid, light, positions_m[r]);
        for (std::size_t line = 0; line < light.lines; ++line) {
            for (std::size_t i = 0; i < 16; ++i) {
                double sum = 0.0;
                for (std::size_t c = 0; c < 8; ++c) {
                    sum += static_cast<double>(corners.weight[c]) *
                           static_cast<double>(light.coefficients[corners.probe[c] * light.lines + line].values[i]);
                }
                out[r * light.lines + line].values[i] = static_cast<float>(sum);
            }
        }
    }
}

} // namespace alpenglow::probes
