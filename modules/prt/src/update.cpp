#include <alpenglow/prt/update.hpp>

#include <alpenglow/prt/evaluate.hpp>

#include <algorithm>
#include <cassert>
#include <limits>

namespace alpenglow::prt {
namespace {

std::size_t sample_count(const ObjectLight& light) {
    const auto n = static_cast<std::size_t>(light.bands * light.bands);
    return n == 0 ? 0 : light.coefficients.size() / n;
}

} // namespace

float relative_change(const TransferInfo& info, int order, std::size_t samples, std::span<const glm::vec3> made_from,
                      const glm::quat& from, std::span<const glm::vec3> now, const glm::quat& to) noexcept {
    const auto n = static_cast<std::size_t>(order * order);
    assert(made_from.size() >= samples * n && now.size() >= samples * n);
    float bound = 0.0F;
    glm::vec3 mean(0.0F);
    for (std::size_t s = 0; s < samples; ++s) {
        bound =
            std::max(bound, change_bound(info, order, made_from.subspan(s * n, n), from, now.subspan(s * n, n), to));
        mean = glm::max(mean, glm::abs(now[s * n]));
    }
    if (!(bound > 0.0F)) {
        return 0.0F;
    }
    const float response = info.band_norm[0] * std::max({mean.x, mean.y, mean.z});
    return response > 0.0F ? bound / response : std::numeric_limits<float>::infinity();
}

float urgency(const TransferSource& source, const ObjectLight& light, TransferResult* result) noexcept {
    constexpr float must = std::numeric_limits<float>::infinity();
    if (source.table == nullptr || !source.visible || light.bands < 1 || light.coefficients.empty()) {
        return 0.0F;
    }
    if (result == nullptr || result->made_from_table != source.table || result->bands != light.bands ||
        result->made_from_light.size() != light.coefficients.size() ||
        (source.on_gpu ? false : result->radiance.empty())) {
        return must;
    }
    if (result->light_revision == light.revision && result->made_from_rotation == source.scene_from_object) {
        result->error_bound = 0.0F;
        return 0.0F;
    }
    result->error_bound = relative_change(source.table->info, light.bands, sample_count(light), result->made_from_light,
                                          result->made_from_rotation, light.coefficients, source.scene_from_object);
    if (result->error_bound == 0.0F) {
        return 0.0F;
    }
    return source.max_error > 0.0F ? result->error_bound / source.max_error : must;
}

std::uint64_t cost_points(const TransferSource& source) noexcept {
    return source.on_gpu ? 1 : source.table->info.count * source.table->info.rows;
}

void recompute(const TransferSource& source, const LightSamples* samples, const ObjectLight& light,
               TransferResult& result) {
    const TransferTable& table = *source.table;
    const std::size_t lights = sample_count(light);
    const auto n = static_cast<std::size_t>(light.bands * light.bands);
    result.object_light.resize(light.coefficients.size());
    for (std::size_t s = 0; s < lights; ++s) {
        to_object_frame(light.bands, source.scene_from_object, std::span(light.coefficients).subspan(s * n, n),
                        std::span(result.object_light).subspan(s * n, n));
    }
    if (source.on_gpu) {
        result.radiance.clear();
    } else {
        result.radiance.resize(table.info.count * table.info.rows);
        if (table.info.rows > 1) {
            evaluate_matrix(table, std::span(result.object_light).first(n), result.radiance);
        } else if (samples != nullptr && lights > 1 && samples->points_m.size() == lights) {
            std::vector<glm::vec3> scratch;
            evaluate_varying(table, *samples, light.bands, result.object_light, result.radiance, scratch);
        } else {
            evaluate(table, std::span(result.object_light).first(n), result.radiance);
        }
    }
    result.bands = light.bands;
    result.made_from_light = light.coefficients;
    result.made_from_rotation = source.scene_from_object;
    result.made_from_table = source.table;
    result.light_revision = light.revision;
    result.error_bound = 0.0F;
    ++result.revision;
}

} // namespace alpenglow::prt
