#include "sandbox/app/impostor_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include <alpenglow/clouds/library.hpp>
#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/systems/cloud_impostors.hpp>
#include <alpenglow/systems/clouds.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr int kKinds = 5;
constexpr double kVoxelsAcross = 77.5; // of a cloud's longer side, about
constexpr float kUsual_m = 620.0F;
constexpr float kExtinction_per_m = 0.12F; // of a cloud of this size; others are as thick
constexpr float kDetailCells = 1.6F;       // of the texture a voxel
constexpr int kAtlasSide = 2048;
constexpr double kInsideCut_m = 60.0; // craft so close together make one cut of a screen-aligned picture,
constexpr double kNearCut_m = 25.0;   // the nearest of them
constexpr double kTouchedRadii = 2.2;
constexpr int kStrip = 1600;         // rows below the atlas, for screen-aligned pictures; below them the direct one
constexpr double kAround = 1.3;      // radii: clouds so near are marched by themselves
constexpr double kMargin = 0.08;     // of the view, where pictures are taken before they are seen
constexpr double kInsideShare = 0.5; // of the budget
constexpr double kLead = 10.0;       // frames before a cloud is entered
constexpr double kSpread = 3.0;
constexpr int kDividedLayers = 3;
constexpr double kOneCut_m = 120.0;
constexpr double kTouch_m = 60.0; // a craft this near to a cloud's box asks for layers
constexpr float kEncodeAgain = 0.02F;
constexpr int kEncodedAgainAFrame = 6;

impostors::SchedulerSettings scheduler_settings(const ImpostorSettings& settings) {
    impostors::SchedulerSettings s;
    s.atlas_side = kAtlasSide;
    s.budget_texels = settings.budget_texels;
    s.fade_s = 0.12;
    s.headroom = 1.35;
    s.warp_cell = kMeshCell;
    s.detail_error = 0.006;
    s.most_tile = 256;
    s.inside_full = 1.05;
    s.inside_start = 1.12;
    s.spread_frames = kSpread;
    return s;
}

float luminance(const glm::vec3& c) {
    return 0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b;
}

// Distances of the craft's triangles along the rays of a view, where they are nearer than what is there.
void draw_depth(std::span<const ColorVertex> triangles, const impostors::Frustum& view, std::vector<float>& distance) {
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
        std::array<glm::dvec3, 3> p; // x, y in pixels, 1 / axis depth
        bool ahead = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec3 v = glm::dvec3(triangles[t + k].position_m) - view.eye_m;
            const double z = glm::dot(v, view.forward);
            ahead = ahead && z > 0.5;
            p[k] = {(glm::dot(v, view.right) / z - view.tan_left) * view.pixels_per_tan_x(),
                    (view.tan_top - glm::dot(v, view.up) / z) * view.pixels_per_tan_y(), 1.0 / z};
        }
        const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
        if (!ahead || std::abs(area) < 1e-9) {
            continue;
        }
        const auto bound = [](double v, int size) {
            return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
        };
        const int x0 = bound(std::floor(std::min({p[0].x, p[1].x, p[2].x})), view.width);
        const int x1 = bound(std::ceil(std::max({p[0].x, p[1].x, p[2].x})), view.width);
        const int y0 = bound(std::floor(std::min({p[0].y, p[1].y, p[2].y})), view.height);
        const int y1 = bound(std::ceil(std::max({p[0].y, p[1].y, p[2].y})), view.height);
        for (int y = y0; y < y1; ++y) {
            for (int x = x0; x < x1; ++x) {
                const double px = x + 0.5;
                const double py = y + 0.5;
                const double b = ((px - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (py - p[0].y)) / area;
                const double c = ((p[1].x - p[0].x) * (py - p[0].y) - (px - p[0].x) * (p[1].y - p[0].y)) / area;
                if (b < 0.0 || c < 0.0 || b + c > 1.0) {
                    continue;
                }
                const double z = 1.0 / ((1.0 - b - c) * p[0].z + b * p[1].z + c * p[2].z);
                float& d = distance[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) +
                                    static_cast<std::size_t>(x)];
                d = std::min(d, static_cast<float>(z * glm::length(view.direction(px, py))));
            }
        }
    }
}

} // namespace

ImpostorScene::ImpostorScene(Stage& stage, const ImpostorSettings& settings)
    : stage_(stage), settings_(settings), voxel_m_(static_cast<double>(settings.size_m) / kVoxelsAcross),
      registry_(stage.registry) {
    view_ = registry_.create();
    registry_.emplace<ImpostorView>(view_);
    light_ = registry_.create();
    registry_.emplace<ImpostorLight>(light_);
    ImpostorFrame fresh;
    fresh.scheduler = impostors::Scheduler::create(scheduler_settings(settings)).value();
    registry_.ctx().emplace<ImpostorFrame>();
    registry_.ctx().get<ImpostorFrame>() = std::move(fresh);
    registry_.ctx().emplace<CloudBudget>();
    add_clouds(registry_);
}

ImpostorScene::~ImpostorScene() {
    for (const Cloud& cloud : clouds_) {
        registry_.destroy(cloud.entity);
    }
    for (const Kind& kind : kinds_) {
        registry_.destroy(kind.entity);
    }
    registry_.destroy(view_);
    registry_.destroy(light_);
}

// A field of clouds of a few kinds, each kind an entity that is lit once.
void ImpostorScene::add_clouds(BasicRegistry& registry) {
    if (settings_.clouds == 0) {
        return;
    }
    for (int k = 0; k < std::min(kKinds, settings_.clouds); ++k) {
        clouds::SparseGrid grid = clouds::coarsen(clouds::cumulus_of_study(static_cast<std::uint32_t>(k) + 1U), 1);
        clouds::GridTransform transform = grid.transform();
        transform.origin_m *= voxel_m_ / transform.voxel_m.x;
        transform.voxel_m = glm::dvec3(voxel_m_);
        grid.set_transform(transform);
        Kind kind;
        kind.volume = std::make_shared<const clouds::BrickVolume>(grid);
        kind.entity = registry.create();
        CloudVolume volume;
        volume.volume = kind.volume;
        volume.extinction_per_m = settings_.opacity * kExtinction_per_m * kUsual_m / settings_.size_m;
        volume.albedo = 0.998F;
        volume.anisotropy = 0.8F;
        registry.emplace<CloudVolume>(kind.entity, volume);
        registry.emplace<SkyLightReceiver>(kind.entity, SkyLightReceiver{.bands = 4}); // from the first frame on
        kinds_.push_back(std::move(kind));
    }
    std::vector<glm::dvec3> places =
        cloud_places(settings_.clouds, static_cast<double>(settings_.field_m), static_cast<double>(settings_.base_m));
    for (std::size_t i = 0; i < places.size(); ++i) {
        Cloud cloud;
        cloud.kind = i * 7 % kinds_.size();
        const clouds::BrickVolume& volume = *kinds_[cloud.kind].volume;
        const impostors::Sphere still = cloud_bounds(volume);
        const double half_height = 0.5 * voxel_m_ * static_cast<double>(volume.active_high().z - volume.active_low().z);
        cloud.offset_m = places[i] + glm::dvec3(0.0, 0.0, half_height) - still.centre_m;
        cloud.centre_m = still.centre_m + cloud.offset_m;
        cloud.radius_m = still.radius_m;
        cloud.entity = registry.create();
        Impostor impostor;
        impostor.centre_m = cloud.centre_m;
        impostor.radius_m = cloud.radius_m;
        impostor.kind = ImpostorKind::depth_warp;
        impostor.layers = 1;
        impostor.phase_g = 0.1; // what many scatterings leave of it
        impostor.max_light_error = 0.05;
        registry.emplace<Impostor>(cloud.entity, impostor);
        clouds_.push_back(cloud);
    }
    path_ = FlightPath(places, static_cast<double>(settings_.field_m), static_cast<double>(settings_.base_m));
}

void ImpostorScene::begin(Stage& stage) {
    time_s_ += stage.world_dt_s;
    craft_ =
        settings_.craft > 0 && !clouds_.empty() ? squadron_at(path_, settings_.craft, time_s_) : std::vector<Craft>{};
    if (settings_.follow && !craft_.empty()) {
        // Behind the squadron and above it, looking where it goes.
        const glm::dvec3 forward(craft_[0].axes[1]);
        const glm::dvec3 level = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 0.0, 1.0)));
        const std::vector<Craft> before = squadron_at(path_, 1, time_s_ - 2.6);
        const glm::dvec3 eye = before[0].position_m + glm::dvec3(0.0, 0.0, 110.0) + 25.0 * level;
        const glm::dvec3 look = craft_[0].position_m + 150.0 * forward + glm::dvec3(0.0, 0.0, 30.0) - eye;
        stage.camera.position_m = glm::vec3(eye);
        stage.camera.yaw_rad = static_cast<float>(std::atan2(look.x, look.y));
        stage.camera.pitch_rad = static_cast<float>(std::atan2(look.z, std::hypot(look.x, look.y)));
    }
}

// Light in the kinds of clouds; all of it at once before anything is shown, a little a frame from then on.
void ImpostorScene::update_kinds(Stage& stage) {
    registry_.ctx().get<CloudBudget>() = lit_ ? CloudBudget{.slices_per_frame = 2, .depths_per_frame = 1}
                                              : CloudBudget{.slices_per_frame = 1 << 20, .depths_per_frame = 1 << 10};
    lit_ = true;
    stage.reports.push_back(update_clouds(registry_, stage.frame));
    for (Kind& kind : kinds_) {
        const CloudLight& light = registry_.get<CloudLight>(kind.entity);
        if (kind.light_revision != 0 && light.revision != kind.light_revision) {
            kind.content += 0.002; // a slice's share of what a renewed light changes
        }
        kind.light_revision = light.revision;
    }
}

void ImpostorScene::update_craft(Stage& stage) {
    const SkyState& sky = registry_.get<SkyState>(stage.sky);
    const bool by_sun = sky.sun_illuminance_lux.g >= sky.moon_illuminance_lux.g;
    const glm::vec3 illuminance = by_sun ? sky.sun_illuminance_lux : sky.moon_illuminance_lux;
    constexpr float pi = std::numbers::pi_v<float>;
    glm::vec3 sky_light;
    for (int c = 0; c < 3; ++c) { // on a surface that faces up
        const glm::mat4& m = stage.light.irradiance_matrix[static_cast<std::size_t>(c)];
        sky_light[c] = std::max(0.0F, m[2][2] + 2.0F * m[2][3] + m[3][3]);
    }
    for (Cloud& cloud : clouds_) {
        cloud.touched = false;
    }
    std::vector<ColorVertex> triangles;
    for (const Craft& craft : craft_) {
        CraftLight light;
        light.to_light = by_sun ? stage.light.to_sun : stage.light.to_moon;
        light.direct = illuminance / pi;
        light.ambient = 0.7F * sky_light / pi;
        for (Cloud& cloud : clouds_) {
            const clouds::BrickVolume& volume = *kinds_[cloud.kind].volume;
            const glm::dvec3 p = volume.transform().index_from_world(craft.position_m - cloud.offset_m);
            const glm::dvec3 low = glm::dvec3(volume.active_low()) - kTouch_m / voxel_m_;
            const glm::dvec3 high = glm::dvec3(volume.active_high()) + kTouch_m / voxel_m_;
            if (glm::any(glm::lessThan(p, low)) || glm::any(glm::greaterThan(p, high))) {
                continue;
            }
            cloud.touched = true;
            const CloudLight& lit = registry_.get<CloudLight>(kinds_[cloud.kind].entity);
            if (lit.lighting != nullptr && !lit.lighting->lights().empty()) {
                const glm::vec3 index(glm::clamp(p, glm::dvec3(volume.active_low()), glm::dvec3(volume.active_high())));
                const float through = std::exp(-std::max(0.0F, lit.lighting->lights()[0].depth.sample(index)));
                light.direct *= through;
                light.ambient = glm::max(light.ambient * through, lit.lighting->mean_radiance(index));
            }
        }
        append_craft(craft, light, triangles);
    }
    if (triangles.size() != craft_triangles_.size() ||
        std::memcmp(triangles.data(), craft_triangles_.data(), triangles.size() * sizeof(ColorVertex)) != 0) {
        craft_triangles_ = std::move(triangles);
        data_.craft_revision = next_revision();
    }
    for (const Cloud& cloud : clouds_) {
        Impostor& impostor = registry_.get<Impostor>(cloud.entity);
        impostor.kind = cloud.touched ? ImpostorKind::warped_layers : ImpostorKind::depth_warp;
        impostor.layers = cloud.touched ? kDividedLayers : 1;
        impostor.max_error = static_cast<double>(settings_.max_error);
        impostor.content = kinds_[cloud.kind].content;
    }
}

float ImpostorScene::gain_now(const impostors::Capture& picture, float exposure) const {
    const impostors::Lights& now = registry_.ctx().get<ImpostorFrame>().lights;
    return exposure * luminance(impostors::light_gain(picture.lights, now).key);
}

void ImpostorScene::add_tile(const impostors::Capture& picture, std::size_t layer, const glm::ivec2& at) {
    const impostors::MipLevel& base = picture.layers[layer].mips.front();
    const impostors::Lights& now = registry_.ctx().get<ImpostorFrame>().lights;
    tiles_.push_back(
        {at.x, at.y, base.width, base.height, base.colour, impostors::light_gain(picture.lights, now).key});
}

std::optional<CloudSubject> ImpostorScene::subject_of(std::uint64_t object) const {
    const auto found = cloud_of_id_.find(object);
    if (found == cloud_of_id_.end()) {
        return std::nullopt;
    }
    const Cloud& cloud = clouds_[found->second];
    const CloudLight& light = registry_.get<CloudLight>(kinds_[cloud.kind].entity);
    if (light.lighting == nullptr) {
        return std::nullopt;
    }
    CloudSubject subject;
    subject.volume = kinds_[cloud.kind].volume.get();
    subject.lighting = light.lighting.get();
    subject.offset_m = cloud.offset_m;
    subject.march = march_settings();
    return subject;
}

// Screen-aligned pictures of the clouds that the viewer is in, or will be in soon.
void ImpostorScene::capture_inside(Stage& stage, std::vector<std::uint64_t>& taken) {
    const ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
    const impostors::Frustum view = camera_view();
    std::vector<InsidePictures::Wanted> wanted;
    for (const impostors::DrawItem& item : f.plan.draws) {
        const impostors::SceneObject& object = f.objects[item.object];
        // Where craft are in a cloud near by, its screen-aligned picture is marched between them.
        const double radii =
            clouds_[cloud_of_id_.at(object.id)].touched ? kTouchedRadii : f.scheduler.settings().inside_start;
        const double nearest = item.distance_m - radii * object.bounds.radius_m;
        if (nearest < kLead * motion_m_) {
            wanted.push_back({object.id, object.content, item.impostor_weight <= 0.0F});
        }
    }
    // Where craft will be in a cloud, nearest first; those close together make one cut.
    const auto cuts = [&](std::uint64_t object, const impostors::Frustum& then, int frames) {
        std::vector<InsidePictures::Cut> all;
        if (!clouds_[cloud_of_id_.at(object)].touched) {
            return all;
        }
        const std::vector<Craft> craft =
            squadron_at(path_, settings_.craft, time_s_ + static_cast<double>(frames) * stage.world_dt_s);
        std::vector<std::pair<double, std::size_t>> depths;
        for (std::size_t i = 0; i < craft.size(); ++i) {
            const double z = glm::dot(craft[i].position_m - then.eye_m, then.forward);
            if (z > static_cast<double>(craft[i].radius_m)) {
                depths.emplace_back(z, i);
            }
        }
        std::sort(depths.begin(), depths.end());
        double first = -1e9;
        for (const auto& [z, i] : depths) {
            if (z - first > (all.size() < 2 ? kNearCut_m : kInsideCut_m)) {
                first = z;
                all.emplace_back();
            }
            all.back().at_m = 0.5 * (first + z);
            all.back().things.push_back(i);
        }
        return all;
    };
    inside_units_ = inside_.update(
        wanted, view, {0, kAtlasSide, data_.atlas_width, kStrip}, kInsideShare * settings_.budget_texels,
        [&](std::uint64_t object) { return subject_of(object); }, cuts, taken);
    for (const std::uint64_t id : taken) {
        InsidePictures::Key& key = *inside_.find(id)->to;
        add_key(key);
        key.encoded_gain = stage.drawn.exposure;
    }
}

void ImpostorScene::add_key(const InsidePictures::Key& key) {
    for (std::size_t k = 0; k < key.slabs.size(); ++k) {
        const glm::ivec2 tile = key.tile_of(k);
        tiles_.push_back({tile.x, tile.y, key.view.width, key.view.height, key.slabs[k].texels, glm::vec3(1.0F)});
    }
}

// Where the exposure has moved on, pictures are encoded anew from what is kept of them.
void ImpostorScene::encode_again(float exposure) {
    const ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
    int again = 0;
    const auto moved = [&](float now, float before) {
        return std::abs(now / std::max(before, 1e-30F) - 1.0F) > kEncodeAgain;
    };
    for (const impostors::DrawItem& item : f.plan.draws) {
        for (const impostors::SlotId slot : {item.slot, item.before}) {
            const auto found = pictures_.find(slot);
            const impostors::Capture* taken = queue_.find(slot);
            if (found == pictures_.end() || taken == nullptr || again >= kEncodedAgainAFrame) {
                continue;
            }
            const float now = gain_now(*taken, exposure);
            if (moved(now, found->second.encoded_gain)) {
                for (std::size_t k = 0; k < taken->layers.size(); ++k) {
                    add_tile(*taken, k, {found->second.tiles[k].x, found->second.tiles[k].y});
                }
                found->second.encoded_gain = now;
                ++again;
            }
        }
        InsidePictures::Cloud* inside = inside_.find(f.objects[item.object].id);
        if (inside == nullptr) {
            continue;
        }
        for (std::optional<InsidePictures::Key>* key : {&inside->from, &inside->to}) {
            if (*key && moved(exposure, (*key)->encoded_gain)) {
                add_key(**key);
                (*key)->encoded_gain = exposure;
            }
        }
    }
}

// Works on the pictures that plans have asked for, within the frame's budget, and notes what has to be uploaded.
void ImpostorScene::capture(Stage& stage) {
    ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
    SystemReport report{.system = "captures"};
    const double cpu = process_cpu_seconds();
    for (const impostors::SlotId slot : f.plan.released) {
        pictures_.erase(slot);
        queue_.drop(slot);
    }
    for (const impostors::CaptureJob& job : f.plan.captures) {
        queue_.add(job, f.objects[job.object].id, f.objects[job.object].bounds);
    }
    std::vector<std::uint64_t> inside_taken;
    capture_inside(stage, inside_taken);
    const double budget = settings_.budget_texels;
    done_.clear();
    units_ = inside_units_ + queue_.work(
                                 std::max(budget - inside_units_, 0.25 * budget),
                                 [&](std::uint64_t object) { return subject_of(object); }, f.scheduler, done_);
    for (const impostors::CaptureJob& job : done_) {
        const impostors::Capture& taken = *queue_.find(job.slot);
        Picture& picture = pictures_[job.slot];
        picture.tiles = job.tiles;
        picture.layers.clear();
        for (std::size_t k = 0; k < taken.layers.size(); ++k) {
            picture.layers.push_back(picture_mesh(taken, k, taken.bounds.centre_m));
            add_tile(taken, k, {job.tiles[k].x, job.tiles[k].y});
        }
        picture.encoded_gain = gain_now(taken, stage.drawn.exposure);
        picture.since_s = f.now_s;
    }
    encode_again(stage.drawn.exposure);
    taken_ = static_cast<std::uint32_t>(done_.size() + inside_taken.size());
    capture_ms_ = (process_cpu_seconds() - cpu) * 1e3;
    report.considered = f.plan.report.seen;
    report.updated = taken_;
    report.skipped = report.considered - std::min(report.considered, report.updated);
    report.cpu_ms = capture_ms_;
    report.error_bound = budget > 0.0 ? units_ / budget : 0.0;
    stage.reports.push_back(report);
}

void ImpostorScene::add_item(const impostors::DrawItem& item, const impostors::SceneView& view) {
    const ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
    const Cloud& cloud = clouds_[cloud_of_id_.at(f.objects[item.object].id)];
    const auto corner = [](const impostors::AtlasTile& tile) {
        return glm::vec2(static_cast<float>(tile.x), static_cast<float>(tile.y));
    };
    // Layers of one picture from back to front, divided where craft are.
    const auto add_layers = [&](const impostors::Capture& taken, std::size_t k, const PictureMesh& mesh,
                                const glm::vec2& tile, float weight, const Fade& fade) {
        if (!cloud.touched) {
            builder_.add(mesh, tile, weight, fade, nullptr);
            return;
        }
        struct Cut {
            double in_picture, in_view, radius;
        };
        std::vector<Cut> cuts;
        const impostors::Layer& layer = taken.layers[k];
        for (const Craft& craft : craft_) {
            cuts.push_back({glm::dot(craft.position_m - taken.view.eye_m, taken.view.forward),
                            glm::dot(craft.position_m - view.frustum.eye_m, view.frustum.forward),
                            static_cast<double>(craft.radius_m)});
        }
        std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.in_picture > b.in_picture; });
        // Those that fly close together make one cut: each costs the whole layer once more.
        for (std::size_t c = 1; c < cuts.size();) {
            Cut& farther = cuts[c - 1];
            if (farther.in_picture - cuts[c].in_picture < kOneCut_m) {
                const double far = std::max(farther.in_view + farther.radius, cuts[c].in_view + cuts[c].radius);
                const double near = std::min(farther.in_view - farther.radius, cuts[c].in_view - cuts[c].radius);
                farther = {0.5 * (farther.in_picture + cuts[c].in_picture), 0.5 * (far + near), 0.5 * (far - near)};
                cuts.erase(cuts.begin() + static_cast<std::ptrdiff_t>(c));
            } else {
                ++c;
            }
        }
        // Between one cut and the next: what is behind the farthest first.
        double upper = layer.far_m;
        DepthPart part{view.frustum.eye_m, view.frustum.forward, 0.0, 1e30, 1.0F};
        const double thickness = std::max(layer.far_m - layer.near_m, 1e-6);
        for (std::size_t c = 0; c <= cuts.size(); ++c) {
            const double lower = c < cuts.size() ? std::clamp(cuts[c].in_picture, layer.near_m, upper) : layer.near_m;
            part.near_m = c < cuts.size() ? cuts[c].in_view + cuts[c].radius : 0.0;
            part.share = static_cast<float>((upper - lower) / thickness);
            if (part.share > 1e-3F && part.far_m > part.near_m) {
                builder_.add(mesh, tile, weight, fade, &part);
            } else if (part.share > 1e-3F) {
                part.near_m = part.far_m;
                builder_.add(mesh, tile, weight, fade, &part);
            }
            upper = lower;
            if (c < cuts.size()) {
                part.far_m = std::min(part.far_m, cuts[c].in_view - cuts[c].radius);
            }
        }
    };
    const auto now = pictures_.find(item.slot);
    const auto before = pictures_.find(item.before);
    const impostors::Capture* taken = queue_.find(item.slot);
    const impostors::Capture* taken_before = queue_.find(item.before);
    const InsidePictures::Cloud* in = inside_.find(f.objects[item.object].id);
    const bool has_inside = in != nullptr && in->to && (item.impostor_weight < 1.0F || cloud.touched);
    const bool has_tight = taken != nullptr && now != pictures_.end();
    // What is divided by craft cannot be faded layer by layer, for then things would shine through: it is exchanged.
    const bool single = has_inside && in->to->slabs.size() == 1 && has_tight && taken->layers.size() == 1;
    float tight_weight = has_inside ? item.impostor_weight : 1.0F;
    if (!single && has_inside) {
        tight_weight = tight_weight >= 0.5F && !cloud.touched ? 1.0F : 0.0F;
    }
    if (has_tight && tight_weight > 0.0F && !single) {
        for (std::size_t k = taken->layers.size(); k-- > 0;) {
            Fade fade;
            float weight = tight_weight;
            if (taken_before != nullptr && before != pictures_.end() &&
                taken_before->layers.size() == taken->layers.size()) {
                fade = {&taken_before->view, corner(before->second.tiles[k]), item.weight};
            } else if (taken_before == nullptr) { // out of nothing
                weight *= static_cast<float>(
                    std::clamp((f.now_s - now->second.since_s) / f.scheduler.settings().fade_s, 0.1, 1.0));
            }
            add_layers(*taken, k, now->second.layers[k], corner(now->second.tiles[k]), weight, fade);
        }
    } else if (!has_tight && tight_weight > 0.0F && taken_before != nullptr &&
               before != pictures_.end()) { // the new one is in the making
        for (std::size_t k = taken_before->layers.size(); k-- > 0;) {
            add_layers(*taken_before, k, before->second.layers[k], corner(before->second.tiles[k]), tight_weight, {});
        }
    }
    if (!has_inside || (tight_weight >= 1.0F && (has_tight || taken_before != nullptr))) {
        return;
    }
    const InsidePictures::Key& to = *in->to;
    for (std::size_t k = to.slabs.size(); k-- > 0;) { // from far to near, with the craft between
        Fade fade;
        if (single && tight_weight > 0.0F) {
            fade = {&taken->view, corner(now->second.tiles[0]), 1.0F - tight_weight};
        } else if (in->from && in->weight < 1.0F && in->from->slabs.size() == to.slabs.size()) {
            fade = {&in->from->view, glm::vec2(in->from->tile_of(k)), in->weight};
        }
        DepthPart part{view.frustum.eye_m, view.frustum.forward};
        const auto depths = [&](const InsidePictures::Cut& cut, double side) {
            double at = side > 0.0 ? 0.0 : 1e30;
            for (const std::size_t i : cut.things) {
                if (i < craft_.size()) {
                    const double z = glm::dot(craft_[i].position_m - view.frustum.eye_m, view.frustum.forward);
                    const double reach = z + side * static_cast<double>(craft_[i].radius_m);
                    at = side > 0.0 ? std::max(at, reach) : std::min(at, reach);
                }
            }
            return at;
        };
        if (k > 0) {
            part.near_m = depths(to.cuts[k - 1], 1.0);
        }
        if (k < to.cuts.size()) {
            part.far_m = std::max(depths(to.cuts[k], -1.0), 1.5);
            part.near_m = std::min(part.near_m, part.far_m);
        }
        builder_.add(to.slabs[k].mesh, glm::vec2(to.tile_of(k)), 1.0F, fade, to.cuts.empty() ? nullptr : &part);
    }
}

clouds::MarchSettings ImpostorScene::march_settings() const {
    clouds::MarchSettings settings;
    if (settings_.detail > 0.0F) {
        settings.detail = &detail_;
        settings.detail_strength = settings_.detail;
        settings.detail_cells = kDetailCells;
    }
    return settings;
}

void ImpostorScene::build(const Stage& stage) {
    const ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
    // Nothing moved, nothing is built.
    std::uint64_t state = 14695981039346656037ULL;
    const auto mix = [&](std::uint64_t word) { state = (state ^ word) * 1099511628211ULL; };
    const auto mix_real = [&](double value) {
        std::uint64_t word = 0;
        std::memcpy(&word, &value, sizeof word);
        mix(word);
    };
    const impostors::Frustum& view = f.views.front().frustum;
    for (const double value : {view.eye_m.x, view.eye_m.y, view.eye_m.z, view.forward.x, view.forward.y, view.forward.z,
                               view.up.x, view.up.y, view.up.z, view.tan_top, view.tan_right}) {
        mix_real(value);
    }
    for (const impostors::DrawItem& item : f.plan.draws) {
        mix(item.slot);
        mix(item.before);
        mix_real(static_cast<double>(item.weight));
    }
    mix(data_.craft_revision);
    for (const impostors::DrawItem& item : f.plan.draws) {
        const InsidePictures::Cloud* inside = inside_.find(f.objects[item.object].id);
        mix_real(inside != nullptr ? static_cast<double>(inside->weight) : 2.0);
        const auto found = pictures_.find(item.slot);
        mix_real(found == pictures_.end() ? -1.0
                                          : std::min(f.now_s - found->second.since_s, f.scheduler.settings().fade_s));
    }
    mix(settings_.outlines ? 1U : 0U);
    if (state == drawn_state_ && taken_ == 0) {
        return;
    }
    drawn_state_ = state;
    builder_.clear();
    for (const impostors::DrawItem& item : f.plan.draws) {
        add_item(item, f.views[item.view]);
    }
    data_.vertices = builder_.vertices();
    data_.indices = builder_.indices();
    data_.runs = builder_.runs();
    data_.mesh_revision = next_revision();
    build_outlines();
    static_cast<void>(stage);
}

// Each picture's window in the plane that it stands in: green where it is used again, red where it was taken in this
// frame, yellow while one takes over from another (003, figure 10).
void ImpostorScene::build_outlines() {
    outline_vertices_.clear();
    if (settings_.outlines) {
        const ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
        for (const impostors::DrawItem& item : f.plan.draws) {
            const impostors::Capture* taken = queue_.find(item.slot);
            if (taken == nullptr || item.impostor_weight <= 0.0F) {
                continue;
            }
            const bool fresh = std::any_of(done_.begin(), done_.end(),
                                           [&](const impostors::CaptureJob& job) { return job.slot == item.slot; });
            const glm::vec4 colour = fresh                               ? glm::vec4(1.0F, 0.05F, 0.02F, 1.0F)
                                     : item.before != impostors::no_slot ? glm::vec4(0.9F, 0.7F, 0.02F, 1.0F)
                                                                         : glm::vec4(0.05F, 0.7F, 0.1F, 1.0F);
            const impostors::Frustum& v = taken->view;
            const double z = glm::length(taken->bounds.centre_m - v.eye_m);
            std::array<glm::vec3, 4> corners;
            for (std::size_t c = 0; c < 4; ++c) {
                const double x = c == 1 || c == 2 ? v.width : 0.0;
                const double y = c >= 2 ? v.height : 0.0;
                corners[c] = glm::vec3(v.eye_m + z * v.direction(x, y));
            }
            for (std::size_t c = 0; c < 4; ++c) {
                outline_vertices_.push_back({corners[c], colour});
                outline_vertices_.push_back({corners[(c + 1) % 4], colour});
            }
        }
    }
    data_.outlines = outline_vertices_;
    data_.outlines_revision = next_revision();
}

void ImpostorScene::update(Stage& stage) {
    if (!kinds_.empty()) {
        update_kinds(stage);
    }
    update_craft(stage);
    const Camera& camera = stage.camera;
    ImpostorView& view = registry_.get<ImpostorView>(view_);
    view.eye_m = glm::dvec3(camera.position_m);
    view.forward = glm::normalize(glm::dvec3(camera.forward()));
    view.right = glm::normalize(glm::cross(view.forward, glm::dvec3(0.0, 0.0, 1.0)));
    view.up = glm::cross(view.right, view.forward);
    const impostors::Frustum wide = impostors::screen_aligned(camera_view(), 1.0, kMargin);
    view.tan_left = wide.tan_left;
    view.tan_right = wide.tan_right;
    view.tan_bottom = wide.tan_bottom;
    view.tan_top = wide.tan_top;
    view.width_px = wide.width;
    view.height_px = wide.height;
    motion_m_ = frames_ > 0 ? glm::length(view.eye_m - eye_before_m_) : 0.0;
    motion_m_ = motion_m_ < 40.0 ? motion_m_ : 0.0; // not a flight
    eye_before_m_ = view.eye_m;
    ++frames_;
    const SkyState& sky = registry_.get<SkyState>(stage.sky);
    const bool by_sun = sky.sun_illuminance_lux.g >= sky.moon_illuminance_lux.g;
    ImpostorLight& light = registry_.get<ImpostorLight>(light_);
    light.to_key = by_sun ? stage.light.to_sun : stage.light.to_moon;
    light.key_lux = glm::max(by_sun ? sky.sun_illuminance_lux : sky.moon_illuminance_lux, glm::vec3(1e-6F));

    const int width = std::max(kAtlasSide, stage.width);
    const int height = kAtlasSide + kStrip + 2 * stage.height;
    if (width != data_.atlas_width || height != data_.atlas_height) { // a new atlas: all pictures again
        data_.atlas_width = width;
        data_.atlas_height = height;
        for (auto& [slot, picture] : pictures_) {
            picture.encoded_gain = 0.0F;
        }
        inside_.clear(); // views of another size
    }
    tiles_.clear();
    if (settings_.direct) {
        show_direct(stage);
        return;
    }
    ImpostorFrame& f = registry_.ctx().get<ImpostorFrame>();
    f.scheduler.set_budget(std::max(settings_.budget_texels - inside_units_, 0.25 * settings_.budget_texels));
    f.scheduler.set_backlog(queue_.left());
    stage.reports.push_back(update_impostors(registry_, stage.frame));
    schedule_ = f.plan.report;
    cloud_of_id_.clear();
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
        cloud_of_id_[registry_.get<ImpostorState>(clouds_[i].entity).id] = i;
    }
    capture(stage);
    schedule_.captured = taken_;
    schedule_.reused = schedule_.seen - std::min(schedule_.seen, taken_);
    reuse_ += 0.05 * (static_cast<double>(schedule_.reused) / std::max(1U, schedule_.seen) - reuse_);
    if (!tiles_.empty()) {
        data_.tiles_revision = next_revision();
    }
    data_.tiles = tiles_;
    data_.craft = craft_triangles_;
    build(stage);
    stage.drawn.impostors = &data_;
}

bool ImpostorScene::show_reference(bool reference) {
    if (settings_.direct) {
        return false;
    }
    if (reference) {
        show_direct(stage_);
    } else {
        stage_.drawn.impostors = &data_;
    }
    return true;
}

impostors::Frustum ImpostorScene::camera_view() const {
    const ImpostorView& v = registry_.get<ImpostorView>(view_);
    const double tangent = std::tan(0.5 * static_cast<double>(stage_.camera.fov_y_rad));
    const double aspect = static_cast<double>(stage_.width) / stage_.height;
    return {v.eye_m,          v.right,  v.up,    v.forward,    -tangent * aspect,
            tangent * aspect, -tangent, tangent, stage_.width, stage_.height};
}

std::vector<std::size_t> ImpostorScene::visible_clouds() const {
    std::vector<std::size_t> seen;
    const impostors::Frustum frustum = camera_view();
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
        if (!impostors::visible_rect({clouds_[i].centre_m, clouds_[i].radius_m}, frustum).empty()) {
            seen.push_back(i);
        }
    }
    return seen;
}

void ImpostorScene::show_direct(Stage& stage) {
    SystemReport report{.system = "direct_march"};
    const double cpu = process_cpu_seconds();
    const impostors::Frustum frustum = camera_view();
    std::vector<float> distance(static_cast<std::size_t>(stage.width) * static_cast<std::size_t>(stage.height), 1e30F);
    draw_depth(craft_triangles_, frustum, distance);
    clouds::MarchSettings settings = march_settings();
    settings.scene_depth_m = distance;
    direct_builder_.clear();
    direct_tiles_ = tiles_;
    // Those that the viewer is in by themselves: the air before them is not that before the clouds behind.
    for (const bool around : {false, true}) {
        std::vector<clouds::LitCloud> lit;
        for (const std::size_t i : visible_clouds()) {
            const Cloud& cloud = clouds_[i];
            const Kind& kind = kinds_[cloud.kind];
            const CloudLight& light = registry_.get<CloudLight>(kind.entity);
            if (light.lighting != nullptr &&
                (glm::length(cloud.centre_m - frustum.eye_m) < kAround * cloud.radius_m) == around) {
                lit.push_back({kind.volume.get(), light.lighting.get(), cloud.offset_m});
            }
        }
        if (lit.empty()) {
            continue;
        }
        report.updated += static_cast<std::uint32_t>(lit.size());
        const clouds::Picture picture = clouds::march(lit, cloud_camera(frustum), settings);
        std::vector<glm::vec4>& texels = direct_texels_[around ? 1 : 0];
        texels.resize(distance.size());
        for (std::size_t i = 0; i < distance.size(); ++i) {
            texels[i] = glm::vec4(picture.radiance[i], 1.0F - picture.transmittance[i]);
        }
        const int top = kAtlasSide + kStrip + (around ? stage.height : 0);
        direct_builder_.add(picture_mesh(picture, frustum), glm::vec2(0.0F, static_cast<float>(top)), 1.0F, {},
                            nullptr);
        direct_tiles_.push_back({0, top, stage.width, stage.height, texels, glm::vec3(1.0F)});
    }
    direct_data_ = data_;
    direct_data_.tiles = direct_tiles_;
    direct_data_.tiles_revision = next_revision();
    direct_data_.vertices = direct_builder_.vertices();
    direct_data_.indices = direct_builder_.indices();
    direct_data_.runs = direct_builder_.runs();
    direct_data_.mesh_revision = next_revision();
    direct_data_.craft = craft_triangles_;
    direct_data_.outlines = {};
    direct_data_.outlines_revision = next_revision();
    stage.drawn.impostors = &direct_data_;
    report.considered = static_cast<std::uint32_t>(clouds_.size());
    report.cpu_ms = (process_cpu_seconds() - cpu) * 1e3;
    stage.reports.push_back(report);
}

void ImpostorScene::draw_panel(PanelWriter& panel) {
    std::array<char, 160> line{};
    const auto text = [&](const char* format, auto... values) {
        std::snprintf(line.data(), line.size(), format, values...);
        panel.text(line.data());
    };
    text("clouds seen %u, pictures taken %u, inside %u", schedule_.seen, schedule_.captured, schedule_.inside);
    text("reused %.1f %%, largest error %.2f of its tolerance", 100.0 * reuse_, schedule_.worst_urgency);
    text("captures %.1f ms, %.0f texels", capture_ms_, schedule_.texels);
    if (psnr_db_ > 0.0) {
        text("PSNR against direct drawing %.1f dB", psnr_db_);
    }
    panel.slider("tolerance", settings_.max_error, 0.002F, 0.2F, true);
    panel.toggle("outlines (O)", settings_.outlines);
    panel.toggle("march directly (B)", settings_.direct);
    panel.toggle("fly with the squadron (F)", settings_.follow);
}

bool ImpostorScene::press(int key) {
    switch (key) {
    case 'O':
        settings_.outlines = !settings_.outlines;
        return true;
    case 'B':
        settings_.direct = !settings_.direct;
        return true;
    case 'F':
        settings_.follow = !settings_.follow;
        return true;
    default:
        return false;
    }
}

} // namespace alpenglow::sandbox
