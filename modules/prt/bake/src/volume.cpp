#include <alpenglow/prt/bake_volume.hpp>

#include "directions.hpp"
#include "hemisphere.hpp"
#include "ticker.hpp"

#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/prt/hash.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::prt {
namespace {

constexpr std::size_t grain = 64;

// Trilinear, zero outside; `at` in grid units.
float density_at(const VolumeDensity& density, const glm::vec3& at) {
    const glm::ivec3 size(density.grid.size);
    const glm::vec3 low = glm::floor(at);
    const glm::vec3 f = at - low;
    const glm::ivec3 i(low);
    float sum = 0.0F;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 c = i + glm::ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= size.x || c.y >= size.y || c.z >= size.z) {
            continue;
        }
        const float w = ((corner & 1) != 0 ? f.x : 1.0F - f.x) * ((corner & 2) != 0 ? f.y : 1.0F - f.y) *
                        ((corner & 4) != 0 ? f.z : 1.0F - f.z);
        sum += w * density.extinction_per_m[static_cast<std::size_t>(c.x + size.x * (c.y + size.y * c.z))];
    }
    return sum;
}

// Where a ray from inside leaves the grid and its outermost half-cells, in steps of `direction`.
float exit_distance(const glm::vec3& at, const glm::vec3& direction, const glm::vec3& size) {
    float t = 1e30F;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] > 1e-12F) {
            t = std::min(t, (size[axis] - at[axis]) / direction[axis]);
        } else if (direction[axis] < -1e-12F) {
            t = std::min(t, (-1.0F - at[axis]) / direction[axis]);
        }
    }
    return std::max(t, 0.0F);
}

Status check(const VolumeDensity& density, const VolumeSettings& s) {
    const glm::uvec3 size = density.grid.size;
    const auto wrong = [](const std::string& what, const std::string& where, const std::string& expected) {
        return Error{what, where, expected};
    };
    if (size.x < 1 || size.y < 1 || size.z < 1 || size.x > 4096 || size.y > 4096 || size.z > 4096) {
        return wrong(std::to_string(size.x) + " x " + std::to_string(size.y) + " x " + std::to_string(size.z),
                     "volume grid", "1 .. 4096 points along each axis");
    }
    const std::size_t count = std::size_t{size.x} * size.y * size.z;
    if (density.extinction_per_m.size() != count) {
        return wrong(std::to_string(density.extinction_per_m.size()) + " values", "volume density",
                     std::to_string(count));
    }
    const glm::vec3 step = density.grid.step_m;
    if (!(step.x > 0.0F && step.y > 0.0F && step.z > 0.0F && step.x < 1e9F && step.y < 1e9F && step.z < 1e9F)) {
        return wrong("step is not positive", "volume grid", "metres, above 0");
    }
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
        const float e = density.extinction_per_m[i];
        if (!(e >= 0.0F && e < 1e20F)) {
            return wrong("extinction is " + std::to_string(e), "volume density, point " + std::to_string(i),
                         "0 or more, finite");
        }
        any = any || e > 0.0F;
    }
    if (!any) {
        return wrong("is empty: every extinction is 0", "volume density", "one point above 0");
    }
    if (s.order < 1 || s.order > 6 || s.directions < 8 || !(s.albedo >= 0.0F && s.albedo <= 1.0F)) {
        return wrong("order " + std::to_string(s.order) + ", directions " + std::to_string(s.directions) + ", albedo " +
                         std::to_string(s.albedo),
                     "volume settings", "1 .. 6, 8 or more, 0 .. 1");
    }
    return Ok{};
}

std::uint64_t density_hash(const VolumeDensity& density) {
    Hasher hasher;
    hasher.add_values(std::span<const float>(density.extinction_per_m));
    return hasher.digest();
}

std::uint64_t settings_hash(const VolumeDensity& density, const VolumeSettings& s) {
    Hasher hasher;
    const auto add = [&](const auto& value) { hasher.add(std::as_bytes(std::span(&value, 1))); };
    add(density.grid);
    add(s.order);
    add(s.directions);
    add(s.albedo);
    add(s.max_bounces);
    add(s.stop_energy);
    return hasher.digest();
}

// The rays of every voxel and what they meet.
class Walker {
public:
    Walker(const VolumeDensity& density, const VolumeSettings& s)
        : density_(density), s_(s), size_(density.grid.size), n_(static_cast<std::size_t>(s.order * s.order)),
          ds_(0.5F * std::min({density.grid.step_m.x, density.grid.step_m.y, density.grid.step_m.z})) {
        std::array<double, sh::max_coefficients> y{};
        for (const glm::dvec3& d : fibonacci_sphere(s.directions)) {
            Ray& ray = rays_.emplace_back();
            ray.per_step = glm::vec3(d) * ds_ / density.grid.step_m;
            sh::evaluate_basis(s.order, d, y);
            for (std::size_t i = 0; i < n_; ++i) {
                ray.y.values[i] = static_cast<float>(y[i]);
            }
        }
        used_.assign(density.extinction_per_m.size(), 0);
        for (std::size_t i = 0; i < used_.size(); ++i) {
            if (density.extinction_per_m[i] <= 0.0F) {
                continue;
            }
            const glm::ivec3 c(point_of(i));
            for (int k = 0; k < 27; ++k) {
                const glm::ivec3 q = c + glm::ivec3(k % 3, k / 3 % 3, k / 9) - 1;
                if (glm::all(glm::greaterThanEqual(q, glm::ivec3(0))) &&
                    glm::all(glm::lessThan(q, glm::ivec3(size_)))) {
                    used_[index_of(q)] = 1;
                }
            }
        }
    }

    // Rays of points [first, first + count): those with something in the cells around.
    [[nodiscard]] std::uint64_t rays(std::size_t first, std::size_t count) const {
        const auto from = used_.begin() + static_cast<std::ptrdiff_t>(first);
        return static_cast<std::uint64_t>(std::count(from, from + static_cast<std::ptrdiff_t>(count), 1)) *
               rays_.size();
    }

    // [point][coefficient] of points [first, first + count): what arrives from outside (`from` null), or what was
    // there, `from` of all points, and scatters once more. False if cancelled.
    bool pass(std::size_t first, std::size_t count, const std::vector<float>* from, Ticker& ticker,
              std::vector<float>& out) const {
        const float weight = 1.0F / static_cast<float>(rays_.size());
        parallel_for(
            count, grain,
            [&](std::size_t begin, std::size_t end) {
                CoefficientRow sum;
                for (std::size_t k_point = begin; k_point < end && !ticker.cancelled(); ++k_point) {
                    const std::size_t i = first + k_point;
                    ticker.done(1);
                    if (used_[i] == 0) {
                        continue;
                    }
                    sum = {};
                    const glm::vec3 at = point_of(i);
                    for (const Ray& ray : rays_) {
                        if (from == nullptr) {
                            const float through = walk(at, ray, [](const glm::vec3&, float) {});
                            for (std::size_t k = 0; k < n_; ++k) {
                                sum.values[k] += through * ray.y.values[k];
                            }
                            continue;
                        }
                        walk(at, ray, [&](const glm::vec3& q, float share) {
                            // The nearest point that carries transfer.
                            const glm::ivec3 c =
                                glm::clamp(glm::ivec3(glm::round(q)), glm::ivec3(0), glm::ivec3(size_) - 1);
                            const float* m = from->data() + n_ * index_of(c);
                            for (std::size_t k = 0; k < n_; ++k) {
                                sum.values[k] += share * m[k];
                            }
                        });
                    }
                    const float scale = from == nullptr ? weight : weight * s_.albedo;
                    for (std::size_t k = 0; k < n_; ++k) {
                        out[k_point * n_ + k] = scale * sum.values[k];
                    }
                }
            },
            s_.threads);
        return !ticker.cancelled();
    }

private:
    // Directions in metres and in grid units; a step is half the smallest cell.
    struct Ray {
        glm::vec3 per_step;
        CoefficientRow y;
    };
    [[nodiscard]] glm::vec3 point_of(std::size_t i) const {
        return {static_cast<float>(i % size_.x), static_cast<float>(i / size_.x % size_.y),
                static_cast<float>(i / size_.x / size_.y)};
    }
    [[nodiscard]] std::size_t index_of(const glm::ivec3& c) const {
        return static_cast<std::size_t>(c.x) +
               size_.x * (static_cast<std::size_t>(c.y) + std::size_t{size_.y} * static_cast<std::size_t>(c.z));
    }
    // Walks a ray: visit(position, share of the light of this direction that scatters here) step by step; returns what
    // comes through. Shares and the rest add up to 1, so that albedo 1 loses nothing.
    template <class Visit>
    float walk(const glm::vec3& from, const Ray& ray, const Visit& visit) const {
        const float end = exit_distance(from, ray.per_step, glm::vec3(size_));
        float through = 1.0F;
        for (float t = 0.0F; t < end && through > 1e-4F; t += 1.0F) {
            const float length = std::min(1.0F, end - t);
            const glm::vec3 at = from + (t + 0.5F * length) * ray.per_step;
            const float extinction = density_at(density_, at);
            if (extinction > 0.0F) {
                const float scattered = -std::expm1(-extinction * ds_ * length) * through;
                visit(at, scattered);
                through -= scattered;
            }
        }
        return through;
    }

    const VolumeDensity& density_;
    const VolumeSettings& s_;
    glm::uvec3 size_;
    std::size_t n_;
    float ds_;
    std::vector<Ray> rays_;
    std::vector<std::uint8_t> used_;
};

bool bounces(const VolumeSettings& s) {
    return s.max_bounces > 0 && s.albedo > 0.0F;
}

} // namespace

Result<FieldPart> bake_volume_part(const VolumeDensity& density, const VolumeSettings& s, std::size_t first,
                                   std::size_t count) {
    if (const Status status = check(density, s); !status) {
        return status.error();
    }
    assert(first + count <= density.extinction_per_m.size());
    FieldPart part;
    part.kind = TransferKind::volume;
    part.input_hash = density_hash(density);
    part.settings_hash = settings_hash(density, s);
    part.first = first;
    part.count = count;
    part.values.resize(count * static_cast<std::size_t>(s.order * s.order));
    const double cpu = process_cpu_seconds();
    const Walker walker(density, s);
    Ticker ticker(s.progress, "rays", 0.0, bounces(s) ? 0.3 : 1.0, count);
    if (!walker.pass(first, count, nullptr, ticker, part.values)) {
        return Error{"cancelled", "bake", ""};
    }
    part.rays = walker.rays(first, count);
    part.cpu_s = process_cpu_seconds() - cpu;
    return part;
}

Result<Bake> bake_volume(const VolumeDensity& density, const VolumeSettings& s) {
    const double start = wall_seconds();
    if (const Status status = check(density, s); !status) {
        return status.error();
    }
    Result<FieldPart> part = bake_volume_part(density, s, 0, density.extinction_per_m.size());
    if (!part) {
        return part.error();
    }
    std::vector<FieldPart> parts;
    parts.push_back(std::move(part).value());
    Result<Bake> baked = finish_volume(density, s, std::move(parts));
    if (baked) {
        baked->report.wall_s = wall_seconds() - start;
    }
    return baked;
}

Result<Bake> finish_volume(const VolumeDensity& density, const VolumeSettings& s, std::vector<FieldPart> parts) {
    const double start = wall_seconds();
    if (const Status status = check(density, s); !status) {
        return status.error();
    }
    const std::size_t count = density.extinction_per_m.size();
    Bake result;
    TransferField& field = result.field;
    field.kind = TransferKind::volume;
    field.order = s.order;
    field.count = count;
    field.grid = density.grid;
    field.mesh_hash = density_hash(density);
    const std::size_t n = field.width();
    Result<FieldPart> all = joined(std::move(parts), field.kind, field.mesh_hash, settings_hash(density, s), count, n);
    if (!all) {
        return all.error();
    }
    field.values = std::move(all->values);
    BakeReport& report = result.report;
    report.points = count;
    report.shadow_rays = all->rays;
    report.rays_cpu_s = all->cpu_s;
    const double cpu = process_cpu_seconds();
    const auto energy = [&](const std::vector<float>& values) {
        double sum = 0.0;
        for (std::size_t i = 0; i < count; ++i) {
            sum += static_cast<double>(values[i * n] * density.extinction_per_m[i]);
        }
        return sum;
    };
    const double direct = energy(field.values);
    if (bounces(s) && direct > 0.0) {
        const Walker walker(density, s);
        std::vector<float> from = field.values;
        std::vector<float> to(from.size(), 0.0F);
        for (int b = 1; b <= s.max_bounces; ++b) {
            Ticker ticker(s.progress, "bounces", 0.3, 1.0, count);
            if (!walker.pass(0, count, &from, ticker, to)) {
                return Error{"cancelled", "bake", ""};
            }
            for (std::size_t i = 0; i < to.size(); ++i) {
                field.values[i] += to[i];
            }
            report.bounce_energy.push_back(energy(to) / direct);
            from.swap(to);
            if (report.bounce_energy.back() < s.stop_energy) {
                break;
            }
        }
    }
    report.bounces_cpu_s = process_cpu_seconds() - cpu;
    report.wall_s = wall_seconds() - start;
    return result;
}

} // namespace alpenglow::prt
