#include <alpenglow/probes/assemble.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/product.hpp>
#include <alpenglow/sh/zonal.hpp>

#include <alpenglow/probes/grid.hpp>

#include "dering_rows.hpp"
#include "grid_steps.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::probes {

namespace {

constexpr std::size_t chunk = dering_rows_at_most; // probes in one go: 27 rows of them fit the first-level cache

// A mean below this share of the sky's norm is what is left of cutting off the bands of the product of sky and
// occlusion, not light: such a channel is dark. One that deringing took for light of negative mean would put out the
// others with it.
constexpr double dark_below = 1e-4;

// Irradiance of a coefficient of 1 in band 0.
const double mean_irradiance = 0.5 * std::sqrt(pi);

std::size_t size_of(int order) {
    return static_cast<std::size_t>(sh::coefficient_count(order));
}

// Irradiance of level ground: the dot product of these with the coefficients of m = 0, by band.
std::array<double, max_probe_order> ground_factors(int order) {
    std::array<double, max_probe_order> factors{};
    for (int l = 0; l < order; ++l) {
        factors[static_cast<std::size_t>(l)] = sh::cosine_factor(l) * std::sqrt((2.0 * l + 1.0) / (4.0 * pi));
    }
    return factors;
}

// Where the ground is seen unless something stands before the sky: the lower hemisphere.
std::array<double, max_probe_order> ground_zonal(int order, const ProbeSources& sources) {
    std::array<double, max_probe_order> zonal{};
    if (!sources.whole_sphere) {
        sh::zonal_hemisphere(order, 0.0, 1.0, zonal);
    }
    return zonal;
}

std::array<double, max_probe_order> punctual_zonal(int order, Deringing deringing) {
    std::array<double, max_probe_order> zonal{};
    sh::zonal_delta(order, zonal);
    if (deringing == Deringing::none) {
        return zonal;
    }
    if (deringing == Deringing::paper) {
        for (std::size_t l = 0; l < sh::punctual_window.size(); ++l) {
            zonal[l] *= sh::punctual_window[l];
        }
    }
    std::array<double, max_probe_coefficients> light{};
    for (int l = 0; l < order; ++l) {
        light[static_cast<std::size_t>(sh::index(l, 0))] = zonal[static_cast<std::size_t>(l)];
    }
    const sh::Dering window =
        sh::find_window(order, std::span(light).first(size_of(order)), dering_options(deringing, order));
    for (std::size_t l = 0; l < static_cast<std::size_t>(order); ++l) {
        zonal[l] *= window.factors[l];
    }
    return zonal;
}

// Illuminance of level ground by sun and moon, without what may stand before them.
struct GroundLux {
    glm::dvec3 sun, moon;
};
GroundLux ground_lux(const ProbeSources& sources) {
    return {glm::dvec3(sources.sun_lux) * std::max(0.0, static_cast<double>(sources.to_sun.z)),
            glm::dvec3(sources.moon_lux) * std::max(0.0, static_cast<double>(sources.to_moon.z))};
}

// An occlusion stands on the upper hemisphere alone, which its bands cannot say: cut at a low order, 1 - O leaves light
// even where the whole sky is hidden. Mirrored at the horizon it hides the same of a sky that has nothing below, and a
// covered sky is the constant 1, whose product is exact. Coefficients odd in z vanish, even ones double.
constexpr bool even_in_z(int l, int m) {
    return (l + m) % 2 == 0;
}

// The sky without the bands that the sources lack.
ProbeCoefficients sky_of(const ProbeSources& sources, int order) {
    ProbeCoefficients sky{};
    std::copy_n(sources.sky.begin(), size_of(std::min(order, sources.order)), sky.begin());
    return sky;
}

double norm(std::span<const glm::vec3> c) {
    double sum = 0.0;
    for (const glm::vec3& v : c) {
        sum += glm::dot(glm::dvec3(v), glm::dvec3(v));
    }
    return std::sqrt(sum);
}
glm::dvec3 channel_norms(std::span<const glm::vec3> c) {
    glm::dvec3 sum(0.0);
    for (const glm::vec3& v : c) {
        sum += glm::dvec3(v) * glm::dvec3(v);
    }
    return {std::sqrt(sum.x), std::sqrt(sum.y), std::sqrt(sum.z)};
}
ProbeCoefficients difference(const ProbeCoefficients& a, const ProbeCoefficients& b) {
    ProbeCoefficients out{};
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = a[i] - b[i];
    }
    return out;
}

// Per channel: what all changes below are measured by.
glm::dvec3 reference_norms(const ProbeCoefficients& sky, const DirectLight& direct) {
    return channel_norms(sky) + channel_norms(direct.sun) + channel_norms(direct.moon);
}

double total_norm(const ProbeCoefficients& sky, const DirectLight& direct) {
    return norm(sky) + norm(direct.sun) + norm(direct.moon);
}

// One array of a chunk: a row is `chunk` floats.
struct Rows {
    std::vector<ProbeLine> lines;
    explicit Rows(std::size_t rows) : lines(rows * chunk / 16) {}
    float* row(std::size_t i) { return lines.data()->values.data() + i * chunk; }
    sh::Batch batch(std::size_t first, std::size_t count) { return {row(first), count, chunk}; }
};

} // namespace

bool usable(const ProbeSources& sources) noexcept {
    const auto finite = [](const glm::vec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    const auto unit = [&](const glm::vec3& v) { return finite(v) && std::abs(glm::dot(v, v) - 1.0F) < 1e-3F; };
    return sources.order >= 0 && sources.order <= max_probe_order && unit(sources.to_sun) && unit(sources.to_moon) &&
           finite(sources.sun_lux) && finite(sources.moon_lux) &&
           std::all_of(sources.sky.begin(), sources.sky.end(), finite);
}

DirectLight direct_light(int order, Deringing deringing, const ProbeSources& sources) {
    const std::array<double, max_probe_order> zonal = punctual_zonal(order, deringing);
    std::array<glm::dvec3, max_probe_coefficients> sun{};
    std::array<glm::dvec3, max_probe_coefficients> moon{};
    sh::add_zonal(order, zonal, glm::dvec3(sources.to_sun), glm::dvec3(sources.sun_lux), sun);
    sh::add_zonal(order, zonal, glm::dvec3(sources.to_moon), glm::dvec3(sources.moon_lux), moon);
    DirectLight light;
    for (std::size_t i = 0; i < size_of(order); ++i) {
        light.sun[i] = glm::vec3(sun[i]);
        light.moon[i] = glm::vec3(moon[i]);
    }
    return light;
}

ProbeCoefficients assemble_reference(int order, Deringing deringing, const ProbeSources& sources,
                                     const ProbeInput& input) {
    assert(order >= 1 && order <= max_probe_order);
    const std::size_t n = size_of(order);
    const ProbeCoefficients sky = sky_of(sources, order);
    const DirectLight direct = direct_light(order, deringing, sources);
    const GroundLux lux = ground_lux(sources);
    const double sun = static_cast<double>(input.sun_visibility);
    const double moon = static_cast<double>(input.moon_visibility);
    std::vector<double> channels(3 * n);
    for (int c = 0; c < 3; ++c) {
        const std::span<double> out(channels.data() + static_cast<std::size_t>(c) * n, n);
        if (!input.indirect.empty()) {
            for (std::size_t i = 0; i < n; ++i) {
                out[i] = static_cast<double>(input.indirect[i][c]);
            }
            continue;
        }
        std::vector<double> open(n);
        std::vector<double> blocked(n, 0.0);
        std::vector<double> product(n, 0.0);
        for (std::size_t i = 0; i < n; ++i) {
            open[i] = static_cast<double>(sky[i][c]);
            blocked[i] = input.occlusion.empty() ? 0.0 : static_cast<double>(input.occlusion[i]);
        }
        std::vector<double> hidden(blocked);
        for (int l = 0; l < order && !sources.whole_sphere; ++l) {
            for (int m = -l; m <= l; ++m) {
                hidden[static_cast<std::size_t>(sh::index(l, m))] *= even_in_z(l, m) ? 2.0 : 0.0;
            }
        }
        sh::product(order, open, hidden, product);
        double lit = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            out[i] = open[i] - product[i];
        }
        for (int l = 0; l < order; ++l) {
            lit += ground_factors(order)[static_cast<std::size_t>(l)] * out[static_cast<std::size_t>(sh::index(l, 0))];
        }
        lit = std::max(lit, 0.0) + sun * lux.sun[c] + moon * lux.moon[c];
        const double ground = static_cast<double>(input.albedo[c]) / pi * lit;
        const std::array<double, max_probe_order> lower = ground_zonal(order, sources);
        for (int l = 0; l < order; ++l) {
            blocked[static_cast<std::size_t>(sh::index(l, 0))] += lower[static_cast<std::size_t>(l)];
        }
        for (std::size_t i = 0; i < n; ++i) {
            out[i] += ground * blocked[i];
        }
    }
    if (input.indirect.empty()) {
        for (int c = 0; c < 3; ++c) {
            const std::span<double> out(channels.data() + static_cast<std::size_t>(c) * n, n);
            if (out[0] <= dark_below * channel_norms(sky)[c]) {
                std::fill(out.begin(), out.end(), 0.0);
            }
        }
    }
    if (deringing != Deringing::none) {
        sh::apply_dering(order, sh::find_window(order, channels, dering_options(deringing, order)), channels, channels);
    }
    ProbeCoefficients result{};
    for (std::size_t i = 0; i < n; ++i) {
        for (int c = 0; c < 3; ++c) {
            result[i][c] = static_cast<float>(channels[static_cast<std::size_t>(c) * n + i] +
                                              sun * static_cast<double>(direct.sun[i][c]) +
                                              moon * static_cast<double>(direct.moon[i][c]));
        }
    }
    return result;
}

namespace {

// What is the same for all probes of a call.
struct Shared {
    int order = 3;
    std::size_t n = 9;
    bool whole_sphere = false;
    ProbeCoefficients sky{};
    DirectLight direct;
    GroundLux lux;
    std::array<float, max_probe_order> ground_factor{}, ground{};
    glm::vec3 dark_floor{0.0F};
    glm::vec3 inverse_reference{0.0F}; // per channel, of the mean irradiance of a mean of 1
    float inverse_total = 0.0F;
};

float inverse(double v) {
    return v > 1e-36 ? static_cast<float>(1.0 / v) : 0.0F;
}

Shared make_shared(int order, Deringing deringing, const ProbeSources& sources) {
    Shared shared;
    shared.order = order;
    shared.n = size_of(order);
    shared.whole_sphere = sources.whole_sphere;
    shared.sky = sky_of(sources, order);
    shared.direct = direct_light(order, deringing, sources);
    shared.lux = ground_lux(sources);
    for (std::size_t l = 0; l < static_cast<std::size_t>(order); ++l) {
        shared.ground_factor[l] = static_cast<float>(ground_factors(order)[l]);
        shared.ground[l] = static_cast<float>(ground_zonal(order, sources)[l]);
    }
    const glm::dvec3 reference = reference_norms(shared.sky, shared.direct);
    const glm::dvec3 sky = channel_norms(shared.sky);
    for (int c = 0; c < 3; ++c) {
        shared.dark_floor[c] = static_cast<float>(dark_below * sky[c]);
        shared.inverse_reference[c] = inverse(reference[c] / mean_irradiance);
    }
    shared.inverse_total = inverse(total_norm(shared.sky, shared.direct));
    return shared;
}

// A chunk's probes as rows.
struct Chunk {
    explicit Chunk(const Shared& shared)
        : light(3 * shared.n), blocked(shared.n), hidden(shared.n), product(shared.n), sky(3 * shared.n), input(5) {
        for (std::size_t i = 0; i < 3 * shared.n; ++i) {
            std::fill_n(sky.row(i), chunk, shared.sky[i % shared.n][static_cast<int>(i / shared.n)]);
        }
    }
    Rows light;   // channel by channel
    Rows blocked; // occlusion
    Rows hidden;  // the same, mirrored at the horizon
    Rows product;
    Rows sky;   // the same for all: product() wants rows
    Rows input; // visibility of sun and moon, albedo
    std::array<float, chunk> window{};
    std::array<bool, chunk> unusable{};
};

void gather(const ProbeGrid& grid, std::span<const std::uint32_t> probes, std::size_t n, Chunk& work) {
    const std::size_t total = probe_count(grid);
    float* const sun = work.input.row(0);
    float* const moon = work.input.row(1);
    work.unusable.fill(false);
    for (std::size_t k = 0; k < probes.size(); ++k) {
        const std::size_t p = probes[k];
        sun[k] = visibility(grid.sun_visibility, p);
        moon[k] = visibility(grid.moon_visibility, p);
        const glm::vec3 albedo = grid.albedo.empty() ? grid.ground_albedo : grid.albedo[p];
        work.unusable[k] = !(albedo_component(albedo.x) && albedo_component(albedo.y) && albedo_component(albedo.z));
        for (int c = 0; c < 3; ++c) {
            work.input.row(static_cast<std::size_t>(2 + c))[k] = work.unusable[k] ? 0.0F : albedo[c];
        }
    }
    if (grid.occlusion.empty()) {
        return;
    }
    const bool run = probes.back() - probes.front() + 1 == probes.size();
    for (std::size_t i = 0; i < n; ++i) {
        const float* const from = grid.occlusion.data() + i * total;
        float* const to = work.blocked.row(i);
        if (run) {
            std::copy_n(from + probes.front(), probes.size(), to);
        } else {
            std::transform(probes.begin(), probes.end(), to, [&](std::uint32_t p) { return from[p]; });
        }
        for (std::size_t k = 0; k < probes.size(); ++k) {
            const bool usable = occlusion_coefficient(to[k]);
            work.unusable[k] |= !usable;
            to[k] = usable ? to[k] : 0.0F;
        }
    }
}

// Sky and bounce of a chunk. Loops over whole rows: the compiler vectorises them.
void assemble_indirect(const Shared& shared, bool occluded, std::size_t count, Chunk& work) {
    for (int l = 0; occluded && l < shared.order; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(sh::index(l, m));
            const float factor = shared.whole_sphere ? 1.0F : even_in_z(l, m) ? 2.0F : 0.0F;
            const float* const from = work.blocked.row(i);
            std::transform(from, from + chunk, work.hidden.row(i), [factor](float v) { return factor * v; });
        }
    }
    for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        const std::size_t first = channel * shared.n;
        if (occluded) {
            sh::product(shared.order, work.sky.batch(first, count), work.hidden.batch(0, count),
                        work.product.batch(0, count));
        }
        std::array<float, chunk> lit{};
        for (std::size_t i = 0; i < shared.n; ++i) {
            float* const out = work.light.row(first + i);
            const float* const blocked = work.product.row(i);
            const float sky = shared.sky[i][c];
            for (std::size_t k = 0; k < chunk; ++k) {
                out[k] = occluded ? sky - blocked[k] : sky;
            }
        }
        for (int l = 0; l < shared.order; ++l) {
            const float factor = shared.ground_factor[static_cast<std::size_t>(l)];
            const float* const zonal = work.light.row(first + static_cast<std::size_t>(sh::index(l, 0)));
            for (std::size_t k = 0; k < chunk; ++k) {
                lit[k] += factor * zonal[k];
            }
        }
        const float sun_lux = static_cast<float>(shared.lux.sun[c]);
        const float moon_lux = static_cast<float>(shared.lux.moon[c]);
        const float* const sun = work.input.row(0);
        const float* const moon = work.input.row(1);
        const float* const albedo = work.input.row(2 + channel);
        for (std::size_t k = 0; k < chunk; ++k) {
            const float sky_lux = std::max(lit[k], 0.0F);
            lit[k] = albedo[k] * static_cast<float>(1.0 / pi) * (sky_lux + sun[k] * sun_lux + moon[k] * moon_lux);
        }
        for (int l = 0; l < shared.order; ++l) {
            const float ground = shared.ground[static_cast<std::size_t>(l)];
            float* const zonal = work.light.row(first + static_cast<std::size_t>(sh::index(l, 0)));
            for (std::size_t k = 0; k < chunk; ++k) {
                zonal[k] += ground * lit[k];
            }
        }
        if (occluded) {
            for (std::size_t i = 0; i < shared.n; ++i) {
                float* const out = work.light.row(first + i);
                const float* const blocked = work.blocked.row(i);
                for (std::size_t k = 0; k < chunk; ++k) {
                    out[k] += lit[k] * blocked[k];
                }
            }
        }
    }
}

void add_direct(const Shared& shared, Chunk& work) {
    const float* const sun = work.input.row(0);
    const float* const moon = work.input.row(1);
    for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < shared.n; ++i) {
            float* const out = work.light.row(static_cast<std::size_t>(c) * shared.n + i);
            const float by_sun = shared.direct.sun[i][c];
            const float by_moon = shared.direct.moon[i][c];
            for (std::size_t k = 0; k < chunk; ++k) {
                out[k] += sun[k] * by_sun + moon[k] * by_moon;
            }
        }
    }
}

void take_captured(std::span<const glm::vec3> captured, std::size_t count, std::size_t n, Chunk& work) {
    for (std::size_t k = 0; k < count; ++k) {
        const std::span<const glm::vec3> from = captured.subspan(k * n, n);
        bool finite = true;
        for (const glm::vec3& v : from) {
            finite = finite && std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
        }
        work.unusable[k] |= !finite;
        for (std::size_t i = 0; i < n; ++i) {
            for (int c = 0; c < 3; ++c) {
                work.light.row(static_cast<std::size_t>(c) * n + i)[k] = finite ? from[i][c] : 0.0F;
            }
        }
    }
}

// Rows -> cache lines, one probe after the other.
void scatter(std::span<const std::uint32_t> probes, Chunk& work, ProbeGridSh& light) {
    const auto n = static_cast<std::size_t>(light.order * light.order);
    std::array<const float*, 3 * max_probe_coefficients> rows{};
    for (std::size_t i = 0; i < 3 * n; ++i) {
        rows[i] = work.light.row(i % 3 * n + i / 3);
    }
    for (std::size_t k = 0; k < probes.size(); ++k) {
        const std::size_t p = probes[k];
        float* const out = light.coefficients[p * light.lines].values.data();
        const bool usable = !work.unusable[k] && !std::isnan(work.window[k]);
        for (std::size_t i = 0; i < 3 * n; ++i) {
            out[i] = usable ? rows[i][k] : 0.0F;
        }
        light.window[p] = usable ? work.window[k] : std::numeric_limits<float>::quiet_NaN();
        light.made_pass[p] = light.pass;
        light.made_sun_visibility[p] = work.input.row(0)[k];
        light.made_moon_visibility[p] = work.input.row(1)[k];
    }
}

// docs/probes.md: how much the window of deringing may add to a relative change of its input.
constexpr double dering_slope = 2.33;

// Puts out channels whose mean is not light, and returns the greatest dering gain among the chunk's probes:
// |f'| / min_k (E_k / r_k), f' all bands but the mean, E the mean irradiance of a channel, r its reference.
double prepare_dering(const Shared& shared, bool assembled, std::size_t count, Chunk& work) {
    std::array<float, chunk> bands{};
    std::array<float, chunk> relative{};
    relative.fill(std::numeric_limits<float>::max());
    for (int c = 0; c < 3; ++c) {
        const std::size_t first = static_cast<std::size_t>(c) * shared.n;
        const float* const mean = work.light.row(first);
        if (assembled) {
            const float floor = shared.dark_floor[c];
            std::array<float, chunk> keep;
            for (std::size_t k = 0; k < chunk; ++k) {
                keep[k] = mean[k] > floor ? 1.0F : 0.0F;
            }
            for (std::size_t i = 0; i < shared.n; ++i) {
                float* const out = work.light.row(first + i);
                for (std::size_t k = 0; k < chunk; ++k) {
                    out[k] *= keep[k];
                }
            }
        }
        const float scale = shared.inverse_reference[c];
        for (std::size_t k = 0; k < chunk; ++k) {
            const float share = mean[k] * scale; // NaN-free: 0 where the channel has no light at all
            relative[k] = share > 0.0F ? std::min(relative[k], share) : relative[k];
        }
        for (std::size_t i = 1; i < shared.n; ++i) {
            const float* const row = work.light.row(first + i);
            for (std::size_t k = 0; k < chunk; ++k) {
                const float v = row[k] * shared.inverse_total;
                bands[k] += v * v;
            }
        }
    }
    double worst = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
        if (bands[k] > 0.0F) {
            worst = std::max(worst, static_cast<double>(bands[k]) /
                                        (static_cast<double>(relative[k]) * static_cast<double>(relative[k])));
        }
    }
    return std::sqrt(worst);
}

} // namespace

void assemble(const ProbeGrid& grid, std::span<const std::uint32_t> probes, ProbeGridSh& light,
              std::span<const glm::vec3> indirect) {
    assert(light.grid_revision == grid.revision && light.order == grid.order);
    const Shared shared = make_shared(grid.order, grid.deringing, light.target);
    assert(indirect.empty() || indirect.size() == probes.size() * shared.n);
    Chunk work(shared);
    for (std::size_t start = 0; start < probes.size(); start += chunk) {
        const std::span<const std::uint32_t> here = probes.subspan(start, std::min(chunk, probes.size() - start));
        gather(grid, here, shared.n, work);
        if (indirect.empty()) {
            assemble_indirect(shared, !grid.occlusion.empty(), here.size(), work);
        } else {
            take_captured(indirect.subspan(start * shared.n, here.size() * shared.n), here.size(), shared.n, work);
        }
        const double gain = prepare_dering(shared, indirect.empty(), here.size(), work);
        dering_rows(shared.order, grid.deringing, work.light.batch(0, here.size()),
                    std::span(work.window).first(here.size()));
        add_direct(shared, work);
        if (grid.deringing != Deringing::none) {
            light.dering_gain = std::max(light.dering_gain, dering_slope * gain);
        }
        scatter(here, work, light);
    }
    pack(light, probes);
}

DriftBound drift_bound(const ProbeGrid& grid, const ProbeGridSh& light, const ProbeSources& now) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const ProbeCoefficients sky = sky_of(now, grid.order);
    const DirectLight direct = direct_light(grid.order, grid.deringing, now);
    const double total = total_norm(sky, direct);
    if (light.pass == 0 || now.whole_sphere != light.target.whole_sphere) {
        return {infinity, infinity, infinity};
    }
    const ProbeCoefficients sky_change = difference(sky, sky_of(light.target, grid.order));
    const DirectLight old = direct_light(grid.order, grid.deringing, light.target);
    const double direct_change = norm(difference(direct.sun, old.sun)) + norm(difference(direct.moon, old.moon));
    const glm::dvec3 sky_by_channel = channel_norms(sky_change);
    // The gain through deringing was found against the light that the probes were made from.
    const ProbeCoefficients sky_before = sky_of(light.target, grid.order);
    const glm::dvec3 reference = reference_norms(sky_before, old);
    const double total_before = total_norm(sky_before, old);
    const GroundLux lux = ground_lux(now);
    const GroundLux lux_before = ground_lux(light.target);
    double ground_norm = 0.0;
    for (const double f : ground_factors(grid.order)) {
        ground_norm += f * f;
    }
    ground_norm = std::sqrt(ground_norm);

    double indirect_squared = 0.0;
    double by_sun = 0.0;
    double by_moon = 0.0;
    double greatest_share = 0.0; // of a channel's change in its reference
    for (int c = 0; c < 3; ++c) {
        const double bounce = light.ground_gain[c];
        const double ground_change = ground_norm * light.sky_gain * sky_by_channel[c] +
                                     std::abs(lux.sun[c] - lux_before.sun[c]) +
                                     std::abs(lux.moon[c] - lux_before.moon[c]);
        const double change = light.sky_gain * sky_by_channel[c] + bounce * ground_change;
        indirect_squared += change * change;
        by_sun += bounce * bounce * lux.sun[c] * lux.sun[c];
        by_moon += bounce * bounce * lux.moon[c] * lux.moon[c];
        if (change > 0.0) {
            greatest_share = std::max(greatest_share, reference[c] > 0.0 ? change / reference[c] : infinity);
        }
    }
    by_sun = std::sqrt(by_sun);
    by_moon = std::sqrt(by_moon);
    const auto relative = [&](double change) { return change == 0.0 ? 0.0 : total > 0.0 ? change / total : infinity; };
    const double gain = light.dering_gain;
    const auto dering = [&](double share) {
        return share == 0.0 || gain == 0.0 ? 0.0 : relative(gain * share * total_before);
    };
    // A change of a visibility moves the bounce of one probe: its share in a channel is at most that of the whole.
    const auto share_of = [&](const glm::dvec3& lux_of) {
        double share = 0.0;
        for (int c = 0; c < 3; ++c) {
            if (reference[c] > 0.0) {
                share = std::max(share, light.ground_gain[c] * lux_of[c] / reference[c]);
            }
        }
        return share;
    };
    return {relative(direct_change + std::sqrt(indirect_squared)) + dering(greatest_share),
            relative(norm(direct.sun) + by_sun) + dering(share_of(lux.sun)),
            relative(norm(direct.moon) + by_moon) + dering(share_of(lux.moon))};
}

} // namespace alpenglow::probes
