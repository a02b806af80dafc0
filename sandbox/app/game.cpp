#include "sandbox/app/game.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ephemeris/time.hpp>
#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/systems/ephemeris.hpp>
#include <alpenglow/systems/sky.hpp>
#include <alpenglow/systems/sky_light.hpp>

#include "sandbox/app/exposure.hpp"
#include "sandbox/app/parts.hpp"
#include "sandbox/render/sky_dome.hpp"
#include "sandbox/world/terrain_mesh.hpp"

namespace alpenglow::sandbox {

Game::Game(const Scene& scene, std::unique_ptr<World> world)
    : world_(std::move(world)), sky_(registry_.create()), dome_(SkyDome::vertices),
      stage_{.registry = registry_,
             .sky = sky_,
             .world = *world_,
             .camera = camera,
             .drawn = frame_,
             .reports = reports_,
             .light = {},
             .frame = {}} {
    registry_.emplace<WorldClock>(sky_);
    registry_.emplace<Observer>(sky_);
    registry_.emplace<CelestialState>(sky_);
    registry_.emplace<Atmosphere>(sky_);
    // Terrain and objects are lit by three bands of the sky.
    registry_.emplace<SkyLightReceiver>(registry_.create(), SkyLightReceiver{.bands = 3});
    enter(scene);
}

void Game::update(double dt_s, int width, int height) {
    clock().utc_j2000_s += dt_s * clock().rate;
    stage_.frame = {frame_index_++, dt_s};
    stage_.world_dt_s = clock().rate > 0.0 ? dt_s : 0.0;
    stage_.width = width;
    stage_.height = height;
    stage_.quality = quality;
    reports_.clear();
    for (const std::unique_ptr<Part>& part : parts_) {
        part->begin(stage_);
    }
    frame_.view = camera.view();
    frame_.projection = camera.projection(static_cast<float>(width) / static_cast<float>(height));
    frame_.camera_m = camera.position_m;

    reports_.push_back(update_ephemeris(registry_, stage_.frame));
    reports_.push_back(update_sky(registry_, stage_.frame));
    reports_.push_back(update_sky_light(registry_, stage_.frame));
    reports_.push_back(update_dome());
    for (const std::unique_ptr<Part>& part : parts_) {
        part->relight(stage_);
    }
    reports_.push_back(update_terrain(height));
    reports_.push_back(update_shadows());
    update_frame(dt_s);
    for (const std::unique_ptr<Part>& part : parts_) {
        part->update(stage_);
    }
}

void Game::wait() {
    for (const std::unique_ptr<Part>& part : parts_) {
        part->wait();
    }
}

void Game::enter(const Scene& scene) {
    clock() = {.utc_j2000_s = scene.utc_j2000_s, .rate = scene.time_rate};
    observer() = {.latitude_rad = scene.latitude_deg * degree_rad,
                  .longitude_rad = scene.longitude_deg * degree_rad,
                  .height_m = scene.height_m};
    atmosphere() = {
        .turbidity = scene.turbidity, .ozone_atm_cm = scene.ozone_atm_cm, .ground_albedo = scene.ground_albedo};
    camera = scene_camera(scene);
    exposure_bias_ev = scene.exposure_bias_ev;
    exposed_ = false;
    parts_.clear();
    frame_.clouds = nullptr;
    frame_.air_light = glm::vec3(1.0F);
    frame_.environment = nullptr;
    frame_.probes = nullptr;
    frame_.transfer = nullptr;
    sky_light_revision_ = 0; // the dome may have been a picture's, the light that below clouds
    parts_ = make_parts(stage_, scene);
}

// The light of the scene and the dome's vertices, where the sky has changed.
SystemReport Game::update_dome() {
    SystemReport report{.system = "sky_dome", .considered = 1};
    const double start = thread_cpu_seconds();
    const SkyLightSh& sh = registry_.get<SkyLightSh>(sky_);
    if (sh.revision == sky_light_revision_) {
        report.skipped = 1;
        report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
        return report;
    }
    sky_light_revision_ = sh.revision;
    ++stage_.light_revision;
    stage_.light = scene_light(celestial(), sky(), sh, atmosphere());
    place_sky_vertices(stage_.light.to_sun, dome_);
    const sky::PreethamSky<float> model = sky::preetham_of(sky());
    for (SkyVertex& vertex : dome_) {
        vertex.radiance_cd_m2 = sky::sky_radiance(sky(), model, vertex.direction);
    }
    dome_revision_ = next_revision();
    report.updated = 1;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

SystemReport Game::update_terrain(int height) {
    LodView view;
    view.camera_m = camera.position_m;
    view.clip_from_world = frame_.projection * frame_.view;
    view.pixels_per_radian = camera.pixels_per_radian(static_cast<float>(height));
    return world_->lod->update(view, {});
}

SystemReport Game::update_shadows() {
    // Whichever gives more light throws the shadows.
    const bool by_sun = sky().sun_illuminance_lux.g >= sky().moon_illuminance_lux.g;
    ShadowInput input;
    input.to_light = by_sun ? stage_.light.to_sun : stage_.light.to_moon;
    input.angular_radius_rad = by_sun ? celestial().sun_angular_radius_rad : celestial().moon_angular_radius_rad;
    input.camera_m = camera.position_m;
    return world_->shadows->update(input, *world_->lod);
}

void Game::update_frame(double dt_s) {
    frame_.camera_horizon = terrain_horizon(world_->terrain, world_->data.terrain, glm::vec2(camera.position_m));
    const float exposure = automatic_exposure(stage_.light.average_luminance_cd_m2, exposure_bias_ev);
    frame_.exposure = exposed_ ? adapt_exposure(frame_.exposure, exposure, static_cast<float>(dt_s)) : exposure;
    exposed_ = true;

    frame_.to_sun = stage_.light.to_sun;
    frame_.sun_illuminance_lux = sky().sun_illuminance_lux;
    frame_.sun_angular_radius_rad = celestial().sun_angular_radius_rad;
    frame_.to_moon = stage_.light.to_moon;
    frame_.moon_illuminance_lux = sky().moon_illuminance_lux;
    frame_.moon_angular_radius_rad = celestial().moon_angular_radius_rad;
    frame_.irradiance_matrix = stage_.light.irradiance_matrix;
    frame_.air_radiance_cd_m2 = stage_.light.horizon_radiance_cd_m2;
    const sky::Air air = sky::make_air(atmosphere().turbidity);
    frame_.rayleigh_per_m = air.rayleigh_per_m;
    frame_.mie_per_m = air.mie_per_m;
    frame_.rayleigh_height_m = air.rayleigh_height_m;
    frame_.mie_height_m = air.mie_height_m;

    frame_.terrain_indices = world_->lod->indices();
    frame_.terrain_indices_revision = world_->lod->revision();
    frame_.shadow_vertices = world_->shadows->vertices();
    frame_.shadow_indices = world_->shadows->indices();
    frame_.shadow_revision = world_->shadows->revision();
    frame_.sky_vertices = dome_;
    frame_.sky_revision = dome_revision_;
}

} // namespace alpenglow::sandbox
