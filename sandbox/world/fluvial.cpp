#include "fluvial.hpp"

#include "noise.hpp"

#include <alpenglow/core/parallel_for.hpp>

#include <cmath>

namespace alpenglow::sandbox {
namespace {

constexpr int step_x[8] = {1, -1, 0, 0, 1, 1, -1, -1};
constexpr int step_y[8] = {0, 0, 1, -1, 1, -1, 1, -1};

// Steepest neighbour below each sample; slopes are weighed by a hash that changes every step.
void find_receivers(const HeightGrid& grid, FluvialModel& model, std::vector<float>& distance_m, int step) {
    const int n = grid.n;
    const float straight = grid.spacing_m;
    const float diagonal = grid.spacing_m * 1.41421356F;
    parallel_for(static_cast<std::size_t>(n), 32, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < n; ++i) {
                const std::size_t here = grid.index(i, j);
                model.receiver[here] = static_cast<std::int32_t>(here);
                distance_m[here] = straight;
                if (model.node[here] == Node::base) {
                    continue;
                }
                const float h = grid.height_m[here];
                std::uint32_t bits = hash_lattice(i, j, model.seed + static_cast<std::uint32_t>(step) * 7919U);
                float best = 0.0F;
                for (int k = 0; k < 8; ++k, bits = (bits >> 4U) | (bits << 28U)) {
                    const int x = i + step_x[k];
                    const int y = j + step_y[k];
                    if (x < 0 || y < 0 || x >= n || y >= n) {
                        continue;
                    }
                    const std::size_t there = grid.index(x, y);
                    const float d = k < 4 ? straight : diagonal;
                    const float slope =
                        (h - grid.height_m[there]) / d * (0.6F + 0.8F / 15.0F * static_cast<float>(bits & 15U));
                    if (slope > best) {
                        best = slope;
                        model.receiver[here] = static_cast<std::int32_t>(there);
                        distance_m[here] = d;
                    }
                }
            }
        }
    });
}

// Orders samples so that each comes after its receiver.
void order_downstream_first(const std::vector<std::int32_t>& receiver, std::vector<std::int32_t>& first_donor,
                            std::vector<std::int32_t>& next_donor, std::vector<std::int32_t>& order) {
    const auto count = static_cast<std::int32_t>(receiver.size());
    std::fill(first_donor.begin(), first_donor.end(), -1);
    order.clear();
    for (std::int32_t i = count - 1; i >= 0; --i) {
        const auto r = static_cast<std::size_t>(receiver[static_cast<std::size_t>(i)]);
        if (static_cast<std::int32_t>(r) == i) {
            order.push_back(i);
        } else {
            next_donor[static_cast<std::size_t>(i)] = first_donor[r];
            first_donor[r] = i;
        }
    }
    for (std::size_t read = 0; read < order.size(); ++read) {
        for (std::int32_t d = first_donor[static_cast<std::size_t>(order[read])]; d >= 0;
             d = next_donor[static_cast<std::size_t>(d)]) {
            order.push_back(d);
        }
    }
}

} // namespace

void erode(HeightGrid& grid, FluvialModel& model, int steps) {
    const std::size_t count = grid.height_m.size();
    model.receiver.assign(count, 0);
    model.area_m2.assign(count, 0.0F);
    std::vector<float> distance_m(count);
    std::vector<std::int32_t> first_donor(count);
    std::vector<std::int32_t> next_donor(count);
    std::vector<std::int32_t> order;
    order.reserve(count);
    const float cell_m2 = grid.spacing_m * grid.spacing_m;
    for (int step = 0; step < steps; ++step) {
        find_receivers(grid, model, distance_m, step);
        order_downstream_first(model.receiver, first_donor, next_donor, order);

        for (std::size_t i = 0; i < count; ++i) {
            model.area_m2[i] = cell_m2 + (model.inflow_m2.empty() ? 0.0F : model.inflow_m2[i]);
        }
        for (std::size_t k = order.size(); k-- > 0;) {
            const auto i = static_cast<std::size_t>(order[k]);
            const auto r = static_cast<std::size_t>(model.receiver[i]);
            if (r != i) {
                model.area_m2[r] += model.area_m2[i];
            }
        }

        for (const std::int32_t sample : order) {
            const auto i = static_cast<std::size_t>(sample);
            if (model.node[i] != Node::free) {
                continue;
            }
            const auto r = static_cast<std::size_t>(model.receiver[i]);
            float& h = grid.height_m[i];
            h += model.uplift_m[i];
            if (r == i) {
                continue; // a pit rises until it spills
            }
            const float f = model.erodibility * std::sqrt(model.area_m2[i]) / distance_m[i];
            const float downstream = grid.height_m[r];
            h = (h + f * downstream) / (1.0F + f);
            h = std::min(h, downstream + model.talus[i] * distance_m[i]);
        }
    }
}

} // namespace alpenglow::sandbox
