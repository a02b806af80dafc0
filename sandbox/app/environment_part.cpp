#include "sandbox/app/environment_part.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <utility>

#include <alpenglow/core/timing.hpp>
#include <alpenglow/probes/environment.hpp>
#include <alpenglow/probes/light_probe.hpp>
#include <alpenglow/sh/irradiance.hpp>

#include "sandbox/render/sky_dome.hpp"

namespace alpenglow::sandbox {
namespace {

float luminance(const glm::vec3& rgb) {
    return 0.2126F * rgb.r + 0.7152F * rgb.g + 0.0722F * rgb.b;
}

} // namespace

EnvironmentPart::EnvironmentPart(BasicRegistry& registry, EnvironmentMap map)
    : registry_(registry), entity_(registry.create()), dome_(SkyDome::vertices) {
    registry_.emplace<EnvironmentMap>(entity_, std::move(map));
    registry_.emplace<EnvironmentMapSh>(entity_);
}

EnvironmentPart::~EnvironmentPart() {
    registry_.destroy(entity_);
}

void EnvironmentPart::take_light() {
    constexpr float pi_f = std::numbers::pi_v<float>;
    const EnvironmentMap& map = registry_.get<EnvironmentMap>(entity_);
    EnvironmentMapSh& light = registry_.get<EnvironmentMapSh>(entity_);
    probes::update_environment(map, light, true);
    for (int channel = 0; channel < 3; ++channel) {
        std::array<float, 9> one{};
        for (std::size_t i = 0; i < one.size(); ++i) {
            one[i] = light.deringed[i][channel];
        }
        irradiance_matrix_[static_cast<std::size_t>(channel)] = sh::irradiance_matrix(std::span<const float>(one));
    }
    constexpr int azimuths = 64;
    horizon_radiance_ = glm::vec3(0.0F);
    for (int i = 0; i < azimuths; ++i) {
        const float azimuth = 2.0F * pi_f * (static_cast<float>(i) + 0.5F) / azimuths;
        horizon_radiance_ += probes::environment_radiance(map, {std::sin(azimuth), std::cos(azimuth), 0.03F}) /
                             static_cast<float>(azimuths);
    }
    average_luminance_ = luminance(light.coefficients[0]) * 0.28209479F; // over the whole sphere
    place_sky_vertices(glm::vec3(0.0F, 1.0F, 0.0F), 0.0F, dome_);
    for (SkyVertex& vertex : dome_) {
        vertex.radiance_cd_m2 = probes::environment_radiance(map, vertex.direction);
    }
    dome_revision_ = next_revision();
    drawn_ = {map.width, map.height, map.radiance, map.scale, map.azimuth_rad, next_revision()};
    made_revision_ = map.revision;
}

void EnvironmentPart::relight(Stage& stage) {
    SystemReport report{.system = "environment", .considered = 1};
    const double start = thread_cpu_seconds();
    if (made_revision_ != registry_.get<EnvironmentMap>(entity_).revision) {
        take_light();
        ++stage.light_revision;
        report.updated = 1;
    }
    report.skipped = 1 - report.updated;
    stage.light.irradiance_matrix = irradiance_matrix_;
    stage.light.horizon_radiance_cd_m2 = horizon_radiance_;
    stage.light.average_luminance_cd_m2 = average_luminance_;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    stage.reports.push_back(report);
}

void EnvironmentPart::update(Stage& stage) {
    FrameData& drawn = stage.drawn;
    drawn.sun_illuminance_lux = glm::vec3(0.0F); // the picture shows its own
    drawn.moon_illuminance_lux = glm::vec3(0.0F);
    drawn.sun_seen_lux = drawn.moon_seen_lux = glm::vec3(0.0F);
    drawn.sky_vertices = dome_;
    drawn.sky_revision = dome_revision_;
    drawn.environment = &drawn_;
}

void EnvironmentPart::draw_panel(PanelWriter& panel) {
    EnvironmentMap& map = registry_.get<EnvironmentMap>(entity_);
    float degrees = map.azimuth_rad * (180.0F / std::numbers::pi_v<float>);
    if (panel.slider("turn surroundings", degrees, -180.0F, 180.0F)) {
        map.azimuth_rad = degrees * (std::numbers::pi_v<float> / 180.0F);
        ++map.revision;
    }
    std::array<char, 96> line{};
    std::snprintf(line.data(), line.size(), "surroundings %d x %d, mean %.0f cd/m2", map.width, map.height,
                  static_cast<double>(average_luminance_));
    panel.text(line.data());
}

} // namespace alpenglow::sandbox
