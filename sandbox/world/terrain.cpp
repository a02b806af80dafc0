#include "terrain.hpp"

#include "fluvial.hpp"
#include "noise.hpp"

#include <alpenglow/core/parallel_for.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <cmath>
#include <limits>

namespace alpenglow::sandbox {
namespace {

float smoothstep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
    return t * t * (3.0F - 2.0F * t);
}

constexpr glm::vec2 lake_centre_m{-2300.0F, 250.0F};

// What is given before erosion: the main valley from west to east through the middle (its floor falls eastward), a side
// valley that joins it from the south, and lowlands beyond the ranges in the north. Water leaves the model there.
struct Framework {
    float floor_m = 0.0F;    // height of the nearest floor
    float distance_m = 0.0F; // to its edge, negative on the floor
};

float valley_line_m(float x) {
    return 900.0F * std::sin(x / 5200.0F) + 1700.0F * std::sin(x / 17000.0F + 1.0F) - 1430.0F;
}

// Distance south of the lowlands' edge; only its bound from below where it is more than both 9 km and `other_m`.
float north_distance_m(glm::vec2 p, float other_m, std::uint32_t seed) {
    const float least_m = 25000.0F - p.y; // the noise is within -1 .. 1
    return least_m > std::max(other_m, 9000.0F)
               ? least_m
               : 30000.0F + 5000.0F * gradient_noise(p.x / 22000.0F, 0.5F, seed + 12U) - p.y;
}

// Relative uplift of the ranges.
float uplift(glm::vec2 p, std::uint32_t seed) {
    const float ranges = 1.0F + 0.45F * fractal_noise(p.x / 16000.0F, p.y / 16000.0F, 2, seed + 14U);
    const float main_crest = smoothstep(2000.0F, -22000.0F, p.y); // higher in the south
    const float hills = smoothstep(0.0F, 9000.0F, north_distance_m(p, 0.0F, seed));
    return ranges * (0.9F + 0.45F * main_crest) * (0.35F + 0.65F * hills);
}

Framework framework(glm::vec2 p, std::uint32_t seed) {
    Framework f;
    const float wobble = 350.0F * gradient_noise(p.x / 2600.0F, p.y / 2600.0F, seed + 11U);
    const float line = valley_line_m(p.x);
    const float slope = 900.0F / 5200.0F * std::cos(p.x / 5200.0F);
    const float main_m = std::abs(p.y - line) / std::sqrt(1.0F + slope * slope) - 1050.0F + wobble;
    f.floor_m = 590.0F - 0.0016F * p.x;
    f.distance_m = main_m;
    // Side valley: narrower, climbing to the south.
    const float south_m = line - p.y;
    if (south_m > 0.0F && south_m < 34000.0F) {
        const float centre = 5200.0F + 1500.0F * std::sin(south_m / 6500.0F + 0.6F);
        const float half = std::max(60.0F, 430.0F - 0.012F * south_m);
        const float side_m = std::abs(p.x - centre) - half + 0.4F * wobble;
        if (side_m < f.distance_m) {
            f.distance_m = side_m;
            f.floor_m = 590.0F - 0.0016F * p.x + 0.026F * south_m;
        }
    }
    // A second main valley, in the south.
    const float second_m = std::abs(p.y + 36000.0F - 2500.0F * std::sin(p.x / 9000.0F)) - 700.0F + wobble;
    if (second_m < f.distance_m) {
        f.distance_m = second_m;
        f.floor_m = 780.0F + 0.003F * p.x;
    }
    // Lowlands in the north.
    const float north_m = north_distance_m(p, f.distance_m, seed);
    if (north_m < f.distance_m) {
        f.distance_m = north_m;
        f.floor_m = 640.0F + 60.0F * fractal_noise(p.x / 5000.0F, p.y / 5000.0F, 3, seed + 13U);
    }
    return f;
}

FluvialModel make_model(const HeightGrid& grid, std::uint32_t seed) {
    FluvialModel model;
    const std::size_t count = grid.height_m.size();
    model.node.assign(count, Node::free);
    model.uplift_m.assign(count, 0.0F);
    model.talus.assign(count, 1.0F);
    model.seed = seed;
    parallel_for(static_cast<std::size_t>(grid.n), 16, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < grid.n; ++i) {
                const std::size_t k = grid.index(i, j);
                const glm::vec2 p = grid.position_m(i, j);
                model.uplift_m[k] = uplift(p, seed);
                model.talus[k] = 0.84F + 0.30F * gradient_noise(p.x / 1900.0F, p.y / 1900.0F, seed + 21U);
                if (framework(p, seed).distance_m < 0.0F) {
                    model.node[k] = Node::base;
                }
            }
        }
    });
    return model;
}

// Fixes what must not move: floors at their height, the border of the square where it is.
void pin_outer(HeightGrid& grid, FluvialModel& model, std::uint32_t seed) {
    for (int j = 0; j < grid.n; ++j) {
        for (int i = 0; i < grid.n; ++i) {
            const std::size_t k = grid.index(i, j);
            if (model.node[k] == Node::base) {
                grid.height_m[k] = framework(grid.position_m(i, j), seed).floor_m;
            } else if (i == 0 || j == 0 || i == grid.n - 1 || j == grid.n - 1) {
                model.node[k] = Node::base;
                grid.height_m[k] = 900.0F;
            }
        }
    }
}

// Bends straight streams that follow the grid: where the coarser level is looked up for a point of the finer one.
glm::vec2 bend(glm::vec2 p, float wavelength_m, std::uint32_t seed) {
    const float amplitude_m = 0.22F * wavelength_m;
    return p + amplitude_m * glm::vec2(gradient_noise(p.x / wavelength_m, p.y / wavelength_m, seed + 51U),
                                       gradient_noise(p.x / wavelength_m, p.y / wavelength_m, seed + 52U));
}

// Samples `coarse` on a finer grid; wavelength_m > 0 bends.
HeightGrid refine(const HeightGrid& coarse, int n, float spacing_m, float jitter_m, float wavelength_m,
                  std::uint32_t seed) {
    HeightGrid fine = make_grid(n, spacing_m);
    parallel_for(static_cast<std::size_t>(n), 16, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < n; ++i) {
                const glm::vec2 p = fine.position_m(i, j);
                fine.height_m[fine.index(i, j)] =
                    sample_cubic(coarse, wavelength_m > 0.0F ? bend(p, wavelength_m, seed) : p) +
                    jitter_m * (hash_unit(i, j, seed) - 0.5F);
            }
        }
    });
    return fine;
}

// Rock, scree and turf below the scale that rivers shape: ridged noise on steep and high ground, little on floors.
float detail_m(glm::vec2 p, float height_m, float slope, float floor_distance_m, bool fine, std::uint32_t seed) {
    const float steep = smoothstep(0.25F, 0.9F, slope);
    const float high = smoothstep(1300.0F, 2200.0F, height_m);
    const float off_floor = smoothstep(-50.0F, 700.0F, floor_distance_m);
    const float warp_x = 60.0F * gradient_noise(p.x / 310.0F, p.y / 310.0F, seed + 31U);
    const float warp_y = 60.0F * gradient_noise(p.x / 310.0F, p.y / 310.0F, seed + 32U);
    const float x = (p.x + warp_x) / 520.0F;
    const float y = (p.y + warp_y) / 520.0F;
    const float crags = ridged_noise(x, y, fine ? 5 : 2, seed + 33U) - 0.55F;
    const float rolling = fractal_noise(p.x / 420.0F, p.y / 420.0F, fine ? 4 : 1, seed + 34U);
    return off_floor * (crags * (12.0F + 120.0F * steep * (0.35F + 0.65F * high)) + rolling * (18.0F + 14.0F * high));
}

void add_detail(HeightGrid& grid, std::uint32_t seed, bool fine) {
    const HeightGrid smooth = grid;
    parallel_for(static_cast<std::size_t>(grid.n), 8, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < grid.n; ++i) {
                const float dx = smooth.at_clamped(i + 2, j) - smooth.at_clamped(i - 2, j);
                const float dy = smooth.at_clamped(i, j + 2) - smooth.at_clamped(i, j - 2);
                const float slope = std::sqrt(dx * dx + dy * dy) / (4.0F * grid.spacing_m);
                const glm::vec2 p = grid.position_m(i, j);
                const Framework f = framework(p, seed);
                grid.height_m[grid.index(i, j)] += detail_m(p, smooth.at(i, j), slope, f.distance_m, fine, seed);
            }
        }
    });
}

// One pass of a 3 x 3 binomial filter, mixed in by `amount`.
void soften(HeightGrid& grid, float amount) {
    const HeightGrid source = grid;
    parallel_for(static_cast<std::size_t>(grid.n), 16, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < grid.n; ++i) {
                float sum = 0.0F;
                for (int dj = -1; dj <= 1; ++dj) {
                    for (int di = -1; di <= 1; ++di) {
                        const float weight = static_cast<float>((2 - std::abs(di)) * (2 - std::abs(dj)));
                        sum += weight * source.at_clamped(i + di, j + dj);
                    }
                }
                float& h = grid.height_m[grid.index(i, j)];
                h += amount * (sum / 16.0F - h);
            }
        }
    });
}

void dig_lake(HeightGrid& grid) {
    for (int j = 0; j < grid.n; ++j) {
        for (int i = 0; i < grid.n; ++i) {
            const float d = lake_distance_m(grid.position_m(i, j));
            if (d < 220.0F) {
                float& h = grid.height_m[grid.index(i, j)];
                h = d < 0.0F ? lake_height_m() : glm::mix(lake_height_m(), h, smoothstep(-30.0F, 220.0F, d));
            }
        }
    }
}

constexpr float erodibility_per_step = 0.0055F; // with uplift 1: slope of a stream = uplift / (K sqrt(area))
constexpr float uplift_per_step_m = 1.95F;

void grow(HeightGrid& grid, FluvialModel& model, int steps, float speed) {
    for (float& u : model.uplift_m) {
        u *= uplift_per_step_m * speed;
    }
    model.erodibility = erodibility_per_step * speed;
    erode(grid, model, steps);
}

} // namespace

float lake_height_m() {
    return 586.0F;
}

float lake_distance_m(glm::vec2 p) {
    const glm::vec2 d = p - lake_centre_m;
    const float angle = 0.1F;
    const glm::vec2 q((d.x * std::cos(angle) + d.y * std::sin(angle)) / 1150.0F,
                      (-d.x * std::sin(angle) + d.y * std::cos(angle)) / 430.0F);
    const float distance = glm::length(q) - 1.0F;
    if (distance > 2.0F) {
        return distance * 430.0F; // far away, where no bay matters
    }
    const float wobble = 0.18F * gradient_noise(p.x / 420.0F, p.y / 420.0F, 77U);
    return (distance + wobble) * 430.0F;
}

float Terrain::height_m(glm::vec2 p) const {
    const float half = 0.5F * inner.extent_m();
    return std::abs(p.x) <= half && std::abs(p.y) <= half ? sample_bilinear(inner, p) : sample_bilinear(outer, p);
}

Terrain generate_terrain(std::uint32_t seed) {
    Terrain terrain;
    terrain.seed = seed;

    // The ranges, from coarse to fine: most steps where they are cheap.
    HeightGrid grid = make_grid(129, 1024.0F);
    for (int j = 0; j < grid.n; ++j) {
        for (int i = 0; i < grid.n; ++i) {
            const Framework f = framework(grid.position_m(i, j), seed);
            grid.height_m[grid.index(i, j)] =
                f.floor_m + 40.0F * hash_unit(i, j, seed) + 0.02F * std::max(0.0F, f.distance_m);
        }
    }
    struct Level {
        int n;
        float spacing_m;
        int steps;
        float speed;
        float jitter_m;
    };
    std::vector<float> area;
    FluvialModel model;
    for (const Level level : {Level{129, 1024.0F, 100, 25.0F, 0.0F}, Level{257, 512.0F, 40, 12.0F, 30.0F},
                              Level{513, 256.0F, 14, 8.0F, 20.0F}}) {
        if (level.n != grid.n) {
            grid = refine(grid, level.n, level.spacing_m, level.jitter_m, 6.0F * level.spacing_m, seed);
        }
        model = make_model(grid, seed);
        pin_outer(grid, model, seed);
        grow(grid, model, level.steps, level.speed);
    }
    const HeightGrid ranges = grid;
    const FluvialModel ranges_model = model;

    // The middle again, finer; rivers enter where they cross its border.
    HeightGrid inner = refine(ranges, 257, 64.0F, 12.0F, 1100.0F, seed);
    for (const Level level : {Level{257, 64.0F, 24, 6.0F, 0.0F}, Level{513, 32.0F, 8, 3.0F, 3.0F}}) {
        if (level.n != inner.n) {
            inner = refine(inner, level.n, level.spacing_m, level.jitter_m, 300.0F, seed);
        }
        model = make_model(inner, seed);
        model.inflow_m2.assign(inner.height_m.size(), 0.0F);
        const int last = inner.n - 1;
        for (int j = 0; j < inner.n; ++j) {
            for (int i = 0; i < inner.n; ++i) {
                const std::size_t k = inner.index(i, j);
                if (model.node[k] == Node::base) {
                    inner.height_m[k] = framework(inner.position_m(i, j), seed).floor_m;
                } else if (i == 0 || j == 0 || i == last || j == last) {
                    model.node[k] = Node::through;
                    inner.height_m[k] = sample_cubic(ranges, bend(inner.position_m(i, j), 1100.0F, seed));
                }
            }
        }
        // A coarse sample on the border whose receiver lies inside brings its drainage area along.
        const int first = (ranges.n - 1) / 2 - 32;
        for (int j = 0; j <= 64; ++j) {
            for (int i = 0; i <= 64; ++i) {
                if (i != 0 && j != 0 && i != 64 && j != 64) {
                    continue;
                }
                const std::size_t k = ranges.index(first + i, first + j);
                const auto r = static_cast<std::size_t>(ranges_model.receiver[k]);
                const int ri = static_cast<int>(r % static_cast<std::size_t>(ranges.n)) - first;
                const int rj = static_cast<int>(r / static_cast<std::size_t>(ranges.n)) - first;
                if (ri > 0 && rj > 0 && ri < 64 && rj < 64) {
                    model.inflow_m2[inner.index(i * last / 64, j * last / 64)] = ranges_model.area_m2[k];
                }
            }
        }
        grow(inner, model, level.steps, level.speed);
    }
    soften(inner, 0.35F);

    // Final samples.
    const HeightGrid inner_coarse = inner;
    terrain.inner = refine(inner_coarse, Terrain::samples, Terrain::inner_spacing_m, 0.0F, 0.0F, seed);
    terrain.outer = refine(ranges, Terrain::samples, Terrain::outer_spacing_m, 0.0F, 1100.0F, seed);
    HeightGrid area_grid = make_grid(inner_coarse.n, inner_coarse.spacing_m);
    area_grid.height_m = model.area_m2;
    terrain.inner_area_m2 = refine(area_grid, Terrain::samples, Terrain::inner_spacing_m, 0.0F, 0.0F, seed).height_m;
    area_grid = make_grid(ranges.n, ranges.spacing_m);
    area_grid.height_m = ranges_model.area_m2;
    terrain.outer_area_m2 = refine(area_grid, Terrain::samples, Terrain::outer_spacing_m, 0.0F, 1100.0F, seed).height_m;

    add_detail(terrain.inner, seed, true);
    add_detail(terrain.outer, seed, false);

    // Join: towards its border the inner surface becomes the outer one.
    const float half = 0.5F * terrain.inner.extent_m();
    const HeightGrid& outer = terrain.outer;
    parallel_for(static_cast<std::size_t>(Terrain::samples), 16, [&](std::size_t begin, std::size_t end) {
        for (int j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
            for (int i = 0; i < Terrain::samples; ++i) {
                const glm::vec2 p = terrain.inner.position_m(i, j);
                const float border_m = half - std::max(std::abs(p.x), std::abs(p.y));
                if (border_m < 900.0F) {
                    float& h = terrain.inner.height_m[terrain.inner.index(i, j)];
                    h = glm::mix(sample_bilinear(outer, p), h, smoothstep(0.0F, 900.0F, border_m));
                }
            }
        }
    });
    dig_lake(terrain.inner);
    const int first = (Terrain::samples - 1) / 2 - (Terrain::samples - 1) / 2 / Terrain::ratio;
    for (int j = 0; j < Terrain::samples; j += Terrain::ratio) {
        for (int i = 0; i < Terrain::samples; i += Terrain::ratio) {
            terrain.outer.height_m[terrain.outer.index(first + i / Terrain::ratio, first + j / Terrain::ratio)] =
                terrain.inner.at(i, j);
        }
    }
    return terrain;
}

glm::vec3 grid_normal(const HeightGrid& grid, int i, int j) {
    const auto slope = [&](int di, int dj) {
        const float near = grid.at_clamped(i + di, j + dj) - grid.at_clamped(i - di, j - dj);
        const float far = grid.at_clamped(i + 2 * di, j + 2 * dj) - grid.at_clamped(i - 2 * di, j - 2 * dj);
        return (0.6F * near / 2.0F + 0.4F * far / 4.0F) / grid.spacing_m;
    };
    return glm::normalize(glm::vec3(-slope(1, 0), -slope(0, 1), 1.0F));
}

namespace {

// Woods on the valley floors, where the slopes' forest does not reach.
struct Wood {
    glm::vec2 centre_m;
    float radius_m;
};
constexpr Wood woods[] = {{{130.0F, 70.0F}, 70.0F},     {{400.0F, 130.0F}, 75.0F},    {{-150.0F, -190.0F}, 60.0F},
                          {{-2010.0F, -170.0F}, 60.0F}, {{-1480.0F, -200.0F}, 55.0F}, {{-2080.0F, -420.0F}, 70.0F},
                          {{6350.0F, -3850.0F}, 75.0F}, {{6800.0F, -3850.0F}, 75.0F}, {{6560.0F, -4250.0F}, 90.0F}};

// Within a wood, 0 .. 1.
float floor_wood(glm::vec2 p, std::uint32_t seed) {
    for (const Wood& wood : woods) {
        const float distance_m = glm::distance(p, wood.centre_m);
        if (distance_m < 1.6F * wood.radius_m) {
            const float wobble = 0.9F * fractal_noise(p.x / 120.0F, p.y / 120.0F, 2, seed + 47U);
            return smoothstep(1.08F, 0.92F, distance_m / wood.radius_m + wobble);
        }
    }
    return 0.0F;
}

// Forest on slopes and floors, 0 .. 1. Avalanches keep their tracks free: the gullies that come from above.
float wooded(glm::vec2 p, float height_m, float normal_z, float floor_distance_m, float patches, float gully,
             std::uint32_t seed) {
    const float tree_line_m = 1780.0F + 220.0F * patches;
    const float below_line = 1.0F - smoothstep(tree_line_m - 60.0F, tree_line_m + 40.0F, height_m);
    const float not_cliff = smoothstep(0.58F, 0.66F, normal_z);
    // Clearings on gentle ground, and farmland on the floors.
    const float gentle = smoothstep(0.90F, 0.985F, normal_z);
    const float stand = smoothstep(-0.03F, 0.02F, patches + 0.40F - 0.66F * gentle);
    const float track = gully * smoothstep(750.0F, 1150.0F, height_m);
    const float slopes =
        below_line * not_cliff * stand * (1.0F - 0.9F * track) * smoothstep(30.0F, 120.0F, floor_distance_m);
    return std::max(slopes, floor_distance_m < 120.0F ? floor_wood(p, seed) : 0.0F);
}

// Farmland on a floor: narrow strips of several crops, turned by district.
glm::vec3 field_albedo(glm::vec2 p, std::uint32_t seed) {
    const float turn = 1.5F * hash_unit(static_cast<int>(std::floor(p.x / 520.0F)),
                                        static_cast<int>(std::floor(p.y / 430.0F)), seed + 44U);
    const float u = (p.x * std::cos(turn) + p.y * std::sin(turn)) / 170.0F;
    const float v = (-p.x * std::sin(turn) + p.y * std::cos(turn)) / 52.0F;
    const float crop = hash_unit(static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v)), seed + 45U);
    return crop < 0.30F   ? glm::vec3(0.088F, 0.138F, 0.038F)  // meadow, tall
           : crop < 0.52F ? glm::vec3(0.128F, 0.168F, 0.056F)  // mown
           : crop < 0.64F ? glm::vec3(0.155F, 0.165F, 0.066F)  // in flower
           : crop < 0.76F ? glm::vec3(0.205F, 0.178F, 0.082F)  // hay
           : crop < 0.88F ? glm::vec3(0.062F, 0.108F, 0.030F)  // maize
           : crop < 0.95F ? glm::vec3(0.245F, 0.200F, 0.095F)  // wheat
                          : glm::vec3(0.125F, 0.095F, 0.066F); // ploughed
}

} // namespace

float wood_cover(const Terrain& terrain, glm::vec2 p) {
    return floor_wood(p, terrain.seed);
}

glm::vec3 ground_albedo(const Terrain& terrain, glm::vec2 p, float height_m, glm::vec3 normal, float drainage_m2,
                        float spacing_m) {
    const std::uint32_t seed = terrain.seed;
    const float lake = lake_distance_m(p);
    if (lake < 0.0F) {
        return glm::mix(glm::vec3(0.030F, 0.062F, 0.075F), glm::vec3(0.075F, 0.120F, 0.115F),
                        smoothstep(-45.0F, 0.0F, lake));
    }
    // Noise finer than the samples would only be speckle.
    const bool fine = spacing_m < 40.0F;
    const float floor_m = framework(p, seed).distance_m;
    const float slope = std::sqrt(std::max(0.0F, 1.0F - normal.z * normal.z)) / normal.z;
    const float grain = fine ? fractal_noise(p.x / 130.0F, p.y / 130.0F, 3, seed + 42U) : 0.0F;
    const float broad = fractal_noise(p.x / 1500.0F, p.y / 1500.0F, fine ? 3 : 2, seed + 43U);
    const float patches = fractal_noise(p.x / 900.0F, p.y / 900.0F, fine ? 4 : 2, seed + 41U);
    const float cells = std::max(0.0F, drainage_m2) / (4.0F * spacing_m * spacing_m); // the rivers' grid is coarser
    const float gully = smoothstep(8.0F, 40.0F, cells) * smoothstep(0.35F, 0.55F, slope);

    // Turf dries out with height.
    const float alpine = smoothstep(1500.0F, 2300.0F, height_m + 200.0F * broad);
    glm::vec3 albedo = glm::mix(glm::vec3(0.090F, 0.140F, 0.038F), glm::vec3(0.135F, 0.130F, 0.058F), alpine);
    albedo = glm::mix(albedo, glm::vec3(0.140F, 0.150F, 0.056F), 0.7F * smoothstep(0.0F, 0.3F, broad - 0.5F * grain));
    if (floor_m < 60.0F && height_m < 1000.0F) {
        albedo = glm::mix(albedo, field_albedo(p, seed), 0.85F * smoothstep(60.0F, 0.0F, floor_m));
    }
    albedo *= 1.0F + 0.30F * grain;

    // Beech and larch among the spruce, low and high; crowns and their gaps.
    const float forest = wooded(p, height_m, normal.z, floor_m, patches, gully, seed);
    if (forest > 0.0F) {
        glm::vec3 trees(0.024F, 0.045F, 0.019F);
        trees =
            glm::mix(trees, glm::vec3(0.050F, 0.082F, 0.024F),
                     0.8F * smoothstep(0.10F, 0.35F, 0.3F * grain - patches) * smoothstep(1300.0F, 1000.0F, height_m));
        trees = glm::mix(trees, glm::vec3(0.052F, 0.070F, 0.026F),
                         0.7F * smoothstep(1450.0F, 1750.0F, height_m + 300.0F * grain));
        const float crowns = fine ? gradient_noise(p.x / 38.0F, p.y / 38.0F, seed + 46U) : 0.0F;
        albedo = glm::mix(albedo, trees * (1.0F + 0.25F * grain + 0.30F * crowns), 0.96F * forest);
    }

    // Bare ground: limestone, with scree below and in the gullies. Low down, woods hold on to all but the steepest.
    const float steep = glm::mix(1.16F, 0.74F, smoothstep(1250.0F, 2250.0F, height_m + 250.0F * broad));
    // There rock shows in bands between ledges.
    const float low_down = smoothstep(1700.0F, 1100.0F, height_m);
    const float ledges = 0.5F + 0.5F * std::sin(height_m / 19.0F + 6.0F * broad + 5.0F * grain);
    const float bareness =
        smoothstep(-0.07F, 0.07F, slope - steep + 0.28F * grain + 0.10F * broad - 0.60F * low_down * ledges);
    const float strata = 0.5F + 0.5F * std::sin(height_m / 23.0F + 4.0F * broad + 2.0F * grain);
    const glm::vec3 rock = glm::mix(glm::vec3(0.176F, 0.170F, 0.158F), glm::vec3(0.268F, 0.260F, 0.242F), strata) *
                           ((1.0F + 0.30F * grain) * (1.0F - 0.35F * low_down));
    albedo = glm::mix(albedo, rock, bareness);
    const float scree = smoothstep(0.48F, 0.58F, slope) * (1.0F - smoothstep(0.85F, 0.98F, slope)) *
                        smoothstep(1750.0F, 1950.0F, height_m + 350.0F * grain + 250.0F * broad);
    albedo = glm::mix(albedo, glm::vec3(0.300F, 0.284F, 0.258F) * (1.0F + 0.15F * grain), 0.85F * scree);
    const float torrent = gully * smoothstep(40.0F, 160.0F, cells) * smoothstep(900.0F, 1300.0F, height_m);
    albedo = glm::mix(albedo, glm::vec3(0.240F, 0.228F, 0.205F), 0.6F * torrent * (1.0F - forest));

    // Snow that lasts into summer: high, not too steep, longer in the shade and in gullies.
    const float shade = -60.0F * normal.y / std::max(normal.z, 0.2F);
    const float gathered = 60.0F * std::log2(1.0F + std::max(0.0F, drainage_m2) / 20000.0F);
    const float snow_line_m = 2330.0F + 320.0F * broad + 260.0F * grain + shade * 2.0F - std::min(gathered, 220.0F);
    const float snow =
        smoothstep(snow_line_m - 30.0F, snow_line_m + 60.0F, height_m) * (1.0F - smoothstep(0.95F, 1.35F, slope));
    albedo = glm::mix(albedo, glm::vec3(0.78F, 0.80F, 0.83F), snow);

    // Wet gravel along the shore.
    albedo = glm::mix(glm::vec3(0.22F, 0.21F, 0.18F), albedo, smoothstep(0.0F, 26.0F, lake));
    return glm::clamp(albedo, glm::vec3(0.01F), glm::vec3(0.9F));
}

} // namespace alpenglow::sandbox
