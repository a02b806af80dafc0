#include "sandbox/app/probe_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>

#include <glm/geometric.hpp>

#include <alpenglow/components/cloud_cover.hpp>
#include <alpenglow/components/probe_receiver.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/probes/assemble.hpp>
#include <alpenglow/probes/grid.hpp>
#include <alpenglow/sh/dering.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/systems/probes.hpp>

#include "sandbox/app/probe_display.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;
constexpr float yard_radius_m = 11.0F;
constexpr float cos_quarter_degree = 0.99999048F;
constexpr int occlusion_rays = 1024;
constexpr float shown_mean_radius_m = 0.32F;
constexpr float ball_radius_m = 0.45F;
constexpr float ball_albedo = 0.4F;
constexpr std::uint32_t captures_per_frame = 2;

// A ball goes to and fro along a line.
struct Path {
    glm::vec3 middle_m, reach_m; // from the middle of the yard's floor
    double rate_rad_s, phase_rad;
};
constexpr std::array<Path, 6> paths{{
    {{-3.9F, 4.3F, 1.1F}, {2.5F, 0.0F, 0.0F}, 0.35, 0.4}, // in the arcade
    {{3.9F, 4.3F, 1.1F}, {2.5F, 0.0F, 0.0F}, 0.31, 2.6},
    {{0.0F, 2.0F, 1.1F}, {0.0F, 2.2F, 0.0F}, 0.40, 1.9},   // in and out of it
    {{-3.4F, -1.6F, 1.0F}, {2.6F, 0.0F, 0.0F}, 0.45, 2.4}, // in the yard
    {{3.4F, -1.6F, 1.0F}, {2.6F, 0.0F, 0.0F}, 0.38, 1.1},
    {{0.0F, -4.4F, 0.9F}, {6.0F, 0.0F, 0.0F}, 0.30, 1.9},
}};

bool in_view(const glm::mat4& clip, const glm::vec3& centre, float radius) {
    const auto row = [&clip](glm::length_t r) { return glm::vec4(clip[0][r], clip[1][r], clip[2][r], clip[3][r]); };
    const std::array<glm::vec4, 5> planes{row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(3)};
    return std::all_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
        return glm::dot(plane, glm::vec4(centre, 1.0F)) >= -radius * glm::length(glm::vec3(plane));
    });
}

// One channel of irradiance from coefficients of radiance.
std::array<double, 9> irradiance_channel(std::span<const glm::vec3> radiance, int channel) {
    std::array<double, 9> lux{};
    for (std::size_t i = 0; i < lux.size(); ++i) {
        lux[i] = radiance[i][channel];
    }
    sh::irradiance(3, std::span<const double>(lux), std::span<double>(lux));
    return lux;
}

// Squared L2 norm of the irradiance without its mean, over all channels.
double contrast_squared(std::span<const glm::vec3> radiance) {
    double sum = 0.0;
    for (int channel = 0; channel < 3; ++channel) {
        const std::array<double, 9> lux = irradiance_channel(radiance, channel);
        for (std::size_t i = 1; i < lux.size(); ++i) {
            sum += lux[i] * lux[i];
        }
    }
    return sum;
}

double band_1_norm(const probes::ProbeCoefficients& c) {
    return std::sqrt(static_cast<double>(glm::dot(c[1], c[1]) + glm::dot(c[2], c[2]) + glm::dot(c[3], c[3])));
}

} // namespace

ProbeScene::ProbeScene(BasicRegistry& registry, const World& world, const ProbeSettings& wanted)
    : settings(wanted), registry_(registry), yard_(world), grid_(registry.create()) {
    place_grid();
    registry_.emplace<CloudCover>(grid_, CloudCover{yard_.middle_m()});
    for (std::size_t i = 0; i < paths.size(); ++i) {
        balls_.push_back(registry_.create());
        registry_.emplace<ProbeReceiver>(balls_.back());
    }
    // Every other row of the upper layer is shown.
    const ProbeGrid& grid = registry_.get<ProbeGrid>(grid_);
    for (int j = 1; j < grid.count.y; j += 2) {
        for (int i = 0; i < grid.count.x; ++i) {
            const auto probe = static_cast<std::size_t>(i + grid.count.x * (j + 2 * grid.count.y));
            if (grid.valid[probe] != 0) {
                shown_.push_back(registry_.create());
                registry_.emplace<ProbeReceiver>(shown_.back(),
                                                 ProbeReceiver{.position_m = probes::probe_position_m(grid, probe)});
            }
        }
    }
    spheres_.resize(balls_.size());
}

ProbeScene::~ProbeScene() {
    for (const std::vector<Entity>* entities : {&balls_, &shown_}) {
        for (const Entity entity : *entities) {
            registry_.destroy(entity);
        }
    }
    registry_.destroy(grid_);
}

// Things move as long as time does, at the pace of real time.
void ProbeScene::update(Stage& stage) {
    const CloudCoverLight* cover = registry_.try_get<CloudCoverLight>(grid_);
    const YardLight light{.to_sun = stage.drawn.to_sun,
                          .to_moon = stage.drawn.to_moon,
                          .sun_lux = stage.drawn.sun_illuminance_lux * (cover != nullptr ? cover->sun : 1.0F),
                          .moon_lux = stage.drawn.moon_illuminance_lux * (cover != nullptr ? cover->moon : 1.0F),
                          .irradiance_matrix = stage.drawn.irradiance_matrix};
    prepare(stage.world_dt_s, light, stage.drawn.projection * stage.drawn.view);
    const bool yard_drawn = visible_ && draw_yard(light, stage.light_revision, cover != nullptr ? cover->revision : 0U);
    stage.drawn.probes = render_data(); // captures see the yard
    probes::Capture capture{.render = {}, .budget = captures_per_frame};
    if (stage.capture) {
        capture.render = [&stage](const glm::vec3& point_m, int face, [[maybe_unused]] int edge,
                                  std::span<glm::vec3> texels) { stage.capture(stage.drawn, point_m, face, texels); };
    }
    stage.reports.push_back(update_probes(registry_, stage.frame, capture));
    stage.reports.push_back(update_probe_receivers(registry_, stage.frame));
    stage.reports.push_back(finish(yard_drawn));
}

void ProbeScene::draw_panel(PanelWriter& panel) {
    constexpr std::array names{"none", "paper", "exact"}; // as Deringing
    int way = static_cast<int>(settings.deringing);
    if (panel.choice("deringing", names, way)) {
        settings.deringing = static_cast<Deringing>(way);
    }
    constexpr std::array sources{"assembled", "captured"}; // as ProbeSource
    int source = static_cast<int>(settings.source);
    if (panel.choice("probes", sources, source)) {
        settings.source = static_cast<ProbeSource>(source);
    }
    panel.toggle("show probes", settings.show);
    std::array<char, 96> line{};
    const auto write = [&](const char* format, auto... values) {
        std::snprintf(line.data(), line.size(), format, values...);
        panel.text(line.data());
    };
    write("window     sun %.3f   sky and ground %.3f", static_cast<double>(numbers_.direct_window),
          static_cast<double>(numbers_.least_window));
    write("min / mean %+.4f   of %u probes", static_cast<double>(numbers_.least_irradiance), numbers_.probes);
    write("contrast   %.3f kept, least %.3f", static_cast<double>(numbers_.contrast),
          static_cast<double>(numbers_.least_contrast));
}

// What stays: where probes stand, which are inside walls, and what walls and mountains hide of the sky.
void ProbeScene::place_grid() {
    ProbeGrid& grid = registry_.emplace<ProbeGrid>(grid_);
    grid.min_m = yard_.middle_m() + glm::vec3(-7.0F, -4.8F, 0.5F);
    grid.max_m = yard_.middle_m() + glm::vec3(7.0F, 4.8F, 2.1F);
    grid.count = {8, 7, 3};
    grid.deringing = settings.deringing;
    grid.source = settings.source;
    grid.ground_albedo = Yard::albedo;
    const std::size_t probes = probes::probe_count(grid);
    grid.valid.resize(probes);
    grid.sun_visibility.resize(probes);
    grid.moon_visibility.resize(probes);
    grid.occlusion.resize(9 * probes);
    constexpr double weight = 4.0 * std::numbers::pi / occlusion_rays;
    for (std::size_t p = 0; p < probes; ++p) {
        const glm::vec3 at = probes::probe_position_m(grid, p);
        grid.valid[p] = yard_.is_solid(at) ? 0 : 1;
        std::array<double, 9> hidden{};
        for (int ray = 0; ray < occlusion_rays / 2; ++ray) { // the upper half of the lattice comes first
            const glm::vec3 direction = lattice_direction(ray, occlusion_rays);
            if (yard_.hides(at, direction)) {
                std::array<float, 9> basis{};
                sh::evaluate_basis(3, direction, basis);
                for (std::size_t i = 0; i < hidden.size(); ++i) {
                    hidden[i] += weight * static_cast<double>(basis[i]);
                }
            }
        }
        for (std::size_t i = 0; i < hidden.size(); ++i) {
            grid.occlusion[i * probes + p] = static_cast<float>(hidden[i]);
        }
    }
}

// Visibilities are the mean over the middle third of the space between probes.
void ProbeScene::trace_lights(const YardLight& light) {
    const bool sun_moved = glm::dot(light.to_sun, traced_to_sun_) < cos_quarter_degree;
    const bool moon_moved = glm::dot(light.to_moon, traced_to_moon_) < cos_quarter_degree;
    if (!sun_moved && !moon_moved) {
        return;
    }
    ProbeGrid& grid = registry_.get<ProbeGrid>(grid_);
    const glm::vec3 spacing = (grid.max_m - grid.min_m) / glm::vec3(grid.count - 1);
    for (std::size_t p = 0; p < grid.valid.size(); ++p) {
        const glm::vec3 at = probes::probe_position_m(grid, p);
        if (sun_moved) {
            grid.sun_visibility[p] = yard_.visibility(at, spacing, light.to_sun);
        }
        if (moon_moved) {
            grid.moon_visibility[p] = yard_.visibility(at, spacing, light.to_moon);
        }
    }
    traced_to_sun_ = sun_moved ? light.to_sun : traced_to_sun_;
    traced_to_moon_ = moon_moved ? light.to_moon : traced_to_moon_;
}

void ProbeScene::move_balls() {
    for (std::size_t i = 0; i < balls_.size(); ++i) {
        const Path& path = paths[i];
        const auto along = static_cast<float>(std::cos(path.rate_rad_s * moved_s_ + path.phase_rad));
        ProbeReceiver& receiver = registry_.get<ProbeReceiver>(balls_[i]);
        receiver.position_m = yard_.middle_m() + path.middle_m + along * path.reach_m;
        receiver.visible = visible_;
    }
}

void ProbeScene::prepare(double dt_s, const YardLight& light, const glm::mat4& clip_from_world) {
    moved_s_ += dt_s;
    visible_ = in_view(clip_from_world, yard_.middle_m(), yard_radius_m);
    move_balls();
    for (const Entity entity : shown_) {
        registry_.get<ProbeReceiver>(entity).visible = visible_ && settings.show;
    }
    if (!visible_) {
        return;
    }
    ProbeGrid& grid = registry_.get<ProbeGrid>(grid_);
    if (grid.deringing != settings.deringing || grid.source != settings.source) {
        grid.deringing = settings.deringing;
        grid.source = settings.source;
        ++grid.revision;
    }
    trace_lights(light);
}

SystemReport ProbeScene::finish(bool yard_drawn) {
    SystemReport report{.system = "probe_yard", .considered = 2 + static_cast<std::uint32_t>(balls_.size())};
    const double start = thread_cpu_seconds();
    report.updated = yard_drawn ? 1U : 0U;
    if (visible_) {
        measure();
        report.updated += draw_display() ? 1U : 0U;
        report.updated += draw_balls() ? static_cast<std::uint32_t>(balls_.size()) : 0U;
    }
    report.skipped = report.considered - report.updated;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    return report;
}

void ProbeScene::measure() {
    const ProbeGrid& grid = registry_.get<ProbeGrid>(grid_);
    const ProbeGridSh& made = registry_.get<ProbeGridSh>(grid_);
    if (made.revision == measured_revision_) {
        return;
    }
    measured_revision_ = made.revision;
    numbers_ = {};
    numbers_.least_irradiance = 1.0F;
    const probes::DirectLight open = probes::direct_light(3, Deringing::none, made.target);
    const probes::DirectLight windowed = probes::direct_light(3, grid.deringing, made.target);
    const double band_1 = band_1_norm(open.sun) + band_1_norm(open.moon);
    numbers_.direct_window =
        band_1 > 0.0 ? static_cast<float>((band_1_norm(windowed.sun) + band_1_norm(windowed.moon)) / band_1) : 1.0F;
    const std::size_t probes = grid.valid.size();
    double contrast = 0.0;
    for (std::size_t p = 0; p < probes; ++p) {
        if (grid.valid[p] == 0 || made.made_pass[p] == 0 || !std::isfinite(made.window[p])) {
            continue;
        }
        ++numbers_.probes;
        numbers_.least_window = std::min(numbers_.least_window, made.window[p]);
        std::array<glm::vec3, 9> light{};
        for (std::size_t i = 0; i < light.size(); ++i) {
            light[i] = probes::coefficient(made, p, static_cast<int>(i));
        }
        for (int channel = 0; channel < 3; ++channel) {
            const std::array<double, 9> lux = irradiance_channel(light, channel);
            const double mean = lux[0] * 0.28209479177387814;
            if (mean > 0.0) {
                const auto least = static_cast<float>(sh::quadratic_minimum(lux).value / mean);
                numbers_.least_irradiance = std::min(numbers_.least_irradiance, least);
            }
        }
        std::array<float, 9> occlusion{};
        for (std::size_t i = 0; i < occlusion.size(); ++i) {
            occlusion[i] = grid.occlusion[i * probes + p];
        }
        const probes::ProbeCoefficients plain =
            probes::assemble_reference(3, Deringing::none, made.target,
                                       {.sun_visibility = made.made_sun_visibility[p],
                                        .moon_visibility = made.made_moon_visibility[p],
                                        .albedo = grid.ground_albedo,
                                        .occlusion = occlusion});
        const double before = contrast_squared(plain);
        const double kept = before > 0.0 ? std::sqrt(contrast_squared(light) / before) : 1.0;
        contrast += kept;
        numbers_.least_contrast = std::min(numbers_.least_contrast, static_cast<float>(kept));
    }
    numbers_.contrast = numbers_.probes > 0 ? static_cast<float>(contrast / numbers_.probes) : 1.0F;
}

// True where it was made anew.
bool ProbeScene::draw_yard(const YardLight& light, std::uint32_t light_revision, std::uint32_t cover_revision) {
    if (light_revision == yard_light_revision_ && cover_revision == yard_cover_revision_) {
        return false;
    }
    yard_light_revision_ = light_revision;
    yard_cover_revision_ = cover_revision;
    yard_vertices_.clear();
    yard_indices_.clear();
    yard_.append_mesh(light, yard_vertices_, yard_indices_);
    drawn_.yard = {yard_vertices_, yard_indices_, next_revision()};
    return true;
}

bool ProbeScene::draw_display() {
    if (settings.show == display_shows_probes_ && (!settings.show || measured_revision_ == display_probe_revision_)) {
        return false;
    }
    display_probe_revision_ = measured_revision_;
    display_shows_probes_ = settings.show;
    display_vertices_.clear();
    display_indices_.clear();
    for (const Entity entity : settings.show ? shown_ : std::vector<Entity>{}) {
        const auto& receiver = registry_.get<ProbeReceiver>(entity);
        const auto& received = registry_.get<ReceiverSh>(entity);
        append_probe_display(received.coefficients, receiver.position_m, shown_mean_radius_m, display_vertices_,
                             display_indices_);
    }
    drawn_.display = {display_vertices_, display_indices_, next_revision()};
    return true;
}

// True where one has moved or its light has changed.
bool ProbeScene::draw_balls() {
    bool changed = false;
    for (std::size_t i = 0; i < balls_.size(); ++i) {
        const auto& receiver = registry_.get<ProbeReceiver>(balls_[i]);
        const auto& received = registry_.get<ReceiverSh>(balls_[i]);
        LitSphere sphere{.centre_m = receiver.position_m, .radius_m = ball_radius_m, .radiance = {}};
        sh::irradiance(3, std::span(received.coefficients).first<9>(), std::span<glm::vec3>(sphere.radiance));
        for (glm::vec3& coefficient : sphere.radiance) {
            coefficient *= ball_albedo / pi_f;
        }
        changed = changed || sphere.centre_m != spheres_[i].centre_m || sphere.radiance != spheres_[i].radiance;
        spheres_[i] = sphere;
    }
    if (changed) {
        drawn_.spheres = spheres_;
        drawn_.spheres_revision = next_revision();
    }
    return changed;
}

} // namespace alpenglow::sandbox
