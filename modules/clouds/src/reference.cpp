#include <alpenglow/clouds/reference.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>

namespace alpenglow::clouds {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr int block = 4; // voxels a side of a majorant

float dot(const glm::vec3& a, const glm::vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// PCG-XSH-RR with a stream for each (seed, pixel, sample).
class Random {
public:
    Random(std::uint64_t seed, std::uint64_t pixel, std::uint64_t sample) {
        state_ = mix(seed * 0x9e3779b97f4a7c15ULL ^
                     mix(pixel * 0xbf58476d1ce4e5b9ULL ^ mix(sample + 0x94d049bb133111ebULL)));
    }
    float next() { // [0, 1)
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ULL + 1442695040888963407ULL;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
        const auto rotation = static_cast<std::uint32_t>(old >> 59U);
        const std::uint32_t bits = (shifted >> rotation) | (shifted << ((0U - rotation) & 31U));
        return static_cast<float>(bits >> 8) * 0x1p-24F;
    }
    float exponential() { return -std::log(1.0F - next()); }

private:
    static std::uint64_t mix(std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31);
    }
    std::uint64_t state_;
};

// Two unit vectors that complete w to a right-handed frame (Duff et al. 2017).
void frame(const glm::vec3& w, glm::vec3& u, glm::vec3& v) {
    const float sign = std::copysign(1.0F, w.z);
    const float a = -1.0F / (sign + w.z);
    const float b = w.x * w.y * a;
    u = {1.0F + sign * w.x * w.x * a, sign * b, -sign * w.x};
    v = {b, sign + w.y * w.y * a, -w.y};
}

// A direction at the polar cosine `c` around w.
glm::vec3 around(const glm::vec3& w, float c, Random& random) {
    float x = 0.0F;
    float y = 0.0F;
    float r2 = 0.0F;
    do { // a point in the unit disc gives the azimuth without sine and cosine
        x = 2.0F * random.next() - 1.0F;
        y = 2.0F * random.next() - 1.0F;
        r2 = x * x + y * y;
    } while (r2 > 1.0F || r2 < 1e-12F);
    const float s = std::sqrt(std::max(0.0F, 1.0F - c * c) / r2);
    glm::vec3 u;
    glm::vec3 v;
    frame(w, u, v);
    const glm::vec3 d = u * (s * x) + v * (s * y) + w * c;
    return d / std::sqrt(dot(d, d));
}

} // namespace

struct PathTracer::State {
    ReferenceScene scene;
    // Bricks with an apron, like BrickVolume's, but in float.
    glm::ivec3 min{0};
    glm::ivec3 bricks{0};
    std::vector<std::int32_t> table; // dense over bricks; -1: empty
    std::vector<float> values;       // 729 a brick
    std::vector<float> majorant;     // 8 a brick, times extinction: 1/m
    std::vector<float> inverse_majorant;
    glm::vec3 high{0.0F}; // size in voxels
    glm::vec3 inverse_voxel{1.0F};
    float extinction = 0.0F;
    std::vector<glm::vec3> to_light;       // in the grid's frame
    std::vector<std::vector<float>> guide; // for each light: a guess at the transmittance to it, 8 a brick

    [[nodiscard]] std::int32_t brick_at(int bx, int by, int bz) const {
        return table[(std::size_t(bz) * std::size_t(bricks.y) + std::size_t(by)) * std::size_t(bricks.x) +
                     std::size_t(bx)];
    }

    [[nodiscard]] static int octant(const glm::ivec3& b) { return (b.x & 1) | ((b.y & 1) << 1) | ((b.z & 1) << 2); }

    void prepare();
    void make_guides();

    // Density at p (voxels from min, inside brick `b`), by stochastic choice of a corner.
    [[nodiscard]] float pick(std::int32_t b, const glm::vec3& p, Random& random) const {
        const float fx = std::floor(p.x);
        const float fy = std::floor(p.y);
        const float fz = std::floor(p.z);
        // One random number serves the three choices: its used part is stretched again.
        float u = random.next();
        const auto choose = [&u](float t) {
            if (u < t) {
                u = u / t;
                return 1;
            }
            u = (u - t) / (1.0F - t);
            return 0;
        };
        const int x = (static_cast<int>(fx) & 7) + choose(p.x - fx);
        const int y = (static_cast<int>(fy) & 7) + choose(p.y - fy);
        const int z = (static_cast<int>(fz) & 7) + choose(p.z - fz);
        return values[std::size_t(b) * 729 + std::size_t(z * 81 + y * 9 + x)];
    }

    // Walks the majorant blocks along p + t d (voxels; t in metres). visit(brick, majorant, inverse, t0, t1) returns
    // false to stop. Returns false where it was stopped.
    template <class Visit>
    bool walk(const glm::vec3& p, const glm::vec3& d, float t_begin, float t_end, Visit&& visit) const {
        float t0 = t_begin;
        float t1 = t_end;
        glm::vec3 inverse;
        for (int a = 0; a < 3; ++a) {
            if (std::abs(d[a]) < 1e-12F) {
                inverse[a] = infinity;
                if (!(p[a] >= 0.0F && p[a] < high[a])) {
                    return true;
                }
                continue;
            }
            inverse[a] = 1.0F / d[a];
            const float u = -p[a] * inverse[a];
            const float v = (high[a] - p[a]) * inverse[a];
            t0 = std::max(t0, std::min(u, v));
            t1 = std::min(t1, std::max(u, v));
        }
        if (!(t0 < t1)) {
            return true;
        }
        glm::ivec3 cell;
        glm::ivec3 step;
        glm::vec3 next;
        glm::vec3 delta;
        for (int a = 0; a < 3; ++a) {
            const float at = std::clamp(p[a] + t0 * d[a], 0.0F, high[a] - 1e-3F);
            cell[a] = static_cast<int>(at) / block;
            if (inverse[a] == infinity) {
                step[a] = 0;
                next[a] = infinity;
                delta[a] = infinity;
                continue;
            }
            step[a] = d[a] > 0.0F ? 1 : -1;
            next[a] = (static_cast<float>((cell[a] + (d[a] > 0.0F ? 1 : 0)) * block) - p[a]) * inverse[a];
            delta[a] = static_cast<float>(block) * std::abs(inverse[a]);
        }
        for (;;) {
            const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
            const float exit = std::min(next[axis], t1);
            const std::int32_t b = brick_at(cell.x >> 1, cell.y >> 1, cell.z >> 1);
            if (b >= 0 && exit > t0) {
                const std::size_t m = std::size_t(b) * 8 + std::size_t(octant(cell));
                if (majorant[m] > 0.0F && !visit(b, m, t0, exit)) {
                    return false;
                }
            }
            if (!(next[axis] < t1)) {
                return true;
            }
            t0 = std::max(t0, exit);
            cell[axis] += step[axis];
            next[axis] += delta[axis];
            if (cell[axis] < 0 || cell[axis] >= bricks[axis] * 2) {
                return true;
            }
        }
    }

    // Ratio tracking to the outside.
    [[nodiscard]] float shadow(const glm::vec3& p, const glm::vec3& d, float t_end, Random& random) const {
        float weight = 1.0F;
        float left = random.exponential();
        walk(p, d, 0.0F, t_end, [&](std::int32_t b, std::size_t m, float t0, float t1) {
            float t = t0;
            const float maj = majorant[m];
            for (;;) {
                const float dt = left * inverse_majorant[m];
                if (t + dt >= t1) {
                    left -= (t1 - t) * maj;
                    left = std::max(left, 0.0F);
                    return true;
                }
                t += dt;
                weight *= std::max(0.0F, 1.0F - extinction * pick(b, p + d * t, random) * inverse_majorant[m]);
                if (weight < 0.1F) {
                    if (random.next() >= 0.25F) {
                        weight = 0.0F;
                        return false;
                    }
                    weight *= 4.0F;
                }
                left = random.exponential();
            }
        });
        return weight;
    }

    [[nodiscard]] glm::vec3 light_direction(std::size_t i, Random& random) const {
        const float radius = scene.lights[i].angular_radius_rad;
        if (radius <= 0.0F) {
            return to_light[i];
        }
        const float one_minus_cos_radius = 2.0F * std::sin(0.5F * radius) * std::sin(0.5F * radius);
        return around(to_light[i], 1.0F - random.next() * one_minus_cos_radius, random);
    }

    [[nodiscard]] glm::vec3 world(const glm::vec3& local) const {
        return glm::vec3(scene.grid->transform().axes * glm::dvec3(local));
    }

    // One path. p: voxels from min; d: unit, the grid's frame.
    [[nodiscard]] glm::vec3 path(glm::vec3 p, glm::vec3 d, Random& random) const {
        glm::vec3 sum(0.0F);
        float weight = 1.0F;
        glm::vec3 tint(1.0F); // the ground's colour
        const Medium& medium = scene.medium;
        for (int bounce = 0;; ++bounce) {
            const glm::vec3 dv = d * inverse_voxel;
            float t_ground = infinity;
            const glm::vec3 wd = scene.ground.present || scene.sky ? world(d) : glm::vec3(0.0F);
            if (scene.ground.present && wd.z < 0.0F) {
                const glm::dvec3 at = scene.grid->transform().world_from_index(glm::dvec3(p) + glm::dvec3(min));
                t_ground = static_cast<float>(std::max(0.0, (scene.ground.height_m - at.z) / double(wd.z)));
            }
            float hit = infinity;
            float left = random.exponential();
            std::int32_t hit_brick = -1;
            std::size_t hit_block = 0;
            walk(p, dv, 0.0F, t_ground, [&](std::int32_t b, std::size_t m, float t0, float t1) {
                float t = t0;
                for (;;) {
                    const float dt = left * inverse_majorant[m];
                    if (t + dt >= t1) {
                        left = std::max(0.0F, left - (t1 - t) * majorant[m]);
                        return true;
                    }
                    t += dt;
                    if (random.next() * majorant[m] < extinction * pick(b, p + dv * t, random)) {
                        hit = t;
                        hit_brick = b;
                        hit_block = m;
                        return false;
                    }
                    left = random.exponential();
                }
            });
            if (hit_brick < 0) {
                if (t_ground < infinity) {
                    p += dv * t_ground;
                    tint *= scene.ground.albedo;
                    const glm::vec3 up(static_cast<float>(scene.grid->transform().axes[0].z),
                                       static_cast<float>(scene.grid->transform().axes[1].z),
                                       static_cast<float>(scene.grid->transform().axes[2].z));
                    for (std::size_t i = 0; i < to_light.size(); ++i) {
                        const glm::vec3 l = light_direction(i, random);
                        const float cosine = dot(l, up);
                        if (cosine > 0.0F) {
                            sum += tint * scene.lights[i].irradiance *
                                   (weight * cosine * static_cast<float>(1.0 / pi) *
                                    shadow(p + up * inverse_voxel * 1e-3F, l * inverse_voxel, infinity, random));
                        }
                    }
                    d = around(up, std::sqrt(1.0F - random.next()), random);
                    p += up * inverse_voxel * 1e-3F;
                    if (bounce > 200) {
                        return sum;
                    }
                    continue;
                }
                if (scene.sky) {
                    sum += tint * scene.sky(wd) * weight;
                }
                return sum;
            }
            p += dv * hit;
            weight *= medium.albedo;
            if (weight <= 0.0F) {
                return sum;
            }
            for (std::size_t i = 0; i < to_light.size(); ++i) {
                const glm::vec3 l = light_direction(i, random);
                const glm::vec3 difference = l - d;
                const float phase = phase_value(medium.phase, 0.5F * dot(difference, difference));
                const float promise = 8.0F * static_cast<float>(pi) * weight * phase * guide[i][hit_block];
                const float chance = std::clamp(promise, 0.02F, 1.0F);
                if (chance >= 1.0F || random.next() < chance) {
                    sum += tint * scene.lights[i].irradiance *
                           (weight * phase / chance * shadow(p, l * inverse_voxel, infinity, random));
                }
            }
            if (scene.max_scatterings > 0 && bounce + 1 >= scene.max_scatterings) {
                return sum;
            }
            if (weight < 0.2F) {
                if (random.next() >= 0.5F) {
                    return sum;
                }
                weight *= 2.0F;
            }
            d = around(d, sample_phase_cos(medium.phase, random.next()), random);
        }
    }
};

void PathTracer::State::prepare() {
    const SparseGrid& grid = *scene.grid;
    extinction = scene.medium.extinction_per_m;
    for (int a = 0; a < 3; ++a) {
        inverse_voxel[a] = static_cast<float>(1.0 / grid.transform().voxel_m[a]);
    }
    for (const DirectionalLight& light : scene.lights) {
        const glm::dvec3 l = grid.transform().local_direction(glm::dvec3(light.to_light));
        to_light.push_back(glm::vec3(l / std::sqrt(l.x * l.x + l.y * l.y + l.z * l.z)));
    }
    min = grid.min() - 8;
    bricks = grid.table().bricks() + 1;
    high = glm::vec3(bricks * 8);
    table.assign(std::size_t(bricks.x) * std::size_t(bricks.y) * std::size_t(bricks.z), -1);
    // A brick is there if any voxel of it or its apron is.
    std::vector<glm::ivec3> kept;
    for (std::int32_t b = 0; b < grid.table().count(); ++b) {
        const glm::ivec3& c = grid.table().coordinates()[std::size_t(b)];
        for (int mask = 0; mask < 8; ++mask) {
            const glm::ivec3 at(c.x + 1 - (mask & 1), c.y + 1 - ((mask >> 1) & 1), c.z + 1 - ((mask >> 2) & 1));
            std::int32_t& entry =
                table[(std::size_t(at.z) * std::size_t(bricks.y) + std::size_t(at.y)) * std::size_t(bricks.x) +
                      std::size_t(at.x)];
            if (entry < 0) {
                entry = static_cast<std::int32_t>(kept.size());
                kept.push_back(at);
            }
        }
    }
    values.assign(kept.size() * 729, 0.0F);
    majorant.assign(kept.size() * 8, 0.0F);
    parallel_for(kept.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const glm::ivec3 first = min + kept[b] * 8;
            float* to = values.data() + b * 729;
            for (int i = 0; i < 729; ++i) {
                to[i] = grid.value(first.x + i % 9, first.y + i / 9 % 9, first.z + i / 81);
            }
            for (int o = 0; o < 8; ++o) {
                float most = 0.0F;
                for (int z = (o >> 2) * 4; z <= (o >> 2) * 4 + 4; ++z) {
                    for (int y = ((o >> 1) & 1) * 4; y <= ((o >> 1) & 1) * 4 + 4; ++y) {
                        for (int x = (o & 1) * 4; x <= (o & 1) * 4 + 4; ++x) {
                            most = std::max(most, to[z * 81 + y * 9 + x]);
                        }
                    }
                }
                majorant[b * 8 + std::size_t(o)] = most * extinction;
            }
        }
    });
    inverse_majorant.resize(majorant.size());
    std::transform(majorant.begin(), majorant.end(), inverse_majorant.begin(),
                   [](float m) { return m > 1e-30F ? 1.0F / m : 0.0F; });
    std::transform(majorant.begin(), majorant.end(), majorant.begin(), [](float m) { return m > 1e-30F ? m : 0.0F; });
    make_guides();
}

// A march over block means towards each light. Only a guess: it steers how often shadow rays are sent, not what they
// say.
void PathTracer::State::make_guides() {
    std::vector<float> mean(majorant.size(), 0.0F);
    for (std::size_t m = 0; m < mean.size(); ++m) {
        const float* from = values.data() + m / 8 * 729;
        const int o = static_cast<int>(m % 8);
        float sum = 0.0F;
        for (int i = 0; i < 64; ++i) {
            sum += from[((o >> 2) * 4 + (i >> 4)) * 81 + (((o >> 1) & 1) * 4 + ((i >> 2) & 3)) * 9 + (o & 1) * 4 +
                        (i & 3)];
        }
        mean[m] = extinction * sum / 64.0F;
    }
    for (const glm::vec3& l : to_light) {
        std::vector<float> table_of_light(majorant.size(), 1.0F);
        parallel_for(table.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::int32_t b = table[i];
                if (b < 0) {
                    continue;
                }
                const glm::ivec3 at(static_cast<int>(i % std::size_t(bricks.x)),
                                    static_cast<int>(i / std::size_t(bricks.x) % std::size_t(bricks.y)),
                                    static_cast<int>(i / std::size_t(bricks.x) / std::size_t(bricks.y)));
                for (int o = 0; o < 8; ++o) {
                    const glm::vec3 p = glm::vec3(at * 8) + glm::vec3(2.0F + 4.0F * static_cast<float>(o & 1),
                                                                      2.0F + 4.0F * static_cast<float>((o >> 1) & 1),
                                                                      2.0F + 4.0F * static_cast<float>(o >> 2));
                    float tau = 0.0F;
                    walk(p, l * inverse_voxel, 0.0F, infinity, [&](std::int32_t, std::size_t m, float t0, float t1) {
                        tau += mean[m] * (t1 - t0);
                        return tau < 20.0F;
                    });
                    table_of_light[std::size_t(b) * 8 + std::size_t(o)] = std::max(0.02F, std::exp(-0.8F * tau));
                }
            }
        });
        guide.push_back(std::move(table_of_light));
    }
}

PathTracer::PathTracer(ReferenceScene scene) : state_(std::make_unique<State>()) {
    assert(scene.grid != nullptr);
    state_->scene = std::move(scene);
    state_->prepare();
}
PathTracer::~PathTracer() = default;
PathTracer::PathTracer(PathTracer&&) noexcept = default;
PathTracer& PathTracer::operator=(PathTracer&&) noexcept = default;

void PathTracer::render(const Camera& camera, ReferenceImage& image, std::uint64_t first, std::uint64_t count,
                        std::uint64_t stride, std::uint64_t seed, unsigned threads) const {
    assert(image.width == camera.width && image.height == camera.height);
    const State& s = *state_;
    const GridTransform& transform = s.scene.grid->transform();
    const glm::vec3 eye(transform.index_from_world(camera.position_m) - glm::dvec3(s.min));
    const auto pixels = std::size_t(image.width) * std::size_t(image.height);
    parallel_for(
        pixels, 32,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                const auto px = static_cast<float>(pixel % std::size_t(image.width));
                const auto py = static_cast<float>(pixel / std::size_t(image.width));
                glm::dvec3 sums[2] = {glm::dvec3(0.0), glm::dvec3(0.0)};
                double squares = 0.0;
                for (std::uint64_t i = 0; i < count; ++i) {
                    const std::uint64_t sample = first + i * stride;
                    Random random(seed, pixel, sample);
                    const float jx = random.next();
                    const float jy = random.next();
                    const glm::vec3 d(transform.local_direction(glm::dvec3(camera.direction(px + jx, py + jy))));
                    const glm::dvec3 radiance(s.path(eye, d / std::sqrt(dot(d, d)), random));
                    sums[i & 1U] += radiance;
                    squares += luminance(radiance) * luminance(radiance);
                }
                image.sum[0][pixel] += sums[0];
                image.sum[1][pixel] += sums[1];
                image.squares[pixel] += squares;
            }
        },
        threads);
    image.samples_of[0] += (count + 1) / 2;
    image.samples_of[1] += count / 2;
}

glm::dvec3 PathTracer::radiance(const glm::dvec3& origin_m, const glm::vec3& direction, std::uint64_t samples,
                                std::uint64_t seed) const {
    const State& s = *state_;
    const GridTransform& transform = s.scene.grid->transform();
    const glm::vec3 eye(transform.index_from_world(origin_m) - glm::dvec3(s.min));
    const glm::vec3 d(transform.local_direction(glm::dvec3(direction)));
    const std::size_t grain = 4096;
    std::vector<glm::dvec3> sums((samples + grain - 1) / grain, glm::dvec3(0.0));
    parallel_for(samples, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Random random(seed, 0, i);
            sums[begin / grain] += glm::dvec3(s.path(eye, d, random));
        }
    });
    glm::dvec3 total(0.0);
    for (const glm::dvec3& sum : sums) {
        total += sum;
    }
    return total / double(samples);
}

double PathTracer::transmittance(const glm::dvec3& from_m, const glm::vec3& direction, std::uint64_t samples,
                                 std::uint64_t seed) const {
    const State& s = *state_;
    const GridTransform& transform = s.scene.grid->transform();
    const glm::vec3 p(transform.index_from_world(from_m) - glm::dvec3(s.min));
    const glm::vec3 d = glm::vec3(transform.local_direction(glm::dvec3(direction))) * s.inverse_voxel;
    double sum = 0.0;
    for (std::uint64_t i = 0; i < samples; ++i) {
        Random random(seed, 1, i);
        sum += double(s.shadow(p, d, infinity, random));
    }
    return sum / double(samples);
}

ReferenceImage::ReferenceImage(int w, int h) : width(w), height(h) {
    const auto pixels = std::size_t(w) * std::size_t(h);
    sum[0].assign(pixels, glm::dvec3(0.0));
    sum[1].assign(pixels, glm::dvec3(0.0));
    squares.assign(pixels, 0.0);
}

glm::dvec3 ReferenceImage::mean(std::size_t pixel) const {
    return (sum[0][pixel] + sum[1][pixel]) / double(std::max<std::uint64_t>(samples(), 1));
}

glm::dvec3 ReferenceImage::mean_of_half(int half, std::size_t pixel) const {
    return sum[half][pixel] / double(std::max<std::uint64_t>(samples_of[half], 1));
}

double ReferenceImage::standard_error(std::size_t pixel) const {
    const auto n = double(samples());
    if (samples() < 2) {
        return 0.0;
    }
    const double m = luminance(mean(pixel));
    return std::sqrt(std::max(0.0, squares[pixel] / n - m * m) / (n - 1.0));
}

Result<ReferenceImage> merge(const ReferenceImage& a, const ReferenceImage& b, const std::string& where) {
    if (a.width != b.width || a.height != b.height) {
        return Error{"the picture is " + std::to_string(b.width) + " x " + std::to_string(b.height), where,
                     std::to_string(a.width) + " x " + std::to_string(a.height) + ", as the first"};
    }
    ReferenceImage out = a;
    out.samples_of[0] += b.samples_of[0];
    out.samples_of[1] += b.samples_of[1];
    for (std::size_t i = 0; i < out.squares.size(); ++i) {
        out.sum[0][i] += b.sum[0][i];
        out.sum[1][i] += b.sum[1][i];
        out.squares[i] += b.squares[i];
    }
    return out;
}

namespace {
constexpr char reference_magic[8] = {'A', 'G', 'C', 'L', 'R', 'E', 'F', '1'};
struct ReferenceHeader {
    char magic[8];
    std::int32_t width, height;
    std::uint64_t samples_of[2], next_sample, note_length;
};
} // namespace

Status save_reference(const std::string& path, const ReferenceFile& file) {
    const std::string beside = path + ".part";
    {
        std::ofstream out(beside, std::ios::binary);
        ReferenceHeader header{};
        std::memcpy(header.magic, reference_magic, 8);
        header.width = file.image.width;
        header.height = file.image.height;
        std::copy_n(file.image.samples_of, 2, header.samples_of);
        header.next_sample = file.next_sample;
        header.note_length = file.note.size();
        out.write(reinterpret_cast<const char*>(&header), sizeof header);
        out.write(file.note.data(), static_cast<std::streamsize>(file.note.size()));
        const auto bytes = static_cast<std::streamsize>(file.image.squares.size() * sizeof(double));
        out.write(reinterpret_cast<const char*>(file.image.sum[0].data()), 3 * bytes);
        out.write(reinterpret_cast<const char*>(file.image.sum[1].data()), 3 * bytes);
        out.write(reinterpret_cast<const char*>(file.image.squares.data()), bytes);
        if (!out.flush()) {
            return Error{"cannot be written", beside, "a writable path with room on the disk"};
        }
    }
    if (std::rename(beside.c_str(), path.c_str()) != 0) {
        return Error{"cannot be replaced", path, "a writable path"};
    }
    return Ok{};
}

Result<ReferenceFile> load_reference(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        return Error{"no such file", path, "a picture that alpenglow-cloud-reference wrote"};
    }
    ReferenceHeader header{};
    if (!in.read(reinterpret_cast<char*>(&header), sizeof header) ||
        std::memcmp(header.magic, reference_magic, 8) != 0 || header.width <= 0 || header.height <= 0 ||
        header.width > 16384 || header.height > 16384 || header.note_length > 65536) {
        return Error{"no reference picture: wrong magic number or header", path,
                     "a picture that alpenglow-cloud-reference wrote"};
    }
    ReferenceFile file;
    file.image = ReferenceImage(header.width, header.height);
    std::copy_n(header.samples_of, 2, file.image.samples_of);
    file.next_sample = header.next_sample;
    file.note.resize(header.note_length);
    in.read(file.note.data(), static_cast<std::streamsize>(header.note_length));
    const auto bytes = static_cast<std::streamsize>(file.image.squares.size() * sizeof(double));
    in.read(reinterpret_cast<char*>(file.image.sum[0].data()), 3 * bytes);
    in.read(reinterpret_cast<char*>(file.image.sum[1].data()), 3 * bytes);
    if (!in.read(reinterpret_cast<char*>(file.image.squares.data()), bytes)) {
        return Error{"truncated", path, "a whole picture; delete it and render again"};
    }
    return file;
}

ImageError image_error(const std::vector<glm::vec3>& image, const ReferenceImage& reference,
                       const std::vector<bool>& mask) {
    assert(image.size() == reference.squares.size() && mask.size() == image.size());
    double error = 0.0;
    double norm = 0.0;
    double sum_a = 0.0;
    double sum_r = 0.0;
    double noise = 0.0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        if (mask[i]) {
            const double a = luminance(glm::dvec3(image[i]));
            const double r1 = luminance(reference.mean_of_half(0, i));
            const double r2 = luminance(reference.mean_of_half(1, i));
            error += (a - r1) * (a - r2);
            norm += r1 * r2;
            sum_a += a;
            sum_r += luminance(reference.mean(i));
            noise += reference.standard_error(i) * reference.standard_error(i);
        }
    }
    if (!(norm > 0.0)) {
        return {};
    }
    return {std::sqrt(std::max(0.0, error) / norm), sum_a / sum_r - 1.0, std::sqrt(noise / norm)};
}

} // namespace alpenglow::clouds
