#include "sandbox/app/cloud_covers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <glm/geometric.hpp>

#include <alpenglow/clouds/occlusion.hpp>
#include <alpenglow/core/timing.hpp>

#include "sandbox/app/cloud_shadow_map.hpp"

namespace alpenglow::sandbox {

namespace {

// Mean over the upper hemisphere: integrals of P_l from 0 to 1 are 1, 1/2, 0, -1/8.
float upper_mean(const std::array<float, 16>& sh) {
    return std::clamp(0.28209479F * sh[0] + 0.5F * 0.48860251F * sh[2] - 0.125F * 0.74635267F * sh[12], 0.0F, 1.0F);
}

} // namespace

SystemReport CloudCovers::update(BasicRegistry& registry, const SkyLightSh& clear, const CloudsAround& around) {
    constexpr float cos_one_degree = 0.99984770F;
    constexpr float key_step = 0.02F;
    constexpr int rays = 192;
    SystemReport report{.system = "cloud_cover"};
    const double start = process_cpu_seconds();
    std::vector<std::pair<BasicRegistry::entity_type, glm::vec3>> places;
    registry.view<const CloudCover>().each(
        [&](auto entity, const CloudCover& cover) { places.emplace_back(entity, cover.position_m); });
    for (Made& made : made_) {
        made.used = false;
    }
    for (const auto& [entity, position_m] : places) {
        ++report.considered;
        if (!registry.all_of<CloudCoverLight>(entity)) {
            registry.emplace<CloudCoverLight>(entity);
        }
        CloudCoverLight& light = registry.get<CloudCoverLight>(entity);
        auto made = std::find_if(made_.begin(), made_.end(), [&](const Made& m) { return m.entity == entity; });
        const double allowed = std::max(50.0, 0.05 * std::abs(static_cast<double>(around.base_m - position_m.z)));
        bool changed = false;
        if (made == made_.end() || made->position_m != position_m || light.revision == 0 ||
            glm::dot(made->to_light, around.to_light) < cos_one_degree ||
            glm::length(made->drifted_m - around.drifted_m) > allowed) {
            if (made == made_.end()) {
                made_.push_back({});
                made = made_.end() - 1;
            }
            *made = {entity, position_m, around.to_light, around.drifted_m};
            clouds::SkySh sky;
            sky.bands = std::min(clear.bands, 4);
            std::copy_n(clear.coefficients.begin(), sky.bands * sky.bands, sky.coefficients.begin());
            const glm::dvec3 at(position_m);
            const std::vector<clouds::LitCloud> lit = around.clouds(at);
            light.sky = clouds::sky_behind_clouds(sky, lit, at, rays).coefficients;
            light.open = upper_mean(clouds::cloud_environment(lit, at, rays).transmittance);
            light.clear = sky.coefficients[0];
            changed = true;
        }
        made->used = true;
        const float key = shadow_at(around.shadow, position_m);
        float& kept = around.by_moon ? light.moon : light.sun;
        float& other = around.by_moon ? light.sun : light.moon;
        if (changed || std::abs(key - kept) > key_step) {
            kept = key;
            other = 1.0F;
            changed = true;
        }
        light.revision += changed ? 1U : 0U;
        ++(changed ? report.updated : report.skipped);
    }
    std::erase_if(made_, [](const Made& made) { return !made.used; });
    report.cpu_ms = (process_cpu_seconds() - start) * 1e3;
    return report;
}

} // namespace alpenglow::sandbox
