#include <alpenglow/probes/light_probe.hpp>

#include <alpenglow/probes/assemble.hpp>
#include <alpenglow/probes/environment.hpp>
#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::probes {

namespace {

Error probe_error(const char* field, float value, const char* expected) {
    return {.what = "is " + std::to_string(value), .where = std::string("LightProbe::") + field, .expected = expected};
}

bool within_unit(float v) {
    return std::isgreaterequal(v, 0.0F) && std::islessequal(v, 1.0F);
}

bool up_to_date(const EnvironmentMap& map, const EnvironmentMapSh& light) {
    return light.order > 0 && light.map_revision == map.revision;
}

bool same(const ProbeSources& a, const ProbeSources& b) {
    return a.order == b.order && a.whole_sphere == b.whole_sphere && a.sky == b.sky && a.to_sun == b.to_sun &&
           a.to_moon == b.to_moon && a.sun_lux == b.sun_lux && a.moon_lux == b.moon_lux;
}

bool same(const LightProbe& a, const LightProbe& b) {
    return a.position_m == b.position_m && a.order == b.order && a.deringing == b.deringing && a.source == b.source &&
           a.sun_visibility == b.sun_visibility && a.moon_visibility == b.moon_visibility &&
           a.ground_albedo == b.ground_albedo;
}

double norm(const ProbeCoefficients& c) {
    double sum = 0.0;
    for (const glm::vec3& v : c) {
        sum += glm::dot(glm::dvec3(v), glm::dvec3(v));
    }
    return std::sqrt(sum);
}

ProbeCoefficients assembled(const LightProbe& probe, const ProbeSources& sources) {
    return assemble_reference(probe.order, probe.deringing, sources,
                              {.sun_visibility = probe.sun_visibility,
                               .moon_visibility = probe.moon_visibility,
                               .albedo = probe.ground_albedo});
}

} // namespace

void take_sky(const SkyState& state, const SkyLightSh* light, ProbeSources& sources) {
    sources.to_sun = state.to_sun;
    sources.to_moon = state.to_moon;
    sources.sun_lux = state.sun_illuminance_lux;
    sources.moon_lux = state.moon_illuminance_lux;
    if (light != nullptr) {
        sources.order = std::min(light->bands, max_probe_order);
        std::copy_n(light->coefficients.begin(), sh::coefficient_count(sources.order), sources.sky.begin());
    }
}

void take_environment(const EnvironmentMapSh& light, ProbeSources& sources) {
    sources.sky = light.coefficients;
    sources.order = light.order;
    sources.whole_sphere = true;
    sources.sun_lux = glm::vec3(0.0F);
    sources.moon_lux = glm::vec3(0.0F);
}

bool usable(const EnvironmentMap& map, const EnvironmentMapSh& light) {
    return up_to_date(map, light) || check(map);
}

UpdateCounts update_environment(const EnvironmentMap& map, EnvironmentMapSh& light, bool used) {
    UpdateCounts counts{.considered = 1};
    if (!used || up_to_date(map, light) || !check(map)) {
        counts.skipped = 1;
        return counts;
    }
    light.coefficients = {};
    project_environment(map, light.coefficients);
    ProbeInput alone;
    alone.indirect = std::span(light.coefficients).first(static_cast<std::size_t>(sh::coefficient_count(map.order)));
    light.deringed = assemble_reference(map.order, Deringing::exact, {}, alone);
    light.order = map.order;
    light.map_revision = map.revision;
    ++light.revision;
    counts.updated = 1;
    return counts;
}

Status check(const LightProbe& probe) {
    for (int i = 0; i < 3; ++i) {
        if (!std::isfinite(probe.position_m[i])) {
            return probe_error("position_m", probe.position_m[i], "metres");
        }
        if (!within_unit(probe.ground_albedo[i])) {
            return probe_error("ground_albedo", probe.ground_albedo[i], "0 to 1");
        }
    }
    if (!std::isgreaterequal(probe.radius_m, 0.0F)) {
        return probe_error("radius_m", probe.radius_m, "0 or more");
    }
    if (probe.order < 1 || probe.order > max_probe_order) {
        return probe_error("order", static_cast<float>(probe.order), "1 to 5");
    }
    if (!std::isgreaterequal(probe.max_error, 0.0F)) {
        return probe_error("max_error", probe.max_error, "0 or more");
    }
    if (!within_unit(probe.sun_visibility)) {
        return probe_error("sun_visibility", probe.sun_visibility, "0 to 1");
    }
    if (!within_unit(probe.moon_visibility)) {
        return probe_error("moon_visibility", probe.moon_visibility, "0 to 1");
    }
    return Ok{};
}

bool reaches_any(const LightProbe& probe, std::span<const glm::vec3> positions_m) {
    return std::any_of(positions_m.begin(), positions_m.end(), [&](const glm::vec3& p) {
        return std::islessequal(glm::distance(p, probe.position_m), probe.radius_m);
    });
}

UpdateCounts update_light_probe(const LightProbe& probe, LightProbeSh& light, const ProbeSources& sources, bool needed,
                                const Capture& capture) {
    UpdateCounts counts{.considered = 1};
    const bool probe_same = light.order != 0 && same(probe, light.made_as);
    if (!needed || (probe_same && same(sources, light.made_from))) {
        counts.skipped = 1;
        return counts;
    }
    const bool captures = probe.source == ProbeSource::captured && capture.render;
    const ProbeCoefficients now = assembled(probe, sources);
    if (probe_same) {
        const DirectLight direct = direct_light(probe.order, probe.deringing, sources);
        ProbeCoefficients change = captures ? assembled(probe, light.made_from) : light.coefficients;
        for (std::size_t i = 0; i < change.size(); ++i) {
            change[i] = now[i] - change[i];
        }
        const double total = norm(sources.sky) + norm(direct.sun) + norm(direct.moon);
        const double error = norm(change);
        if (error <= static_cast<double>(probe.max_error) * total) {
            counts.skipped = 1;
            counts.error_bound = total > 0.0 ? error / total : 0.0;
            return counts;
        }
    }
    light.coefficients = now;
    if (captures) {
        ProbeCoefficients indirect{};
        capture_probe(probe.position_m, probe.order, capture.render, indirect);
        const auto n = static_cast<std::size_t>(sh::coefficient_count(probe.order));
        light.coefficients = assemble_reference(probe.order, probe.deringing, sources,
                                                {.sun_visibility = probe.sun_visibility,
                                                 .moon_visibility = probe.moon_visibility,
                                                 .albedo = probe.ground_albedo,
                                                 .indirect = std::span(indirect).first(n)});
    }
    light.order = probe.order;
    light.made_from = sources;
    light.made_as = probe;
    ++light.revision;
    counts.updated = 1;
    return counts;
}

} // namespace alpenglow::probes
