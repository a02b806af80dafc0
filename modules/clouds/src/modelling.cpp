#include <alpenglow/clouds/modelling.hpp>

#include "noise.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>

#include <cassert>
#include <functional>

namespace alpenglow::clouds {
namespace {

using DensityFunction = std::function<float(float x, float y, float z)>;

// Evaluates density(x, y, z), in metres, at the voxel centres of [low, high] (voxel indices), brick by brick.
SparseGrid fill(const glm::ivec3& low, const glm::ivec3& high, float voxel_m, const DensityFunction& density) {
    GridTransform transform;
    transform.voxel_m = glm::dvec3(voxel_m);
    SparseGrid grid(low, high - low + 1, transform);
    const glm::ivec3 bricks = grid.table().bricks();
    const auto count =
        static_cast<std::size_t>(bricks.x) * static_cast<std::size_t>(bricks.y) * static_cast<std::size_t>(bricks.z);
    std::vector<std::vector<float>> made(count);
    parallel_for(count, 4, [&](std::size_t begin, std::size_t end) {
        std::vector<float> values(512);
        for (std::size_t b = begin; b < end; ++b) {
            const int bx = static_cast<int>(b % static_cast<std::size_t>(bricks.x));
            const int by =
                static_cast<int>(b / static_cast<std::size_t>(bricks.x) % static_cast<std::size_t>(bricks.y));
            const int bz =
                static_cast<int>(b / static_cast<std::size_t>(bricks.x) / static_cast<std::size_t>(bricks.y));
            const glm::ivec3 first = grid.min() + glm::ivec3(bx, by, bz) * 8;
            bool any = false;
            for (int i = 0; i < 512; ++i) {
                const glm::ivec3 v = first + glm::ivec3(i & 7, (i >> 3) & 7, i >> 6);
                const bool inside =
                    v.x >= low.x && v.y >= low.y && v.z >= low.z && v.x <= high.x && v.y <= high.y && v.z <= high.z;
                const float d = inside ? density(static_cast<float>(v.x) * voxel_m, static_cast<float>(v.y) * voxel_m,
                                                 static_cast<float>(v.z) * voxel_m)
                                       : 0.0F;
                values[static_cast<std::size_t>(i)] = d > 1e-4F ? d : 0.0F;
                any = any || d > 1e-4F;
            }
            if (any) {
                made[b] = values;
            }
        }
    });
    for (std::size_t b = 0; b < count; ++b) {
        if (!made[b].empty()) {
            const int bx = static_cast<int>(b % static_cast<std::size_t>(bricks.x));
            const int by =
                static_cast<int>(b / static_cast<std::size_t>(bricks.x) % static_cast<std::size_t>(bricks.y));
            const int bz =
                static_cast<int>(b / static_cast<std::size_t>(bricks.x) / static_cast<std::size_t>(bricks.y));
            std::copy(made[b].begin(), made[b].end(), grid.brick(bx, by, bz));
        }
    }
    return grid;
}

glm::ivec3 floor_div(const glm::vec3& p, float voxel) {
    return {static_cast<int>(std::floor(p.x / voxel)), static_cast<int>(std::floor(p.y / voxel)),
            static_cast<int>(std::floor(p.z / voxel))};
}

struct Puff {
    glm::vec3 centre;
    float radius;
};

// Signed distance to a smooth union of balls, negative inside.
float puffs_distance(std::span<const Puff> puffs, float x, float y, float z, float blend) {
    float distance = 1e9F;
    for (const Puff& puff : puffs) {
        const float dx = x - puff.centre.x;
        const float dy = y - puff.centre.y;
        const float dz = z - puff.centre.z;
        const float d = std::sqrt(dx * dx + dy * dy + dz * dz) - puff.radius;
        const float h = std::max(blend - std::abs(distance - d), 0.0F) / blend;
        distance = std::min(distance, d) - h * h * blend * 0.25F;
    }
    return distance;
}

// Balls on balls: each generation sits on the surface of the last, mostly on its upper side.
void grow(std::vector<Puff>& puffs, const Puff& parent, int generation, std::uint32_t& seed) {
    if (generation == 0) {
        return;
    }
    const int children = 5;
    for (int i = 0; i < children; ++i) {
        const auto next = [&] { return unit_float(seed = hash(seed + 0x632be5abU)); };
        const float azimuth =
            static_cast<float>(two_pi) * (static_cast<float>(i) + next()) / static_cast<float>(children);
        const float sine = -0.35F + 1.3F * next();
        const float up = std::clamp(sine, -0.3F, 0.95F);
        const float flat = std::sqrt(1.0F - up * up);
        const float radius = parent.radius * (0.42F + 0.2F * next());
        const glm::vec3 out(flat * std::cos(azimuth), flat * std::sin(azimuth), up);
        const Puff child{parent.centre + out * (parent.radius * 0.92F), radius};
        puffs.push_back(child);
        grow(puffs, child, generation - 1, seed);
    }
}

// One tower with a flat base at z = 0: balls, bulged by Worley noise and frayed by Perlin noise.
class Cumulus {
public:
    Cumulus(std::vector<Puff> puffs, float size, float base, std::uint32_t seed)
        : puffs_(std::move(puffs)), size_(size), base_(base), seed_(seed) {
        low_ = glm::vec3(1e9F);
        high_ = glm::vec3(-1e9F);
        for (const Puff& p : puffs_) {
            for (int a = 0; a < 3; ++a) {
                low_[a] = std::min(low_[a], p.centre[a] - p.radius - bulge());
                high_[a] = std::max(high_[a], p.centre[a] + p.radius + bulge());
            }
        }
        low_.z = std::max(low_.z, base_ - 0.03F * size_);
    }

    [[nodiscard]] float density(float x, float y, float z) const {
        if (x < low_.x || y < low_.y || z < low_.z || x > high_.x || y > high_.y || z > high_.z) {
            return 0.0F;
        }
        float d = puffs_distance(puffs_, x, y, z, 0.04F * size_);
        if (d > bulge()) {
            return 0.0F;
        }
        if (d > -2.0F * bulge()) {
            const float f = 8.0F / size_;
            const float bumps = 0.6F * worley(x * f, y * f, z * f, seed_) +
                                0.28F * worley(x * f * 2.2F, y * f * 2.2F, z * f * 2.2F, seed_ + 1) +
                                0.12F * worley(x * f * 4.7F, y * f * 4.7F, z * f * 4.7F, seed_ + 2);
            d += bulge() * (2.4F * bumps - 1.0F);
            d += 0.012F * size_ * perlin(x * f * 3.0F, y * f * 3.0F, z * f * 3.0F, seed_ + 3);
        }
        // Fray the base, and let density rise inwards over a few per cent of the size.
        const float frayed = base_ + 0.02F * size_ * perlin(x * 10.0F / size_, y * 10.0F / size_, 0.0F, seed_ + 4);
        const float over_base = smoothstep(frayed - 0.02F * size_, frayed + 0.03F * size_, z);
        const float inside = smoothstep(0.0F, 0.06F * size_, -d);
        const float lumps = 0.8F + 0.25F * perlin(x * 14.0F / size_, y * 14.0F / size_, z * 14.0F / size_, seed_ + 5);
        return std::clamp(over_base * inside * lumps, 0.0F, 1.0F);
    }

    [[nodiscard]] const glm::vec3& low() const { return low_; }
    [[nodiscard]] const glm::vec3& high() const { return high_; }

private:
    [[nodiscard]] float bulge() const { return 0.05F * size_; }
    std::vector<Puff> puffs_;
    float size_; // metres
    float base_;
    std::uint32_t seed_;
    glm::vec3 low_, high_;
};

Cumulus tower(const glm::vec3& base_centre, float width, float height, float lean, std::uint32_t seed) {
    std::vector<Puff> puffs;
    const auto next = [&] { return unit_float(seed = hash(seed + 0x632be5abU)); };
    const float r = 0.25F * std::min(width, 1.6F * height);
    const int stems = 3;
    for (int i = 0; i < stems; ++i) {
        const float t = (static_cast<float>(i) + 0.5F) / static_cast<float>(stems) - 0.5F;
        const float rise = 0.25F + 0.35F * next() * (1.0F - std::abs(t));
        const Puff stem{base_centre + glm::vec3(t * 0.55F * width + lean * rise * height,
                                                (next() - 0.5F) * 0.45F * width, rise * height),
                        r * (0.75F + 0.35F * next())};
        puffs.push_back(stem);
        grow(puffs, stem, 2, seed);
    }
    return {std::move(puffs), 0.7F * std::max(width, height), base_centre.z, seed};
}

} // namespace

SparseGrid cumulus_of_study(std::uint32_t seed) {
    const Cumulus cloud = tower({0.0F, 0.0F, 0.0F}, 125.0F, 103.0F, 0.05F, seed * 7919U + 12U);
    // Longer in y than in x: evaluate in a squeezed frame.
    const float stretch = 1.36F;
    const glm::vec3 low = cloud.low() * glm::vec3(1.0F, stretch, 1.0F);
    const glm::vec3 high = cloud.high() * glm::vec3(1.0F, stretch, 1.0F);
    return fill(floor_div(low, 1.0F), floor_div(high, 1.0F) + 1, 1.0F,
                [&](float x, float y, float z) { return cloud.density(x, y / stretch, z); });
}

SparseGrid noise_cloud(std::uint32_t seed, int voxels) {
    const auto n = static_cast<float>(voxels);
    return fill({0, 0, 0}, glm::ivec3(voxels - 1), 1.0F, [=](float x, float y, float z) {
        const float u = 2.0F * x / n - 1.0F;
        const float v = 2.0F * y / n - 1.0F;
        const float w = 2.0F * z / n - 1.0F;
        const float radius = std::sqrt(u * u + v * v + w * w);
        if (radius > 1.0F) {
            return 0.0F;
        }
        float noise = 0.0F;
        float amplitude = 0.5F;
        for (std::uint32_t octave = 0; octave < 4; ++octave) {
            const float f = 3.0F * static_cast<float>(1U << octave);
            noise += amplitude * perlin(u * f, v * f, w * f, seed + octave);
            amplitude *= 0.5F;
        }
        return std::clamp(1.6F * (noise + 0.55F - 0.75F * radius), 0.0F, 1.0F);
    });
}

SparseGrid generate(const Weather& weather, const glm::vec2& extent_m, float voxel_m) {
    assert(voxel_m > 0.0F && weather.top_m > weather.base_m && weather.cover >= 0.0F && weather.cover <= 1.0F);
    const float height = weather.top_m - weather.base_m;
    assert(extent_m.x / voxel_m <= 2048.0F && extent_m.y / voxel_m <= 2048.0F && height / voxel_m <= 2048.0F);
    const glm::vec3 low(-0.5F * extent_m.x, -0.5F * extent_m.y, weather.base_m);
    const glm::vec3 high(0.5F * extent_m.x, 0.5F * extent_m.y, weather.top_m);
    const glm::ivec3 first = floor_div(low, voxel_m);
    const glm::ivec3 last = floor_div(high, voxel_m);
    const std::uint32_t seed = weather.seed * 0x9e3779b1U + 17U;
    if (weather.cover <= 0.0F) {
        GridTransform transform;
        transform.voxel_m = glm::dvec3(voxel_m);
        return SparseGrid(first, {0, 0, 0}, transform);
    }

    if (weather.type == CloudType::cumulus) {
        // Towers are added, the biggest first, until the discs under them cover what is asked.
        std::vector<Cumulus> towers;
        const int n = 96;
        std::vector<bool> covered(static_cast<std::size_t>(n) * n, false);
        std::size_t filled = 0;
        std::uint32_t state = seed;
        const auto next = [&] { return unit_float(state = hash(state + 0x632be5abU)); };
        const auto wanted = static_cast<std::size_t>(weather.cover * static_cast<float>(covered.size()));
        const float widest = std::min({1.6F * height, 0.45F * extent_m.x, 0.45F * extent_m.y});
        for (int attempt = 0; attempt < 600 && filled < wanted; ++attempt) {
            const float left = static_cast<float>(wanted - filled) / static_cast<float>(covered.size());
            const float fits = std::sqrt(left * extent_m.x * extent_m.y) * 1.1F;
            const float width = std::max(std::min(widest * (1.0F - 0.5F * next()), fits), 6.0F * voxel_m);
            // The whole cloud stays inside the rectangle as far as it fits.
            const float reach = std::min(0.5F * width, 0.5F * std::min(extent_m.x, extent_m.y));
            const glm::vec3 at(low.x + reach + (extent_m.x - 2.0F * reach) * next(),
                               low.y + reach + (extent_m.y - 2.0F * reach) * next(), low.z);
            const float tall = std::min(height, 0.9F * width) / 1.15F;
            const Cumulus cloud = tower(
                at, width, tall,
                0.01F * std::sqrt(weather.wind_m_s.x * weather.wind_m_s.x + weather.wind_m_s.y * weather.wind_m_s.y),
                hash(state));
            // What it covers, sampled through its column.
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i) {
                    const float x = low.x + extent_m.x * (static_cast<float>(i) + 0.5F) / n;
                    const float y = low.y + extent_m.y * (static_cast<float>(j) + 0.5F) / n;
                    const std::size_t cell = static_cast<std::size_t>(j) * n + static_cast<std::size_t>(i);
                    if (covered[cell] || x < cloud.low().x || x > cloud.high().x || y < cloud.low().y ||
                        y > cloud.high().y) {
                        continue;
                    }
                    for (int k = 0; k < 8; ++k) {
                        const float z =
                            low.z + (static_cast<float>(k) + 0.5F) / 8.0F * std::min(height, cloud.high().z - low.z);
                        if (cloud.density(x, y, z) > 0.01F) {
                            covered[cell] = true;
                            ++filled;
                            break;
                        }
                    }
                }
            }
            towers.push_back(cloud);
        }
        return fill(first, last, voxel_m, [&](float x, float y, float z) {
            float d = 0.0F;
            for (const Cumulus& t : towers) {
                d = std::max(d, t.density(x, y, z));
            }
            return d;
        });
    }

    // Layers: a plane field decides where there is cloud; its quantile gives the cover.
    const bool cirrus = weather.type == CloudType::cirrus;
    const float wind = std::sqrt(weather.wind_m_s.x * weather.wind_m_s.x + weather.wind_m_s.y * weather.wind_m_s.y);
    const glm::vec2 along = wind > 0.0F ? weather.wind_m_s / wind : glm::vec2(1.0F, 0.0F);
    const float scale = cirrus ? 0.9F * height : 2.0F * height;
    const float stretched = cirrus ? 5.0F : 1.0F; // cirrus is drawn out along the wind
    const auto plane = [=](float x, float y) {
        const float u = (x * along.x + y * along.y) / (scale * stretched);
        const float v = (y * along.x - x * along.y) / scale;
        float sum = 0.0F;
        float amplitude = 0.5F;
        for (std::uint32_t octave = 0; octave < 4; ++octave) {
            const float f = static_cast<float>(1U << octave);
            sum += amplitude * perlin(u * f, v * f, 0.37F, seed + octave);
            amplitude *= 0.55F;
        }
        return sum;
    };
    std::vector<float> samples;
    for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
            samples.push_back(plane(low.x + extent_m.x * (static_cast<float>(i) + 0.5F) / 64.0F,
                                    low.y + extent_m.y * (static_cast<float>(j) + 0.5F) / 64.0F));
        }
    }
    std::sort(samples.begin(), samples.end());
    const auto cut = static_cast<std::size_t>((1.0F - weather.cover) * static_cast<float>(samples.size() - 1));
    const float threshold = weather.cover >= 1.0F ? samples.front() - 0.2F : samples[cut];
    return fill(first, last, voxel_m, [=](float x, float y, float z) {
        const float t = (z - low.z) / height;
        if (cirrus) {
            // Fall streaks: lower ice lags behind, against the wind.
            const float lag = (1.0F - t) * 1.5F * height;
            const float excess = plane(x + along.x * lag, y + along.y * lag) - threshold;
            const float fibres =
                0.6F + 0.4F * perlin((x * along.x + y * along.y) / (2.0F * scale),
                                     (y * along.x - x * along.y) / (0.08F * scale), z / (0.5F * height), seed + 9);
            const float profile = smoothstep(0.0F, 0.2F, t) * smoothstep(1.0F, 0.6F, t);
            return std::clamp(1.2F * smoothstep(0.0F, 0.3F, excess) * fibres * profile, 0.0F, 1.0F) * 0.3F;
        }
        const float excess = plane(x, y) - threshold;
        if (excess <= 0.0F) {
            return 0.0F;
        }
        const float depth = 0.4F + 0.6F * smoothstep(0.0F, 0.15F, excess); // thinner towards gaps
        const float billow = 0.15F * worley(x / (0.5F * height), y / (0.5F * height), z / (0.5F * height), seed + 7);
        const float half = 0.5F * depth;
        const float d = std::abs(t - 0.45F) + billow - half * 0.9F;
        return std::clamp(smoothstep(0.0F, 0.25F, -d) * (0.75F + 0.25F * perlin(x / height * 2.0F, y / height * 2.0F,
                                                                                z / height * 2.0F, seed + 8)),
                          0.0F, 1.0F);
    });
}

namespace {

float particles_density(std::span<const Particle> particles, std::span<const std::uint32_t> near, const glm::vec3& p,
                        float max_density) {
    float sum = 0.0F;
    for (const std::uint32_t i : near) {
        const Particle& q = particles[i];
        const glm::vec3 d = p - q.centre_m;
        const float s = 1.0F - (d.x * d.x + d.y * d.y + d.z * d.z) / (q.radius_m * q.radius_m);
        if (s > 0.0F) {
            sum += q.density * s * s * s;
        }
    }
    return std::min(sum, max_density);
}

bool touches(const Particle& p, const glm::vec3& low, const glm::vec3& high) {
    float distance2 = 0.0F;
    for (int a = 0; a < 3; ++a) {
        const float d = std::max({low[a] - p.centre_m[a], p.centre_m[a] - high[a], 0.0F});
        distance2 += d * d;
    }
    return distance2 < p.radius_m * p.radius_m;
}

void rasterise_brick(float* values, const glm::ivec3& first, std::span<const Particle> particles,
                     std::span<const std::uint32_t> near, float voxel, float max_density) {
    for (int i = 0; i < 512; ++i) {
        const glm::vec3 p = glm::vec3(first + glm::ivec3(i & 7, (i >> 3) & 7, i >> 6)) * voxel;
        values[i] = particles_density(particles, near, p, max_density);
    }
}

} // namespace

SparseGrid rasterise(std::span<const Particle> particles, float voxel_m, float max_density) {
    assert(voxel_m > 0.0F);
    GridTransform transform;
    transform.voxel_m = glm::dvec3(voxel_m);
    if (particles.empty()) {
        return SparseGrid({0, 0, 0}, {0, 0, 0}, transform);
    }
    glm::vec3 low(1e30F);
    glm::vec3 high(-1e30F);
    for (const Particle& p : particles) {
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p.centre_m[a] - p.radius_m);
            high[a] = std::max(high[a], p.centre_m[a] + p.radius_m);
        }
    }
    const glm::ivec3 first = floor_div(low, voxel_m);
    SparseGrid grid(first, floor_div(high, voxel_m) - first + 2, transform);
    const glm::ivec3 bricks = grid.table().bricks();
    std::vector<std::uint32_t> near;
    for (int bz = 0; bz < bricks.z; ++bz) {
        for (int by = 0; by < bricks.y; ++by) {
            for (int bx = 0; bx < bricks.x; ++bx) {
                const glm::ivec3 corner = grid.min() + glm::ivec3(bx, by, bz) * 8;
                near.clear();
                for (std::uint32_t i = 0; i < particles.size(); ++i) {
                    if (touches(particles[i], glm::vec3(corner) * voxel_m, glm::vec3(corner + 7) * voxel_m)) {
                        near.push_back(i);
                    }
                }
                if (!near.empty()) {
                    rasterise_brick(grid.brick(bx, by, bz), corner, particles, near, voxel_m, max_density);
                }
            }
        }
    }
    return grid;
}

std::size_t update_rasterised(SparseGrid& grid, std::vector<Particle>& before, std::span<const Particle> after,
                              float tolerance_m, float max_density) {
    assert(before.size() == after.size());
    std::vector<Particle> moved; // old and new places of what changed
    for (std::size_t i = 0; i < after.size(); ++i) {
        const glm::vec3 d = after[i].centre_m - before[i].centre_m;
        const float change =
            std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) + std::abs(after[i].radius_m - before[i].radius_m);
        if (change > tolerance_m || after[i].density != before[i].density) {
            moved.push_back(before[i]);
            moved.push_back(after[i]);
            before[i] = after[i];
        }
    }
    if (moved.empty()) {
        return 0;
    }
    const auto voxel = static_cast<float>(grid.transform().voxel_m.x);
    // Grow the grid if a particle left it.
    glm::ivec3 low = grid.min();
    glm::ivec3 high = grid.min() + grid.table().bricks() * 8 - 1;
    const glm::ivec3 old_low = low;
    const glm::ivec3 old_high = high;
    for (const Particle& p : before) {
        const glm::ivec3 a = floor_div(p.centre_m - p.radius_m, voxel);
        const glm::ivec3 b = floor_div(p.centre_m + p.radius_m, voxel) + 1;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], a[axis]);
            high[axis] = std::max(high[axis], b[axis]);
        }
    }
    if (low != old_low || high != old_high) {
        SparseGrid larger(low, high - low + 1, grid.transform());
        const glm::ivec3 shift = (grid.min() - larger.min()) / 8;
        for (std::int32_t b = 0; b < grid.table().count(); ++b) {
            const glm::ivec3 c = grid.table().coordinates()[static_cast<std::size_t>(b)] + shift;
            std::copy_n(grid.brick(b), 512, larger.brick(c.x, c.y, c.z));
        }
        grid = std::move(larger);
    }
    std::size_t updated = 0;
    std::vector<std::uint32_t> near;
    const glm::ivec3 bricks = grid.table().bricks();
    for (int bz = 0; bz < bricks.z; ++bz) {
        for (int by = 0; by < bricks.y; ++by) {
            for (int bx = 0; bx < bricks.x; ++bx) {
                const glm::ivec3 corner = grid.min() + glm::ivec3(bx, by, bz) * 8;
                const glm::vec3 a = glm::vec3(corner) * voxel;
                const glm::vec3 b = glm::vec3(corner + 7) * voxel;
                if (std::none_of(moved.begin(), moved.end(), [&](const Particle& p) { return touches(p, a, b); })) {
                    continue;
                }
                near.clear();
                for (std::uint32_t i = 0; i < before.size(); ++i) {
                    if (touches(before[i], a, b)) {
                        near.push_back(i);
                    }
                }
                if (!near.empty() || grid.table().find(bx, by, bz) >= 0) {
                    rasterise_brick(grid.brick(bx, by, bz), corner, before, near, voxel, max_density);
                    ++updated;
                }
            }
        }
    }
    return updated;
}

} // namespace alpenglow::clouds
