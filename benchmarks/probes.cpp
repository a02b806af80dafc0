// Light probes: a full update of a grid and the blending of receivers, by vectorised path and scalar reference.
#include "bench.hpp"

#include <alpenglow/probes/assemble.hpp>
#include <alpenglow/probes/grid.hpp>
#include <alpenglow/probes/update.hpp>
#include <alpenglow/sh/zonal.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

// A clear sky: brighter towards the sun and the horizon, bluer away from them.
ProbeSources clear_sky(int order) {
    ProbeSources sources;
    sources.order = order;
    sources.to_sun = glm::normalize(glm::vec3(0.5F, 0.3F, 0.6F));
    sources.to_moon = glm::normalize(glm::vec3(-0.5F, 0.3F, 0.2F));
    sources.sun_lux = {90000.0F, 80000.0F, 66000.0F};
    sources.moon_lux = {0.1F, 0.1F, 0.1F};
    std::array<double, max_probe_order> dome{};
    sh::zonal_hemisphere(order, 1.0, 0.0, dome);
    sh::add_zonal(order, dome, glm::vec3(0.0F, 0.0F, 1.0F), glm::vec3(2500.0F, 3600.0F, 6000.0F), sources.sky);
    std::array<double, max_probe_order> glow{};
    sh::zonal_cone(order, 0.7, glow);
    sh::add_zonal(order, glow, sources.to_sun, glm::vec3(9000.0F, 9500.0F, 10000.0F), sources.sky);
    return sources;
}

// 10^5 probes over hilly ground: walls of random height all around, shadows, some probes in the ground.
ProbeGrid hills(int order) {
    ProbeGrid grid;
    grid.min_m = {-500.0F, -500.0F, 0.0F};
    grid.max_m = {500.0F, 500.0F, 100.0F};
    grid.count = {100, 100, 10};
    grid.order = order;
    grid.budget = 1000000;
    const std::size_t count = probes::probe_count(grid);
    const auto n = static_cast<std::size_t>(order * order);
    std::mt19937 engine(7);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    std::array<double, max_probe_order> wall{};
    sh::zonal_cone(order, 0.9, wall);
    for (std::size_t p = 0; p < count; ++p) {
        grid.sun_visibility.push_back(std::clamp(2.0F * uniform(engine) - 0.4F, 0.0F, 1.0F));
        grid.moon_visibility.push_back(1.0F);
        grid.albedo.push_back(glm::vec3(0.1F + 0.3F * uniform(engine)));
    }
    grid.occlusion.resize(n * count);
    for (std::size_t p = 0; p < count; ++p) {
        std::array<glm::vec3, max_probe_coefficients> occlusion{};
        const glm::vec3 towards =
            glm::normalize(glm::vec3(uniform(engine) - 0.5F, uniform(engine) - 0.5F, 0.3F + 0.2F * uniform(engine)));
        sh::add_zonal(order, wall, towards, glm::vec3(uniform(engine)), occlusion);
        for (std::size_t i = 0; i < n; ++i) {
            grid.occlusion[i * count + p] = occlusion[i].x;
        }
    }
    return grid;
}

ProbeGridSh made(const ProbeGrid& grid, const ProbeSources& sources) {
    ProbeGridSh light;
    if (!probes::begin_frame(grid, light)) {
        return light;
    }
    std::fill(light.needed.begin(), light.needed.end(), std::uint8_t{1});
    (void)probes::update_grid(grid, light, sources);
    return light;
}

void update(const Context& context) {
    struct Variant {
        const char* name;
        int order;
        Deringing deringing;
        bool occluded;
    };
    const std::array<Variant, 6> variants{{{"order 3, exact, occluded", 3, Deringing::exact, true},
                                           {"order 3, exact, open", 3, Deringing::exact, false},
                                           {"order 3, paper, occluded", 3, Deringing::paper, true},
                                           {"order 3, none, occluded", 3, Deringing::none, true},
                                           {"order 2, exact, occluded", 2, Deringing::exact, true},
                                           {"order 4, none, occluded", 4, Deringing::none, true}}};
    for (const Variant& variant : variants) {
        const ProbeSources sources = clear_sky(variant.order);
        ProbeGrid grid = hills(variant.order);
        grid.deringing = variant.deringing;
        if (!variant.occluded) {
            grid.occlusion.clear();
        }
        ProbeGridSh light = made(grid, sources);
        const std::size_t count = probes::probe_count(grid);
        const auto n = static_cast<std::size_t>(variant.order * variant.order);
        std::vector<std::uint32_t> all(count);
        std::iota(all.begin(), all.end(), 0U);
        const auto reference = [&](std::size_t p) {
            std::array<float, max_probe_coefficients> occlusion{};
            for (std::size_t i = 0; i < n && !grid.occlusion.empty(); ++i) {
                occlusion[i] = grid.occlusion[i * count + p];
            }
            return probes::assemble_reference(variant.order, variant.deringing, sources,
                                              {.sun_visibility = grid.sun_visibility[p],
                                               .moon_visibility = grid.moon_visibility[p],
                                               .albedo = grid.albedo[p],
                                               .occlusion = std::span(occlusion).first(n)});
        };
        double worst = 0.0;
        for (std::size_t p = 0; p < count; p += context.quick() ? 997 : 97) {
            const probes::ProbeCoefficients exact = reference(p);
            double error = 0.0;
            double size = 0.0;
            for (std::size_t i = 0; i < n; ++i) {
                const glm::dvec3 e(exact[i]);
                const glm::dvec3 d = glm::dvec3(probes::coefficient(light, p, static_cast<int>(i))) - e;
                error += glm::dot(d, d);
                size += glm::dot(e, e);
            }
            worst = std::max(worst, std::sqrt(error / size));
        }
        Row row;
        row.module = "probes";
        row.name = std::string("update 1e5 probes, ") + variant.name;
        row.method = "batch";
        row.error = worst;
        row.error_metric = "max relative L2 over probes";
        row.reference = "scalar double";
        row.items = static_cast<double>(count);
        row.bytes = static_cast<double>(probes::memory_bytes(grid));
        context.run(row, [&] { probes::assemble(grid, all, light); });
        row.method = "scalar double";
        row.error = 0.0;
        row.items = 500.0;
        context.run(row, [&] {
            for (std::size_t p = 0; p < 500; ++p) {
                keep(reference(p * 199));
            }
        });
    }
}
const Case update_case("probes/update", update);

void blend(const Context& context) {
    const ProbeGrid grid = hills(3);
    const ProbeGridSh light = made(grid, clear_sky(3));
    constexpr std::size_t receivers = 100000;
    std::mt19937 engine(3);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    std::vector<glm::vec3> anywhere(receivers);
    for (glm::vec3& p : anywhere) {
        p = grid.min_m + glm::vec3(uniform(engine), uniform(engine), uniform(engine)) * (grid.max_m - grid.min_m);
    }
    // In herds: 100 places of 1000 objects each, as a game keeps them.
    std::vector<glm::vec3> herds(receivers);
    for (std::size_t r = 0; r < receivers; ++r) {
        const glm::vec3 centre = anywhere[r / 1000];
        herds[r] = glm::clamp(centre + 20.0F * (glm::vec3(uniform(engine), uniform(engine), uniform(engine)) - 0.5F),
                              grid.min_m, grid.max_m);
    }
    std::vector<ProbeLine> out(receivers * light.lines);
    std::vector<ProbeLine> expected(receivers * light.lines);
    std::vector<ProbeLine> few(512 * light.lines);
    // Of `out`, the worst over receivers and coefficients, relative to the receiver's mean.
    const auto error = [&] {
        double worst = 0.0;
        for (std::size_t r = 0; r < receivers; ++r) {
            const double size = static_cast<double>(expected[r * light.lines].values[0]);
            for (std::size_t i = 0; i < 27; ++i) {
                const std::size_t at = r * light.lines + i / 16;
                worst = std::max(worst, std::abs(static_cast<double>(out[at].values[i % 16]) -
                                                 static_cast<double>(expected[at].values[i % 16])) /
                                            size);
            }
        }
        return worst;
    };
    for (const auto& [name, where] : {std::pair{"anywhere", &anywhere}, std::pair{"in herds", &herds}}) {
        const auto* positions = where; // Clang 14 captures no structured binding
        probes::blend_reference(grid, light, *positions, expected);
        probes::blend(grid, light, *positions, out);
        Row row;
        row.module = "probes";
        row.name = std::string("blend 1e5 receivers, order 3, ") + name;
        row.items = static_cast<double>(receivers);
        row.error_metric = "max over coefficients, relative to the mean";
        row.reference = "scalar double";
        row.bytes = static_cast<double>(light.coefficients.size() * sizeof(ProbeLine));
        row.method = "batch, all to memory";
        row.error = error();
        context.run(row, [&] { probes::blend(grid, light, *positions, out); });
        row.method = "batch, 512 at a time";
        context.run(row, [&] {
            for (std::size_t r = 0; r < receivers; r += 512) {
                probes::blend(grid, light, std::span(*positions).subspan(r, std::min<std::size_t>(512, receivers - r)),
                              few);
            }
        });
        probes::blend_packed(grid, light, *positions, out);
        row.bytes = static_cast<double>(light.packed.size() * sizeof(PackedProbe));
        row.error = error();
        row.method = "packed, all to memory";
        context.run(row, [&] { probes::blend_packed(grid, light, *positions, out); });
        row.method = "packed, 512 at a time";
        context.run(row, [&] {
            for (std::size_t r = 0; r < receivers; r += 512) {
                probes::blend_packed(grid, light,
                                     std::span(*positions).subspan(r, std::min<std::size_t>(512, receivers - r)), few);
            }
        });
        row.method = "scalar double";
        row.error = 0.0;
        row.bytes = static_cast<double>(light.coefficients.size() * sizeof(ProbeLine));
        context.run(row, [&] { probes::blend_reference(grid, light, *positions, expected); });
    }
}
const Case blend_case("probes/blend", blend);

// What a frame costs that has nothing to do.
void standing(const Context& context) {
    ProbeGrid grid = hills(3);
    const ProbeSources sources = clear_sky(3);
    ProbeGridSh light = made(grid, sources);
    std::vector<glm::vec3> receivers;
    for (std::size_t p = 0; p < 1000; ++p) {
        receivers.push_back(probes::probe_position_m(grid, p * 97));
    }
    Row row;
    row.module = "probes";
    row.name = "a frame of 1e5 probes, 1000 receivers";
    row.items = 1.0;
    const auto frame = [&](const ProbeSources& now) {
        (void)probes::begin_frame(grid, light);
        probes::mark_needed(grid, light, receivers);
        keep(probes::update_grid(grid, light, now).updated);
    };
    row.method = "light stands still";
    context.run(row, [&] { frame(sources); });
    ProbeSources other = sources;
    other.to_sun = glm::normalize(sources.to_sun + glm::vec3(0.1F, 0.0F, 0.0F));
    row.method = "light moves past max_error";
    bool turn = false;
    context.run(row, [&] {
        turn = !turn;
        frame(turn ? other : sources);
    });
}
const Case standing_case("probes/frame", standing);

} // namespace
} // namespace alpenglow::bench
