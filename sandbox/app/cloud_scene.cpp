#include "sandbox/app/cloud_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/occlusion.hpp>
#include <alpenglow/clouds/vdb.hpp>
#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/systems/clouds.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr CloudBudget first_budget{.slices_per_frame = 1 << 20, .depths_per_frame = 1 << 20};
constexpr CloudBudget frame_budget{};

// A file's grid, its middle at the origin and scaled.
Result<std::shared_ptr<const clouds::BrickVolume>> read_cloud(const CloudFileSettings& file,
                                                              const std::string& folder) {
    const std::string path = (std::filesystem::path(folder) / file.path).string();
    const Result<clouds::VdbGrid> grid = clouds::load_vdb(path, file.grid);
    if (!grid) {
        return grid.error();
    }
    Result<clouds::SparseGrid> sparse = clouds::sparse_from_vdb(*grid, path);
    if (!sparse) {
        return sparse.error();
    }
    auto volume = std::make_shared<clouds::BrickVolume>(*sparse);
    clouds::GridTransform transform = volume->transform();
    transform.voxel_m *= static_cast<double>(file.scale);
    transform.origin_m = glm::dvec3(0.0);
    const glm::dvec3 middle = 0.5 * glm::dvec3(volume->active_low() + volume->active_high());
    transform.origin_m = glm::dvec3(file.position_m) - transform.world_from_index(middle);
    volume->set_transform(transform);
    return std::shared_ptr<const clouds::BrickVolume>(std::move(volume));
}

// Of a layer's shadow over one repetition of it, on a plane below it.
float mean_transmittance(const clouds::CloudShadow& shadow, double repeat_m, double plane_m,
                         const glm::vec3& to_light) {
    constexpr std::size_t places = 32; // a side
    const int copies = to_light.z < 0.15F ? 2 : 1;
    std::array<double, places> rows{};
    parallel_for(places, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) {
            for (std::size_t i = 0; i < places; ++i) {
                const glm::dvec3 at(((static_cast<double>(i) + 0.5) / places - 0.5) * repeat_m,
                                    ((static_cast<double>(j) + 0.5) / places - 0.5) * repeat_m, plane_m);
                double through = 1.0;
                for (int v = -copies; v <= copies; ++v) {
                    for (int u = -copies; u <= copies; ++u) {
                        through *=
                            static_cast<double>(shadow.transmittance(at - glm::dvec3(u * repeat_m, v * repeat_m, 0.0)));
                    }
                }
                rows[j] += through / (places * places);
            }
        }
    });
    return static_cast<float>(std::accumulate(rows.begin(), rows.end(), 0.0));
}

} // namespace

CloudScene::CloudScene(Stage& stage, const CloudSettings& wanted) : settings(wanted), registry_(stage.registry) {
    const double start = process_cpu_seconds();
    for (const CloudLayerSettings& layer : settings.layers) {
        add(std::make_shared<clouds::BrickVolume>(layer_grid(settings, layer)), layer.matter,
            static_cast<double>(layer.extent_m));
    }
    for (const CloudFileSettings& file : settings.files) {
        Result<std::shared_ptr<const clouds::BrickVolume>> volume = read_cloud(file, settings.folder);
        if (volume) {
            add(std::move(volume).value(), file.matter, 0.0);
        } else {
            stage.problems.push_back(volume.error());
        }
    }
    model_s_ = process_cpu_seconds() - start;
    registry_.ctx().emplace<CloudBudget>();
    reference_ = CloudReference::load(settings, stage.camera);
}

CloudScene::~CloudScene() {
    for (const Item& item : entities_) {
        registry_.destroy(item.entity);
    }
}

void CloudScene::add(std::shared_ptr<const clouds::BrickVolume> volume, const CloudMatter& matter, double repeat_m) {
    const Entity entity = registry_.create();
    registry_.emplace<CloudVolume>(entity, CloudVolume{.volume = std::move(volume),
                                                       .extinction_per_m = matter.extinction_per_m,
                                                       .albedo = matter.albedo,
                                                       .anisotropy = matter.anisotropy,
                                                       .method = static_cast<CloudMethod>(settings.method)});
    registry_.emplace<SkyLightReceiver>(entity, SkyLightReceiver{.bands = 4}); // from the first frame on
    entities_.push_back({entity, repeat_m});
    light_revisions_.push_back(0);
}

// Layers wrap around after one repetition, so that distances stay small.
void CloudScene::drift(double dt_s) {
    const double azimuth = static_cast<double>(settings.wind_from_deg) * degree_rad;
    time_s_ += dt_s;
    drifted_m_ -= static_cast<double>(settings.wind_m_s) * dt_s * glm::dvec3(std::sin(azimuth), std::cos(azimuth), 0.0);
    for (const Item& item : entities_) {
        glm::dvec3 offset = drifted_m_;
        if (item.repeat_m > 0.0) {
            for (int a = 0; a < 2; ++a) {
                offset[a] -= item.repeat_m * std::round(offset[a] / item.repeat_m);
            }
        }
        registry_.get<CloudVolume>(item.entity).offset_m = offset;
    }
}

std::vector<clouds::LitCloud> CloudScene::lit_clouds(const glm::dvec3& around_m) const {
    std::vector<clouds::LitCloud> lit;
    for (const Item& item : entities_) {
        const CloudVolume& cloud = registry_.get<CloudVolume>(item.entity);
        const CloudLight* light = registry_.try_get<CloudLight>(item.entity);
        if (!cloud.visible || light == nullptr || light->lighting == nullptr || cloud.volume->empty()) {
            continue;
        }
        if (item.repeat_m <= 0.0) {
            lit.push_back({cloud.volume.get(), light->lighting.get(), cloud.offset_m});
            continue;
        }
        // The copy around the camera and its eight neighbours.
        const auto nearest = [&](int a) {
            return std::round((around_m[a] - cloud.offset_m[a]) / item.repeat_m) * item.repeat_m + cloud.offset_m[a];
        };
        const glm::dvec3 middle(nearest(0), nearest(1), cloud.offset_m.z);
        for (int j = -1; j <= 1; ++j) {
            for (int i = -1; i <= 1; ++i) {
                lit.push_back({cloud.volume.get(), light->lighting.get(),
                               middle + glm::dvec3(i * item.repeat_m, j * item.repeat_m, 0.0)});
            }
        }
    }
    return lit;
}

// The systems, the shadow and the light below the clouds.
void CloudScene::relight(Stage& stage) {
    drift(stage.world_dt_s);
    bool anew = first_frame_;
    for (const Item& item : entities_) {
        CloudVolume& cloud = registry_.get<CloudVolume>(item.entity);
        anew = anew || cloud.method != static_cast<CloudMethod>(settings.method);
        cloud.method = static_cast<CloudMethod>(settings.method);
    }
    registry_.ctx().get<CloudBudget>() = anew ? first_budget : frame_budget;
    first_frame_ = false;
    stage.reports.push_back(update_clouds(registry_, stage.frame));
    if (stage.reports.back().updated > 0) {
        bake_ms_ = stage.reports.back().cpu_ms;
    }
    if (shade_layers(stage)) {
        update_clouds(registry_, stage.frame); // strengths of lights alone: no work
        ++light_revision_;
    }
    // Light that is still being made is shown once it is done.
    for (std::size_t i = 0; i < entities_.size(); ++i) {
        const CloudLight* light = registry_.try_get<CloudLight>(entities_[i].entity);
        if (light != nullptr && light->lighting != nullptr && !light->lighting->working() &&
            light->revision != light_revisions_[i]) {
            light_revisions_[i] = light->revision;
            ++light_revision_;
        }
    }
    const SkyLightSh& sky = registry_.get<SkyLightSh>(stage.sky);
    sources_ = clouds::cloud_sources(registry_.get<SkyState>(stage.sky), &sky,
                                     registry_.get<Atmosphere>(stage.sky).ground_albedo);
    SystemReport report{.system = "cloud_shade", .considered = 2};
    const double start = process_cpu_seconds();
    const std::uint32_t map = shadow_.map().revision;
    const std::uint32_t light = stage.light_revision;
    update_shadow(stage);
    shade(stage);
    report.updated = (shadow_.map().revision != map ? 1U : 0U) + (stage.light_revision != light ? 1U : 0U);
    report.skipped = report.considered - report.updated;
    report.cpu_ms = (process_cpu_seconds() - start) * 1e3;
    stage.reports.push_back(report);
    cover_places(stage);
}

// What the clouds leave at the places of probes and of things with transfer.
void CloudScene::cover_places(Stage& stage) {
    if (light_revision_ == 0) {
        return; // there is no light in them yet
    }
    const SkyState& sky = registry_.get<SkyState>(stage.sky);
    CloudsAround around;
    around.clouds = [this](const glm::dvec3& at) { return lit_clouds(at); };
    around.shadow = settings.shadows ? shadow_.map() : CloudShadowMap{};
    around.shadow.offset_m += glm::vec2(drifted_m_);
    around.by_moon = sky.moon_illuminance_lux.g > sky.sun_illuminance_lux.g;
    around.to_light = around.by_moon ? stage.light.to_moon : stage.light.to_sun;
    around.drifted_m = drifted_m_;
    around.base_m = shadow_.map().base_m;
    stage.reports.push_back(covers_.update(registry_, registry_.get<SkyLightSh>(stage.sky), around));
}

// The share of the key light that the layers above leave to each, the mean over one repetition of them; true where one
// has changed by a hundredth. Looked up again when the light has turned by a degree; independent of the wind.
bool CloudScene::shade_layers(const Stage& stage) {
    const SkyState& sky = registry_.get<SkyState>(stage.sky);
    const bool by_moon = sky.moon_illuminance_lux.g > sky.sun_illuminance_lux.g;
    const glm::vec3 towards = by_moon ? stage.light.to_moon : stage.light.to_sun;
    constexpr float cos_one_degree = 0.99984770F;
    if (entities_.size() < 2 || glm::dot(towards, layers_from_) > cos_one_degree) {
        return false;
    }
    struct Layer {
        const Item* item;
        double bottom_m, top_m;
        std::size_t light;
    };
    std::vector<Layer> layers;
    for (const Item& item : entities_) {
        const clouds::BrickVolume& volume = *registry_.get<CloudVolume>(item.entity).volume;
        const CloudLight* light = registry_.try_get<CloudLight>(item.entity);
        if (item.repeat_m <= 0.0 || volume.empty() || light == nullptr || !light->lighting) {
            continue;
        }
        for (std::size_t i = 0; i < light->lighting->lights().size(); ++i) {
            if (light->kind[i] == (by_moon ? 2 : 1)) {
                const clouds::GridTransform& transform = volume.transform();
                layers.push_back({&item, transform.world_from_index(glm::dvec3(volume.active_low())).z,
                                  transform.world_from_index(glm::dvec3(volume.active_high())).z, i});
            }
        }
    }
    if (layers.size() < 2) {
        return false;
    }
    layers_from_ = towards;
    std::vector<float> means(layers.size(), 1.0F); // of each layer's own shadow
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const bool shades = std::any_of(layers.begin(), layers.end(),
                                        [&](const Layer& other) { return other.top_m <= layers[l].bottom_m; });
        if (shades) {
            const Item& item = *layers[l].item;
            const CloudVolume& cloud = registry_.get<CloudVolume>(item.entity);
            const clouds::CloudShadow shadow(*cloud.volume, *registry_.get<CloudLight>(item.entity).lighting,
                                             layers[l].light, 4);
            means[l] = mean_transmittance(shadow, item.repeat_m, layers[l].bottom_m - 1.0, towards);
        }
    }
    bool changed = false;
    for (const Layer& layer : layers) {
        float share = 1.0F;
        for (std::size_t l = 0; l < layers.size(); ++l) {
            share *= layer.top_m <= layers[l].bottom_m ? means[l] : 1.0F;
        }
        CloudVolume& cloud = registry_.get<CloudVolume>(layer.item->entity);
        float& kept = by_moon ? cloud.moon_share : cloud.sun_share;
        changed = changed || std::abs(share - kept) > 0.01F;
        kept = share;
    }
    return changed;
}

// Once for each state of the light, while the sun is where the reference has it.
void CloudScene::measure_error() {
    if (!reference_ || error_light_ == light_revision_ || entities_.empty()) {
        return;
    }
    error_light_ = light_revision_;
    error_.reset();
    const CloudLight* light = registry_.try_get<CloudLight>(entities_.front().entity);
    if (light != nullptr && light->lighting != nullptr && reference_->holds(sources_)) {
        error_ = reference_->error(*registry_.get<CloudVolume>(entities_.front().entity).volume, *light->lighting,
                                   sources_.sky);
    }
}

// Made again where the light has turned by a quarter of a degree; the wind only moves it.
void CloudScene::update_shadow(const Stage& stage) {
    const SkyState& sky = registry_.get<SkyState>(stage.sky);
    const bool by_moon = sky.moon_illuminance_lux.g > sky.sun_illuminance_lux.g;
    const glm::vec3 towards = by_moon ? stage.light.to_moon : stage.light.to_sun;
    constexpr float cos_quarter_degree = 0.99999048F;
    if (light_revision_ == 0 || (shadow_.map().size > 0 && glm::dot(towards, shadow_from_) > cos_quarter_degree)) {
        return;
    }
    std::vector<ShadowCaster> casters;
    double extent = 0.0;
    for (const Item& item : entities_) {
        const CloudVolume& cloud = registry_.get<CloudVolume>(item.entity);
        const CloudLight* light = registry_.try_get<CloudLight>(item.entity);
        for (std::size_t i = 0; light != nullptr && light->lighting && i < light->lighting->lights().size(); ++i) {
            if (light->kind[i] == (by_moon ? 2 : 1) && !cloud.volume->empty()) {
                casters.push_back({{cloud.volume.get(), light->lighting.get(), glm::dvec3(0.0)}, i, item.repeat_m});
                extent = std::max(extent, item.repeat_m);
            }
        }
    }
    if (!casters.empty()) {
        constexpr double alone_m = 24000.0; // side of the map where no cloud repeats
        shadow_.make(casters, towards, extent > 0.0 ? extent : alone_m);
        shadow_from_ = towards;
    }
}

// The sky as it is seen below the clouds, the mean over one repetition of their layer, takes the clear sky's place in
// the light of the scene.
void CloudScene::shade(Stage& stage) {
    const bool new_sky = stage.light_revision != stage_light_;
    if (new_sky) {
        clear_light_ = stage.light;
    }
    constexpr float cos_one_degree = 0.99984770F;
    const bool turned = glm::dot(stage.light.to_sun, shaded_from_) < cos_one_degree;
    if (light_revision_ == 0 || (shaded_ && !turned && !new_sky)) {
        return;
    }
    if (!shaded_ || turned) {
        shaded_from_ = stage.light.to_sun;
        measure_sky(stage);
    }
    const SkyLightSh& clear = registry_.get<SkyLightSh>(stage.sky);
    SkyLightSh below = clear;
    for (std::size_t k = 0; k < 16; ++k) {
        below.coefficients[k] = below_[k] * (clear.coefficients[0] / glm::max(below_clear_, glm::vec3(1e-12F)));
    }
    SkyState sky = registry_.get<SkyState>(stage.sky);
    const float through = shadow_.map().size > 0 ? shadow_.mean() : 1.0F;
    sky.sun_illuminance_lux *= through;
    sky.moon_illuminance_lux *= through;
    const SceneLight lit = scene_light(registry_.get<CelestialState>(stage.sky), sky,
                                       registry_.try_get<SkyTables>(stage.sky), below, 0.0F);
    stage.light.irradiance_matrix = lit.irradiance_matrix;
    stage.light.average_luminance_cd_m2 = lit.average_luminance_cd_m2;
    // Air below a closed deck gets what the deck lets through; below a broken one, light enters through the gaps.
    float cover = 0.0F;
    for (const CloudLayerSettings& layer : settings.layers) {
        cover = std::max(cover, layer.cover);
    }
    const float closed = std::clamp((cover - 0.6F) / 0.3F, 0.0F, 1.0F);
    const auto level = [](const glm::vec3& sun, const SkyLightSh& light) {
        return sun + 3.5449F * glm::max(light.coefficients[0], glm::vec3(0.0F));
    };
    const SkyState& open = registry_.get<SkyState>(stage.sky);
    const glm::vec3 share =
        level(sky.sun_illuminance_lux * std::max(0.0F, open.to_sun.z), below) /
        glm::max(level(open.sun_illuminance_lux * std::max(0.0F, open.to_sun.z), clear), glm::vec3(1e-9F));
    air_light_ = glm::mix(glm::vec3(1.0F), glm::min(share, glm::vec3(1.0F)), closed);
    stage_light_ = ++stage.light_revision;
    shaded_ = true;
}

// Mean over places below the clouds; independent of the wind.
void CloudScene::measure_sky(const Stage& stage) {
    constexpr int places = 3; // a side
    constexpr int rays = 64;
    below_.fill(glm::vec3(0.0F));
    const SkyLightSh& clear = registry_.get<SkyLightSh>(stage.sky);
    below_clear_ = clear.coefficients[0];
    clouds::SkySh sky;
    sky.bands = 4;
    std::copy_n(clear.coefficients.begin(), 16, sky.coefficients.begin());
    double extent = 0.0;
    for (const Item& item : entities_) {
        extent = std::max(extent, item.repeat_m);
    }
    std::array<std::array<glm::vec3, 16>, places * places> found{};
    parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const glm::dvec3 at((static_cast<double>(p % places) + 0.5) / places * extent,
                                (static_cast<double>(p / places) + 0.5) / places * extent, 700.0);
            found[p] = clouds::sky_behind_clouds(sky, lit_clouds(at), at, rays).coefficients;
        }
    });
    for (std::size_t p = 0; p < found.size(); ++p) {
        for (std::size_t k = 0; k < 16; ++k) {
            below_[k] += found[p][k] / static_cast<float>(found.size());
        }
    }
}

void CloudScene::update(Stage& stage) {
    SystemReport report{.system = "cloud_view", .considered = 1};
    device_ = stage.quality == Quality::full && stage.storage_bytes > 0 && !too_large_;
    const double start = process_cpu_seconds();
    CloudsInView in_view;
    for (const clouds::LitCloud& cloud : lit_clouds(glm::dvec3(stage.camera.position_m))) {
        if (!clouds::bounds_on_screen(cloud, cloud_camera(stage.camera, stage.width, stage.height, 1)).empty()) {
            in_view.clouds.push_back(cloud);
        }
    }
    in_view.light_revision = light_revision_;
    in_view.terrain_vertices = stage.world.data.terrain.vertices;
    in_view.terrain_indices = stage.drawn.terrain_indices;
    in_view.time_s = time_s_;
    const std::uint32_t before = view.revision();
    view.settings.reshape_s = settings.reshape_s;
    view.settings.on_device = settings.march == 0 && device_;
    std::size_t rays = view.update(in_view, stage.camera, stage.width, stage.height);
    if (view.settings.on_device && view.tables().bytes() > stage.storage_bytes) {
        stage.problems.push_back({"the clouds' tables have " + std::to_string(view.tables().bytes()) +
                                      " bytes: the CPU marches in the device's place",
                                  "clouds",
                                  "at most " + std::to_string(stage.storage_bytes) +
                                      " bytes, what this device reads from one storage buffer"});
        too_large_ = true;
        view.settings.on_device = false;
        rays = view.update(in_view, stage.camera, stage.width, stage.height);
    }
    report.updated = rays > 0 ? 1 : 0;
    report.skipped = 1 - report.updated;
    report.cpu_ms = (process_cpu_seconds() - start) * 1e3;
    march_ms_ = rays > 0 ? report.cpu_ms : march_ms_;
    const clouds::Picture& picture = view.picture();
    if (view.revision() != before && !view.settings.on_device) {
        double covered = 0.0;
        for (const float t : picture.transmittance) {
            covered += 1.0 - static_cast<double>(t);
        }
        covered_ =
            static_cast<float>(covered / static_cast<double>(std::max<std::size_t>(1, picture.transmittance.size())));
    }
    drawn_.width = view.camera().width;
    drawn_.height = view.camera().height;
    drawn_.scale = view.scale();
    show(picture, view.revision());
    drawn_.landscape_m = view.landscape_m();
    drawn_.march = view.settings.on_device ? &view.tables().march() : nullptr;
    drawn_.shadow = settings.shadows ? shadow_.map() : CloudShadowMap{};
    drawn_.shadow.offset_m += glm::vec2(drifted_m_);
    stage.drawn.clouds = &drawn_;
    stage.drawn.air_light = air_light_;
    stage.reports.push_back(report);
}

void CloudScene::show(const clouds::Picture& picture, std::uint32_t revision) {
    drawn_.radiance_cd_m2 = picture.radiance;
    drawn_.transmittance = picture.transmittance;
    drawn_.distance_m = picture.depth_m;
    drawn_.revision = revision;
}

bool CloudScene::show_reference(bool reference) {
    if (!view.reprojected()) {
        return false;
    }
    if (reference) {
        reference_picture_ = view.full_picture();
        show(reference_picture_, next_revision());
    } else {
        show(view.picture(), view.revision());
    }
    return true;
}

void CloudScene::draw_panel(PanelWriter& panel) {
    constexpr std::array names{"single", "Harris", "octaves", "transport"}; // as CloudMethod
    panel.choice("cloud light", names, settings.method);
    constexpr std::array marches{"device", "CPU"};
    if (device_) {
        panel.choice("cloud march", marches, settings.march);
    }
    panel.toggle("cloud shadows", settings.shadows);
    panel.slider("wind m/s", settings.wind_m_s, 0.0F, 60.0F);
    std::array<char, 96> line{};
    const auto write = [&](const char* format, auto... values) {
        std::snprintf(line.data(), line.size(), format, values...);
        panel.text(line.data());
    };
    if (view.settings.on_device) {
        write("clouds     %zu   %.1f MB of tables", entities_.size(),
              static_cast<double>(view.tables().bytes()) * 1e-6);
    } else {
        write("clouds     %zu   %.0f %% of the picture", entities_.size(), static_cast<double>(100.0F * covered_));
    }
    measure_error(); // only where somebody looks
    if (error_) {
        write("error      %.3f RMSE  %+.1f %% bias  (noise %.2f)", error_->relative_rmse, 100.0 * error_->bias,
              error_->noise);
    }
    if (psnr_db_ > 0.0) {
        write("moving     %.1f dB", psnr_db_);
    }
    write("CPU ms     modelled %.0f   light %.1f   march %.1f", model_s_ * 1e3, bake_ms_, march_ms_);
}

} // namespace alpenglow::sandbox
