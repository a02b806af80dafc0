#include "sandbox/app/parts.hpp"

#include <numbers>
#include <utility>

#include <alpenglow/probes/environment.hpp>

#include "sandbox/app/camera_flight.hpp"
#include "sandbox/app/cloud_scene.hpp"
#include "sandbox/app/environment_part.hpp"
#include "sandbox/app/probe_scene.hpp"
#include "sandbox/app/transfer_scene.hpp"
#include "sandbox/app/sky_charts.hpp"

namespace alpenglow::sandbox {

std::vector<std::unique_ptr<Part>> make_parts(Stage& stage, const Scene& scene) {
    std::vector<std::unique_ptr<Part>> parts;
    if (scene.flight) {
        parts.push_back(std::make_unique<CameraFlight>(*scene.flight));
    }
    if (scene.environment) {
        Result<EnvironmentMap> map = probes::load_environment(scene.environment->file);
        if (map) {
            map->scale = scene.environment->scale;
            map->azimuth_rad = scene.environment->azimuth_deg * (std::numbers::pi_v<float> / 180.0F);
            parts.push_back(std::make_unique<EnvironmentPart>(stage.registry, std::move(map).value()));
        } else {
            stage.problems.push_back(map.error());
        }
    }
    if (scene.clouds) {
        parts.push_back(std::make_unique<CloudScene>(stage, *scene.clouds));
    }
    if (scene.probes) {
        parts.push_back(std::make_unique<ProbeScene>(stage.registry, stage.world, *scene.probes));
    }
    if (scene.transfer) {
        parts.push_back(std::make_unique<TransferScene>(stage, *scene.transfer));
    }
    parts.push_back(std::make_unique<SkyCharts>(stage.registry, scene.chart));
    return parts;
}

} // namespace alpenglow::sandbox
