#include "sandbox/app/transfer_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <alpenglow/components/cloud_cover.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/prt/lobe.hpp>
#include <alpenglow/prt/neighbourhood.hpp>
#include <alpenglow/prt/shader_tables.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/systems/transfer.hpp>

#include "sandbox/app/transfer_smoke.hpp"
#include "sandbox/world/terrain_mesh.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float glider_above_m = 2.3F; // over the ground's middle
constexpr double glider_period_s = 24.0;
constexpr int smoke_columns = 36;
constexpr int smoke_rows = 56;

bool in_view(const glm::mat4& clip, const glm::vec3& centre, float radius) {
    const auto row = [&clip](glm::length_t r) { return glm::vec4(clip[0][r], clip[1][r], clip[2][r], clip[3][r]); };
    const std::array<glm::vec4, 5> planes{row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(3)};
    return std::all_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
        return glm::dot(plane, glm::vec4(centre, 1.0F)) >= -radius * glm::length(glm::vec3(plane));
    });
}

} // namespace

TransferScene::TransferScene(Stage& stage, const TransferSettings& wanted, std::filesystem::path cache)
    : settings(wanted), registry_(stage.registry), objects_(make_transfer_objects(stage.world, wanted)),
      receiver_(stage.registry.create()) {
    registry_.emplace<SkyLightReceiver>(receiver_, SkyLightReceiver{.bands = transfer_bands});
    std::vector<BakeJob> jobs;
    for (TransferObject& object : objects_.bodies) {
        add_body(object, jobs);
    }
    const auto add = [&](std::optional<BakeJob>& job, std::optional<Baked>& baked) {
        if (job) {
            baked = Baked{.entity = registry_.create(), .job = jobs.size(), .tables = {}, .meanwhile = {}};
            registry_.emplace<ObjectLight>(baked->entity);
            jobs.push_back(std::move(*job));
        }
    };
    add(objects_.around_glider, around_glider_);
    add(objects_.smoke, smoke_);
    if (around_glider_) {
        registry_.emplace<NeighbourhoodTransfer>(around_glider_->entity);
    }
    if (smoke_) {
        registry_.emplace<TransferVolume>(smoke_->entity);
    }
    left_.assign(bodies_[objects_.mound].vertices.size(), glm::vec3(1.0F));
    left_revision_ = next_revision();
    drawn_bodies_.resize(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        drawn_bodies_[i].mesh_revision = next_revision();
    }
    registry_.emplace<CloudCover>(receiver_, CloudCover{objects_.middle_m});
    const std::array<std::uint32_t, 4> packed =
        terrain_horizon(stage.world.terrain, stage.world.data.terrain, glm::vec2(objects_.middle_m));
    for (std::size_t k = 0; k < horizon_.size(); ++k) {
        horizon_[k] = static_cast<std::uint8_t>(packed[k / 4] >> (8U * static_cast<unsigned>(k % 4)) & 255U);
    }
    move_glider(0.0);
    bakes_ = std::make_unique<TransferBakes>(std::move(jobs), std::move(cache));
}

TransferScene::~TransferScene() {
    bakes_.reset();
    each_baked([this](Baked& baked, TransferSource&) { registry_.destroy(baked.entity); });
    registry_.destroy(receiver_);
}

void TransferScene::add_body(TransferObject& object, std::vector<BakeJob>& jobs) {
    Body& body = bodies_.emplace_back();
    const prt::Mesh& mesh = object.mesh;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        body.vertices.push_back({mesh.positions[v], mesh.normals[v], mesh.albedo[v]});
    }
    for (const glm::uvec3& t : mesh.triangles) {
        body.indices.insert(body.indices.end(), {t.x, t.y, t.z});
    }
    body.position_m = object.position_m;
    if (object.diffuse) {
        body.diffuse = Baked{.entity = registry_.create(), .job = jobs.size(), .tables = {}, .meanwhile = {}};
        if (Result<prt::TransferTable> table = unshadowed_table(mesh, transfer_bands)) {
            body.diffuse->meanwhile = std::make_shared<const prt::TransferTable>(std::move(table).value());
        }
        registry_.emplace<TransferMesh>(body.diffuse->entity);
        registry_.emplace<ObjectLight>(body.diffuse->entity);
        jobs.push_back(std::move(*object.diffuse));
    }
    if (object.glossy) {
        body.glossy = Baked{.entity = registry_.create(), .job = jobs.size(), .tables = {}, .meanwhile = {}};
        registry_.emplace<TransferMesh>(body.glossy->entity);
        registry_.emplace<ObjectLight>(body.glossy->entity);
        jobs.push_back(std::move(*object.glossy));
        prt::phong_kernel(object.phong_exponent, std::span(body.kernel).first<transfer_bands>());
    }
}

// f(baked, its component)
template <class F>
void TransferScene::each_baked(F&& f) {
    for (Body& body : bodies_) {
        for (std::optional<Baked>* baked : {&body.diffuse, &body.glossy}) {
            if (*baked) {
                f(**baked, static_cast<TransferSource&>(registry_.get<TransferMesh>((*baked)->entity)));
            }
        }
    }
    if (around_glider_) {
        f(*around_glider_, static_cast<TransferSource&>(registry_.get<NeighbourhoodTransfer>(around_glider_->entity)));
    }
    if (smoke_) {
        f(*smoke_, static_cast<TransferSource&>(registry_.get<TransferVolume>(smoke_->entity)));
    }
}

// Who is not seen asks for nothing.
void TransferScene::begin(Stage& stage) {
    const glm::mat4 clip = stage.camera.projection(static_cast<float>(stage.width) / static_cast<float>(stage.height)) *
                           stage.camera.view();
    visible_ = in_view(clip, objects_.middle_m + glm::vec3(0.0F, 8.0F, 2.0F), objects_.radius_m);
    registry_.get<SkyLightReceiver>(receiver_).visible = visible_;
}

void TransferScene::update(Stage& stage) {
    const bool by_shader = settings.path == TransferPath::shader ||
                           (settings.path == TransferPath::automatic && stage.quality == Quality::full);
    take_tables(by_shader);
    if (visible_) {
        light_all(stage);
    }
    move_glider(stage.world_dt_s);
    stage.reports.push_back(update_transfer(registry_, stage.frame));

    SystemReport report{.system = "transfer_scene", .considered = static_cast<std::uint32_t>(bodies_.size() + 2)};
    const double start = thread_cpu_seconds();
    if (visible_) {
        report.updated += shade_ground() ? 1U : 0U;
        for (std::size_t i = 0; i < bodies_.size(); ++i) {
            report.updated += shade(i, stage.camera.position_m, by_shader) ? 1U : 0U;
        }
        report.updated += shade_smoke(stage.camera.position_m) ? 1U : 0U;
        drawn_.bodies = drawn_bodies_;
        drawn_.by_shader = by_shader;
    }
    report.skipped = report.considered - report.updated;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    stage.reports.push_back(report);
    stage.drawn.transfer = render_data();
}

void TransferScene::take_tables(bool by_shader) {
    const auto level = static_cast<std::size_t>(settings.level);
    each_baked([&](Baked& baked, TransferSource& source) {
        if (!baked.taken) {
            baked.taken = bakes_->take(baked.job, baked.tables);
            if (baked.taken && baked.tables[0] == nullptr) {
                baked.tables[0] = baked.meanwhile;
            }
        }
        const std::shared_ptr<const prt::TransferTable>& table = baked.taken ? baked.tables[level] : baked.meanwhile;
        if (source.table != table) {
            source.table = table;
        }
        source.visible = visible_;
        source.on_gpu = by_shader && (!around_glider_ || baked.entity != around_glider_->entity) &&
                        (!smoke_ || baked.entity != smoke_->entity);
    });
}

void TransferScene::light_all(const Stage& stage) {
    const CloudCoverLight* cover = registry_.try_get<CloudCoverLight>(receiver_);
    const std::uint32_t covered = cover != nullptr ? cover->revision : 0;
    if (stage.light_revision == lit_by_ && covered == lit_below_ && settings.window == lit_through_) {
        return;
    }
    lit_by_ = stage.light_revision;
    lit_below_ = covered;
    lit_through_ = settings.window;
    SkyState sky = registry_.get<SkyState>(stage.sky);
    SkyLightSh sky_light = registry_.get<SkyLightSh>(stage.sky);
    if (cover != nullptr) {
        put_below_clouds(*cover,
                         std::span(sky_light.coefficients).first(std::size_t(sky_light.bands * sky_light.bands)));
        sky.sun_illuminance_lux *= cover->sun;
        sky.moon_illuminance_lux *= cover->moon;
    }
    light_ = transfer_light(stage.light, registry_.get<CelestialState>(stage.sky), sky, sky_light,
                            registry_.get<Atmosphere>(stage.sky), horizon_, settings.window);
    each_baked([this](Baked& baked, TransferSource&) {
        const bool diffuse = std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& body) {
            return body.diffuse && body.diffuse->entity == baked.entity;
        });
        const bool shadow = around_glider_ && around_glider_->entity == baked.entity;
        ObjectLight& light = registry_.get<ObjectLight>(baked.entity);
        light.bands = transfer_bands;
        light.coefficients = diffuse || shadow ? light_.coefficients : light_.sure;
        ++light.revision;
    });
}

// Around the mound, banked into the turn.
void TransferScene::move_glider(double dt_s) {
    glider_moved_ = glider_moved_ || dt_s > 0.0;
    moved_s_ += dt_s;
    const auto along = static_cast<float>(std::fmod(moved_s_ / glider_period_s + 0.87, 1.0) * 2.0 * std::numbers::pi);
    Body& body = bodies_[objects_.glider];
    const glm::vec3 centre = bodies_[objects_.mound].position_m;
    body.position_m = centre + glm::vec3(5.2F * std::cos(along), 4.2F * std::sin(along),
                                         glider_above_m + 0.3F * std::sin(2.0F * along));
    const glm::vec3 forward =
        glm::normalize(glm::vec3(-5.2F * std::sin(along), 4.2F * std::cos(along), 0.7F * std::cos(2.0F * along)));
    const glm::quat heading = glm::angleAxis(std::atan2(-forward.x, forward.y), glm::vec3(0.0F, 0.0F, 1.0F));
    const glm::quat climb = glm::angleAxis(std::asin(forward.z), glm::vec3(1.0F, 0.0F, 0.0F));
    const glm::quat bank = glm::angleAxis(-0.3F, glm::vec3(0.0F, 1.0F, 0.0F));
    body.turn = glm::normalize(heading * climb * bank);
    if (body.diffuse) {
        registry_.get<TransferMesh>(body.diffuse->entity).scene_from_object = body.turn;
    }
    if (around_glider_) {
        registry_.get<NeighbourhoodTransfer>(around_glider_->entity).scene_from_object = body.turn;
    }
}

// What the glider leaves of the ground's light: the light that its neighbourhood lets through over the light without
// it.
bool TransferScene::shade_ground() {
    if (!around_glider_) {
        return false;
    }
    const TransferResult* result = registry_.try_get<TransferResult>(around_glider_->entity);
    const std::shared_ptr<const prt::TransferTable>& table =
        registry_.get<NeighbourhoodTransfer>(around_glider_->entity).table;
    const std::uint32_t from = result != nullptr ? result->revision : 0;
    if (!glider_moved_ && table == left_table_ && (table == nullptr || from == left_from_)) {
        return false;
    }
    if (table == nullptr && left_table_ == nullptr && left_from_ == 0) {
        glider_moved_ = false;
        return false; // unshadowed, as it was
    }
    glider_moved_ = false;
    left_table_ = table;
    left_from_ = table == nullptr ? 0 : from;
    left_revision_ = next_revision();
    std::fill(left_.begin(), left_.end(), glm::vec3(1.0F));
    if (table == nullptr || result == nullptr || result->made_from_table != table) {
        return true;
    }
    const Body& glider = bodies_[objects_.glider];
    const Body& ground = bodies_[objects_.mound];
    const prt::TransferInfo& info = table->info;
    const glm::vec3 low = info.grid_origin_m;
    const glm::vec3 high = low + info.grid_step_m * glm::vec3(info.grid_size - 1U);
    const glm::quat back = glm::conjugate(glider.turn);
    const std::span<const glm::vec3> light = std::span(result->object_light).first(info.rows);
    for (std::size_t v = 0; v < left_.size(); ++v) {
        const glm::vec3 at = back * (ground.vertices[v].position_m + ground.position_m - glider.position_m);
        if (glm::any(glm::lessThan(at, low)) || glm::any(glm::greaterThan(at, high))) {
            continue;
        }
        const glm::vec3 normal = back * ground.vertices[v].normal;
        const glm::vec3 lit = prt::sample_neighbourhood(info, result->radiance, light, at, normal);
        const glm::vec3 open = prt::sample_neighbourhood(info, result->radiance, light, high + 1.0F, normal);
        const float floor = 1e-3F * std::max({open.x, open.y, open.z}) + 1e-12F;
        left_[v] = glm::clamp(lit / glm::max(open, glm::vec3(floor)), 0.0F, 1.5F);
    }
    return true;
}

void TransferScene::shade_on_cpu(Body& body, const TransferObject& object, const glm::vec3& camera_m) {
    const bool ground = &body == &bodies_[objects_.mound];
    std::fill(body.light.begin(), body.light.end(), glm::vec3(0.0F));
    if (const TransferResult* result = body.diffuse ? registry_.try_get<TransferResult>(body.diffuse->entity) : nullptr;
        result != nullptr && result->radiance.size() >= body.light.size()) {
        for (std::size_t v = 0; v < body.light.size(); ++v) {
            body.light[v] = body.vertices[v].albedo * glm::max(result->radiance[v], glm::vec3(0.0F));
            if (ground) {
                body.light[v] *= left_[v];
            }
        }
    }
    const TransferResult* gloss = body.glossy ? registry_.try_get<TransferResult>(body.glossy->entity) : nullptr;
    if (gloss == nullptr || gloss->made_from_table == nullptr || gloss->radiance.empty()) {
        return;
    }
    const prt::TransferInfo& info = gloss->made_from_table->info;
    const glm::vec3 eye = glm::conjugate(body.turn) * (camera_m - body.position_m);
    std::array<float, 25> y{};
    for (std::size_t v = 0; v < object.glossy_vertices; ++v) {
        const glm::vec3 normal = body.vertices[v].normal;
        const glm::vec3 view = glm::normalize(eye - body.vertices[v].position_m);
        const float cosine = glm::dot(normal, view);
        sh::evaluate_basis(transfer_bands, 2.0F * cosine * normal - view, y);
        glm::vec3 sum(0.0F);
        for (int l = 0; l < transfer_bands; ++l) {
            for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                const auto at = static_cast<std::size_t>(i);
                sum += body.kernel[static_cast<std::size_t>(l)] * y[at] * gloss->radiance[at * info.count + v];
            }
        }
        const float grazing = std::pow(1.0F - std::clamp(cosine, 0.0F, 1.0F), 5.0F); // Schlick
        body.light[v] += (object.specular + (1.0F - object.specular) * grazing) * glm::max(sum, glm::vec3(0.0F));
    }
}

// True where it was made anew.
bool TransferScene::shade(std::size_t index, const glm::vec3& camera_m, bool by_shader) {
    Body& body = bodies_[index];
    const TransferObject& object = objects_.bodies[index];
    TransferBody& drawn = drawn_bodies_[index];
    drawn.vertices = body.vertices;
    drawn.indices = body.indices;
    drawn.world_from_body = body.turn;
    drawn.position_m = body.position_m;
    const auto result_of = [&](const std::optional<Baked>& baked) {
        return baked && registry_.get<TransferMesh>(baked->entity).table != nullptr
                   ? registry_.try_get<TransferResult>(baked->entity)
                   : nullptr;
    };
    const TransferResult* diffuse = result_of(body.diffuse);
    const TransferResult* glossy = result_of(body.glossy);
    const std::uint32_t diffuse_revision = diffuse != nullptr ? diffuse->revision : 0;
    const std::uint32_t glossy_revision = glossy != nullptr ? glossy->revision : 0;
    const std::uint32_t ground = index == objects_.mound ? left_revision_ : 1;
    const bool first = body.light.empty() || body.by_shader != by_shader;
    const bool same_light = diffuse_revision == body.diffuse_revision && glossy_revision == body.glossy_revision;
    const bool same_view = by_shader || !body.glossy || camera_m == body.seen_from_m;
    if (!first && same_light && same_view && ground == body.shade_revision) {
        return false;
    }
    const bool new_factor = first || ground != body.shade_revision;
    body.diffuse_revision = diffuse_revision;
    body.glossy_revision = glossy_revision;
    body.shade_revision = ground;
    body.seen_from_m = camera_m;
    body.by_shader = by_shader;
    body.light.resize(body.vertices.size(), glm::vec3(1.0F));
    drawn.light = body.light;
    if (!by_shader) {
        shade_on_cpu(body, object, camera_m);
        drawn.light_revision = next_revision();
        return true;
    }
    if (new_factor) {
        if (index == objects_.mound) {
            body.light = left_;
        } else {
            std::fill(body.light.begin(), body.light.end(), glm::vec3(1.0F));
        }
        drawn.light = body.light;
        drawn.light_revision = next_revision();
    }
    if (!same_light || first) {
        bool new_tables = first;
        const auto shaded = [&](const TransferResult* result, std::shared_ptr<const prt::TransferTable>& held,
                                std::vector<glm::vec3>& light) {
            const std::shared_ptr<const prt::TransferTable> table =
                result != nullptr ? result->made_from_table : nullptr;
            new_tables = new_tables || held != table;
            held = table;
            if (table == nullptr) {
                return ShadedTable{};
            }
            light.resize(table->info.coefficients());
            light.resize(prt::shader_light(
                *table, std::span(result->object_light).first(std::size_t{transfer_bands} * transfer_bands), light));
            return ShadedTable{.blocks = table->blocks,
                               .rows = table->info.rows,
                               .channels = table->info.channels,
                               .coefficients = static_cast<std::uint32_t>(table->info.coefficients()),
                               .light = light};
        };
        drawn.diffuse = shaded(diffuse, body.diffuse_table, body.diffuse_light);
        drawn.glossy = shaded(glossy, body.glossy_table, body.glossy_light);
        drawn.specular = object.specular;
        drawn.glossy_vertices = static_cast<std::uint32_t>(object.glossy_vertices);
        drawn.kernel = body.kernel;
        drawn.table_revision = new_tables ? next_revision() : drawn.table_revision;
        drawn.shade_revision = next_revision();
    }
    return true;
}

bool TransferScene::shade_smoke(const glm::vec3& camera_m) {
    const TransferResult* result = smoke_ ? registry_.try_get<TransferResult>(smoke_->entity) : nullptr;
    if (result == nullptr || result->radiance.empty() ||
        (result->revision == smoke_from_ && camera_m == smoke_seen_from_m_)) {
        return false;
    }
    smoke_from_ = result->revision;
    smoke_seen_from_m_ = camera_m;
    draw_smoke(objects_.smoke_density, result->radiance, objects_.smoke_position_m, camera_m, smoke_columns, smoke_rows,
               smoke_vertices_, smoke_indices_);
    drawn_.smoke_vertices = smoke_vertices_;
    drawn_.smoke_indices = smoke_indices_;
    drawn_.smoke_revision = next_revision();
    return true;
}

bool TransferScene::press(int key) {
    if (key != 'T') {
        return false;
    }
    settings.level = static_cast<TransferLevel>((static_cast<int>(settings.level) + 1) % 3);
    return true;
}

void TransferScene::draw_panel(PanelWriter& panel) {
    constexpr std::array levels{"open", "shadows", "bounces"}; // as TransferLevel
    int level = static_cast<int>(settings.level);
    if (panel.choice("light (T)", levels, level)) {
        settings.level = static_cast<TransferLevel>(level);
    }
    constexpr std::array paths{"auto", "CPU", "shader"}; // as TransferPath
    int path = static_cast<int>(settings.path);
    if (panel.choice("by", paths, path)) {
        settings.path = static_cast<TransferPath>(path);
    }
    constexpr std::array windows{"none", "E", "half", "L"}; // as TransferWindow
    int window = static_cast<int>(settings.window);
    if (panel.choice("window", windows, window)) {
        settings.window = static_cast<TransferWindow>(window);
    }
    std::array<char, 128> line{};
    const auto write = [&](const char* format, auto... values) {
        std::snprintf(line.data(), line.size(), format, values...);
        panel.text(line.data());
    };
    const TransferBakes::State state = bakes_->state();
    if (!state.job.empty()) {
        write("baking     %zu of %zu: %s, %.0f %%", state.done + 1, bakes_->count(), state.job.c_str(),
              100.0 * state.fraction);
    } else {
        write("baked      %zu, %zu from the cache", state.done, state.from_cache);
    }
    for (const std::string& problem : {objects_.problem, state.problem}) {
        if (!problem.empty()) {
            panel.text(problem);
        }
    }
    write("it leaves  %.3f of band 1", static_cast<double>(light_.window));
}

} // namespace alpenglow::sandbox
