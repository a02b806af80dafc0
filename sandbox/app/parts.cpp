#include "sandbox/app/parts.hpp"

#include <numbers>
#include <utility>

#include "sandbox/app/camera_flight.hpp"
#include "sandbox/app/sky_charts.hpp"
#ifdef ALPENGLOW_WITH_CLOUDS
#include "sandbox/app/cloud_scene.hpp"
#endif
#ifdef ALPENGLOW_WITH_ENVIRONMENT
#include <alpenglow/probes/environment.hpp>

#include "sandbox/app/environment_part.hpp"
#endif
#ifdef ALPENGLOW_WITH_IMPOSTORS
#include "sandbox/app/impostor_scene.hpp"
#endif
#ifdef ALPENGLOW_WITH_PROBES
#include "sandbox/app/probe_scene.hpp"
#endif
#ifdef ALPENGLOW_WITH_TRANSFER
#include "sandbox/app/transfer_scene.hpp"
#endif

namespace alpenglow::sandbox {
namespace {

// What the scene asks for and this build has left out.
[[maybe_unused]] void leave_out(Stage& stage, const char* section, const char* module) {
    stage.problems.push_back(Error{"this build has no such part", section,
                                   std::string("a build with the module ") + module + " (ALPENGLOW_MODULES)"});
}

} // namespace

// In the order of a frame: what moves the camera, what stands for the sky, what takes its light, what is drawn last.
std::vector<std::unique_ptr<Part>> make_parts(Stage& stage, const Scene& scene) {
    std::vector<std::unique_ptr<Part>> parts;
#ifndef ALPENGLOW_WITH_EPHEMERIS
    leave_out(stage, "time_utc", "ephemeris"); // the sun stands still
#endif
    if (scene.flight) {
        parts.push_back(std::make_unique<CameraFlight>(*scene.flight));
    }
    if (scene.environment) {
#ifdef ALPENGLOW_WITH_ENVIRONMENT
        Result<EnvironmentMap> map = probes::load_environment(scene.environment->file);
        if (map) {
            map->scale = scene.environment->scale;
            map->azimuth_rad = scene.environment->azimuth_deg * (std::numbers::pi_v<float> / 180.0F);
            parts.push_back(std::make_unique<EnvironmentPart>(stage.registry, std::move(map).value()));
        } else {
            stage.problems.push_back(map.error());
        }
#else
        leave_out(stage, "environment", "probes");
#endif
    }
    if (scene.clouds) {
#ifdef ALPENGLOW_WITH_CLOUDS
        parts.push_back(std::make_unique<CloudScene>(stage, *scene.clouds));
#else
        leave_out(stage, "clouds", "clouds");
#endif
    }
    if (scene.probes) {
#ifdef ALPENGLOW_WITH_PROBES
        parts.push_back(std::make_unique<ProbeScene>(stage.registry, stage.world, *scene.probes));
#else
        leave_out(stage, "probes", "probes");
#endif
    }
    if (scene.transfer) {
#ifdef ALPENGLOW_WITH_TRANSFER
        parts.push_back(std::make_unique<TransferScene>(stage, *scene.transfer));
#else
        leave_out(stage, "transfer", "prt");
#endif
    }
    if (scene.impostors) {
#ifdef ALPENGLOW_WITH_IMPOSTORS
        parts.push_back(std::make_unique<ImpostorScene>(stage, *scene.impostors));
#else
        leave_out(stage, "impostors", "impostors");
#endif
    }
    parts.push_back(std::make_unique<SkyCharts>(stage.registry, scene.chart));
    return parts;
}

} // namespace alpenglow::sandbox
