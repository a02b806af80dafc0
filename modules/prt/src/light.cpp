#include <alpenglow/prt/light.hpp>

#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace alpenglow::prt {

void to_object_frame(int order, const glm::quat& scene_from_object, std::span<const glm::vec3> in,
                     std::span<glm::vec3> out) {
    const sh::Rotation rotation(order, glm::conjugate(glm::dquat(scene_from_object)));
    rotation.apply(in, out);
}

Result<glm::quat> rotation_of(const glm::mat3& scene_from_object, float tolerance) {
    const glm::vec3 lengths{glm::length(scene_from_object[0]), glm::length(scene_from_object[1]),
                            glm::length(scene_from_object[2])};
    const float scale = (lengths.x + lengths.y + lengths.z) / 3.0F;
    if (!(scale > 0.0F) || !std::isfinite(scale)) {
        return Error{"a column has no length", "object transform", "a rotation with uniform scale"};
    }
    for (int i = 0; i < 3; ++i) {
        if (std::abs(lengths[i] / scale - 1.0F) > tolerance) {
            return Error{"scale is not uniform: " + std::to_string(lengths.x) + ", " + std::to_string(lengths.y) +
                             ", " + std::to_string(lengths.z),
                         "object transform", "a rotation with uniform scale; bake the scaled mesh instead"};
        }
        const int j = (i + 1) % 3;
        if (std::abs(glm::dot(scene_from_object[i], scene_from_object[j])) > tolerance * scale * scale) {
            return Error{"axes are not perpendicular", "object transform",
                         "a rotation with uniform scale; bake the sheared mesh instead"};
        }
    }
    if (glm::determinant(scene_from_object / scale) < 0.0F) {
        return Error{"is mirrored", "object transform",
                     "a rotation with uniform scale; bake the mirrored mesh instead"};
    }
    return glm::normalize(glm::quat_cast(scene_from_object / scale));
}

LightSamples light_samples(std::span<const glm::vec3> positions_m, std::size_t count) {
    LightSamples samples;
    if (positions_m.empty() || count == 0) {
        return samples;
    }
    const auto distance2 = [](const glm::vec3& a, const glm::vec3& b) { return glm::dot(a - b, a - b); };
    // Farthest-point start from the centre, then Lloyd iterations.
    glm::dvec3 centre(0.0);
    for (const glm::vec3& p : positions_m) {
        centre += glm::dvec3(p);
    }
    samples.points_m.emplace_back(centre / static_cast<double>(positions_m.size()));
    std::vector<float> nearest(positions_m.size(), std::numeric_limits<float>::max());
    while (samples.points_m.size() < count) {
        std::size_t farthest = 0;
        for (std::size_t i = 0; i < positions_m.size(); ++i) {
            nearest[i] = std::min(nearest[i], distance2(positions_m[i], samples.points_m.back()));
            if (nearest[i] > nearest[farthest]) {
                farthest = i;
            }
        }
        if (!(nearest[farthest] > 0.0F)) {
            break; // fewer distinct positions than samples
        }
        samples.points_m.push_back(positions_m[farthest]);
    }
    const std::size_t k = samples.points_m.size();
    std::vector<glm::dvec3> sums(k);
    std::vector<std::size_t> members(k);
    for (int iteration = 0; iteration < 24 && k > 1; ++iteration) {
        std::fill(sums.begin(), sums.end(), glm::dvec3(0.0));
        std::fill(members.begin(), members.end(), std::size_t{0});
        for (const glm::vec3& p : positions_m) {
            std::size_t best = 0;
            for (std::size_t c = 1; c < k; ++c) {
                if (distance2(p, samples.points_m[c]) < distance2(p, samples.points_m[best])) {
                    best = c;
                }
            }
            sums[best] += glm::dvec3(p);
            ++members[best];
        }
        float moved = 0.0F;
        for (std::size_t c = 0; c < k; ++c) {
            if (members[c] > 0) {
                const glm::vec3 mean(sums[c] / static_cast<double>(members[c]));
                moved = std::max(moved, distance2(mean, samples.points_m[c]));
                samples.points_m[c] = mean;
            }
        }
        if (moved == 0.0F) {
            break;
        }
    }
    // Blend by the inverse fourth power of the distance, softened by the samples' own spacing: smooth, local.
    float spacing2 = 0.0F;
    for (std::size_t a = 0; a < k; ++a) {
        float closest = k > 1 ? std::numeric_limits<float>::max() : 1.0F;
        for (std::size_t b = 0; b < k; ++b) {
            if (a != b) {
                closest = std::min(closest, distance2(samples.points_m[a], samples.points_m[b]));
            }
        }
        spacing2 += closest / static_cast<float>(k);
    }
    spacing2 = std::max(spacing2, std::numeric_limits<float>::min());
    samples.weights.resize(positions_m.size() * k);
    std::vector<double> totals(k, 0.0);
    for (std::size_t v = 0; v < positions_m.size(); ++v) {
        float sum = 0.0F;
        for (std::size_t c = 0; c < k; ++c) {
            const float d = distance2(positions_m[v], samples.points_m[c]) / spacing2 + 0.01F;
            samples.weights[v * k + c] = 1.0F / (d * d);
            sum += samples.weights[v * k + c];
        }
        for (std::size_t c = 0; c < k; ++c) {
            samples.weights[v * k + c] /= sum;
            totals[c] += static_cast<double>(samples.weights[v * k + c]);
        }
    }
    for (const double total : totals) {
        samples.mean_weights.push_back(static_cast<float>(total / static_cast<double>(positions_m.size())));
    }
    return samples;
}

void evaluate_varying(const TransferTable& table, const LightSamples& samples, int order,
                      std::span<const glm::vec3> lights, std::span<glm::vec3> out, std::vector<glm::vec3>& scratch) {
    const std::size_t k = samples.points_m.size();
    const auto n = static_cast<std::size_t>(order * order);
    assert(lights.size() >= k * n && out.size() >= table.info.count);
    assert(samples.weights.size() >= k * table.info.count);
    std::fill_n(out.begin(), table.info.count, glm::vec3(0.0F));
    scratch.resize(table.info.count);
    for (std::size_t c = 0; c < k; ++c) {
        evaluate(table, lights.subspan(c * n, n), scratch);
        for (std::size_t v = 0; v < table.info.count; ++v) {
            out[v] += samples.weights[v * k + c] * scratch[v];
        }
    }
}

void band_change(int order, std::span<const glm::vec3> a, std::span<const glm::vec3> b, std::span<float> out) noexcept {
    for (int l = 0; l < order; ++l) {
        glm::vec3 sum(0.0F);
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            const auto at = static_cast<std::size_t>(i);
            const glm::vec3 left = at < a.size() ? a[at] : glm::vec3(0.0F);
            const glm::vec3 right = at < b.size() ? b[at] : glm::vec3(0.0F);
            sum += (left - right) * (left - right);
        }
        out[static_cast<std::size_t>(l)] = std::sqrt(std::max({sum.x, sum.y, sum.z}));
    }
}

float change_bound(const TransferInfo& info, int order, std::span<const glm::vec3> made_from, const glm::quat& from,
                   std::span<const glm::vec3> now, const glm::quat& to) noexcept {
    const int bands = std::min(order, static_cast<int>(info.order));
    std::array<float, 8> moved{};
    std::array<float, 8> norm{};
    band_change(bands, made_from, now, moved);
    band_change(bands, now, {}, norm);
    const glm::quat turn = glm::conjugate(from) * to;
    const float angle = 2.0F * std::atan2(glm::length(glm::vec3(turn.x, turn.y, turn.z)), std::abs(turn.w));
    float bound = 0.0F;
    for (int l = 0; l < bands; ++l) {
        const auto at = static_cast<std::size_t>(l);
        bound += info.band_norm[at] * (moved[at] + std::min(2.0F, static_cast<float>(l) * angle) * norm[at]);
    }
    return bound;
}

} // namespace alpenglow::prt
