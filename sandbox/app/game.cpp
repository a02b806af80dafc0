#include "sandbox/app/game.hpp"

#include <algorithm>
#include <array>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/scattering.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/systems/sky.hpp>
#include <alpenglow/systems/sky_light.hpp>
#ifdef ALPENGLOW_WITH_EPHEMERIS
#include <alpenglow/systems/ephemeris.hpp>
#endif

#include "sandbox/app/exposure.hpp"
#include "sandbox/app/parts.hpp"
#include "sandbox/render/sky_dome.hpp"
#include "sandbox/world/terrain_mesh.hpp"

namespace alpenglow::sandbox {

Game::Game(const Scene& scene, std::unique_ptr<World> world)
    : world_(std::move(world)), sky_(registry_.create()), dome_(SkyDome::vertices), stage_{.registry = registry_,
                                                                                           .sky = sky_,
                                                                                           .world = *world_,
                                                                                           .camera = camera,
                                                                                           .drawn = frame_,
                                                                                           .reports = reports_,
                                                                                           .light = {},
                                                                                           .frame = {}} {
    registry_.emplace<WorldClock>(sky_);
    registry_.emplace<Observer>(sky_);
    // Where no ephemeris moves it, the sun stands in the southwest, 35 degrees up.
    registry_.emplace<CelestialState>(sky_, CelestialState{.to_sun = {-0.5792F, -0.5792F, 0.5736F}});
    registry_.emplace<Atmosphere>(sky_);
    // Terrain and objects are lit by three bands of the sky.
    registry_.emplace<SkyLightReceiver>(registry_.create(), SkyLightReceiver{.bands = 3});
    // The dome is drawn from the sky view.
    registry_.emplace<SkyTableReader>(registry_.create());
    enter(scene);
}

void Game::update(double dt_s, int width, int height) {
    clock().utc_j2000_s += dt_s * clock().rate;
    stage_.frame = {frame_index_++, dt_s};
    stage_.world_dt_s = clock().rate > 0.0 ? dt_s : 0.0;
    stage_.width = width;
    stage_.height = height;
    stage_.quality = quality;
    stage_.storage_bytes = storage_bytes;
    reports_.clear();
    for (const std::unique_ptr<Part>& part : parts_) {
        part->begin(stage_);
    }
    frame_.view = camera.view();
    frame_.projection = camera.projection(static_cast<float>(width) / static_cast<float>(height));
    frame_.camera_m = camera.position_m;

    // The observer stands where the camera does: sky and sunlight are those of its height.
    observer().height_m = std::clamp(place_height_m_ + static_cast<double>(camera.position_m.z), -500.0, 80e3);

#ifdef ALPENGLOW_WITH_EPHEMERIS
    reports_.push_back(update_ephemeris(registry_, stage_.frame));
#endif
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
    place_height_m_ = scene.height_m - static_cast<double>(scene.camera_position_m.z);
    atmosphere() = scene.atmosphere;
    camera = scene_camera(scene);
    exposure_bias_ev = scene.exposure_bias_ev;
    exposed_ = false;
    parts_.clear();
    frame_.clouds = nullptr;
    frame_.air_light = glm::vec3(1.0F);
    frame_.environment = nullptr;
    frame_.probes = nullptr;
    frame_.impostors = nullptr;
    frame_.transfer = nullptr;
    dome_key_.reset(); // the dome may have been a picture's, the light that below clouds
    parts_ = make_parts(stage_, scene);
}

// The light of the scene and the dome's vertices, where the sky has changed.
SystemReport Game::update_dome() {
    SystemReport report{.system = "sky_dome", .considered = 1};
    const double start = thread_cpu_seconds();
    const SkyLightSh& sh = registry_.get<SkyLightSh>(sky_);
    const SkyTables* tables = registry_.try_get<SkyTables>(sky_);
    const std::uint32_t view_revision = tables != nullptr ? tables->view_revision : 0;
    const float over_ground_m = camera.position_m.z - world_->terrain.height_m(glm::vec2(camera.position_m));
    // Steps that nobody sees, where the height over the ground matters.
    const bool shell = sky().air.model == SkyModel::scattering;
    const int height_step = shell ? static_cast<int>(std::max(over_ground_m - light_from_above_m, 0.0F) / 50.0F) : 0;
    const DomeKey key{sky().revision, sh.bands, view_revision, height_step};
    if (dome_key_ == key) {
        report.skipped = 1;
        report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
        return report;
    }
    dome_key_ = key;
    ++stage_.light_revision;
    stage_.light = scene_light(celestial(), sky(), tables, sh, over_ground_m);
    const bool moonlit = stage_.light.moon_makes_sky;
    constexpr float off_horizon_rad = 3e-4F; // sky, not ground
    const float lowest = stage_.light.horizon_rad < 0.0F ? stage_.light.horizon_rad + off_horizon_rad : 0.0F;
    place_sky_vertices(moonlit ? stage_.light.to_moon : stage_.light.to_sun, std::min(lowest, 0.0F), dome_);
    std::array<glm::vec3, SkyDome::azimuths> directions{};
    std::array<glm::vec3, SkyDome::azimuths> radiance{};
    for (std::size_t ring = 0; ring < dome_.size(); ring += directions.size()) {
        for (std::size_t i = 0; i < directions.size(); ++i) {
            directions[i] = dome_[ring + i].direction;
        }
        sky::sky_radiance(sky(), tables, directions, radiance);
        for (std::size_t i = 0; i < directions.size(); ++i) {
            dome_[ring + i].radiance_cd_m2 = radiance[i];
        }
    }
    set_air();
    dome_revision_ = next_revision();
    report.updated = 1;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

// The air in front of things: that of the sky's model.
void Game::set_air() {
    const Atmosphere& made = sky().air;
    if (made.model == SkyModel::scattering) {
        if (const auto shell =
                sky::make_scattering_atmosphere(made.turbidity, made.ozone_atm_cm, glm::dvec3(made.ground_albedo))) {
            frame_.rayleigh_per_m = glm::vec3(1e-3 * shell->rayleigh_per_km);
            frame_.mie_per_m = glm::vec3(1e-3 * (shell->mie_scattering_per_km + shell->mie_absorption_per_km));
            frame_.rayleigh_height_m = static_cast<float>(1e3 * shell->rayleigh_height_km);
            frame_.mie_height_m = static_cast<float>(1e3 * shell->mie_height_km);
            return;
        }
    }
    const sky::Air air = sky::make_air(made.turbidity);
    frame_.rayleigh_per_m = air.rayleigh_per_m;
    frame_.mie_per_m = air.mie_per_m;
    frame_.rayleigh_height_m = air.rayleigh_height_m;
    frame_.mie_height_m = air.mie_height_m;
}

SystemReport Game::update_terrain(int height) {
    LodView view;
    view.camera_m = camera.position_m;
    view.clip_from_world = frame_.projection * frame_.view;
    view.pixels_per_radian = camera.pixels_per_radian(static_cast<float>(height));
    // High above the ground a triangulation lasts longer.
    LodSettings settings;
    const float above_m = camera.position_m.z - world_->terrain.height_m(glm::vec2(camera.position_m));
    settings.move_m = std::clamp(0.01F * above_m, settings.move_m, 30.0F);
    return world_->lod->update(view, settings);
}

SystemReport Game::update_shadows() {
    // Whichever gives more light throws the shadows.
    const bool by_sun = stage_.light.sun_lux.g >= stage_.light.moon_lux.g;
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
    frame_.sun_illuminance_lux = stage_.light.sun_lux;
    frame_.sun_seen_lux = stage_.light.sun.lux;
    frame_.sun_angular_radius_rad = stage_.light.sun.angular_radius_rad;
    frame_.sun_flattening = stage_.light.sun.flattening;
    frame_.to_moon = stage_.light.to_moon;
    frame_.moon_illuminance_lux = stage_.light.moon_lux;
    frame_.moon_seen_lux = stage_.light.moon.lux;
    frame_.moon_angular_radius_rad = stage_.light.moon.angular_radius_rad;
    frame_.moon_flattening = stage_.light.moon.flattening;
    frame_.horizon_rad = stage_.light.horizon_rad;
    frame_.moon_makes_sky = stage_.light.moon_makes_sky;
    frame_.irradiance_matrix = stage_.light.irradiance_matrix;
    frame_.air_radiance_cd_m2 = stage_.light.horizon_radiance_cd_m2;

    frame_.terrain_indices = world_->lod->indices();
    frame_.terrain_indices_revision = world_->lod->revision();
    frame_.shadow_vertices = world_->shadows->vertices();
    frame_.shadow_indices = world_->shadows->indices();
    frame_.shadow_revision = world_->shadows->revision();
    frame_.sky_vertices = dome_;
    frame_.sky_revision = dome_revision_;
}

} // namespace alpenglow::sandbox
