#include <alpenglow/impostors/scheduler.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>

#include <alpenglow/impostors/error.hpp>

namespace alpenglow::impostors {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double farthest_m = 1e18; // beyond, squares leave what the metrics can hold

// Error over tolerance; a tolerance of 0, below, or NaN lets nothing pass.
double over_tolerance(double error, double tolerance) {
    if (!std::isgreater(error, 0.0)) {
        return 0.0;
    }
    return std::isgreater(tolerance, 0.0) ? error / tolerance : infinite;
}

bool usable(const glm::dvec3& v) {
    return std::isless(std::abs(v.x), farthest_m) && std::isless(std::abs(v.y), farthest_m) &&
           std::isless(std::abs(v.z), farthest_m); // quietly false for NaN
}

bool usable(const SceneObject& object) {
    return usable(object.bounds.centre_m) && std::isgreaterequal(object.bounds.radius_m, 0.0) &&
           std::isless(object.bounds.radius_m, farthest_m);
}

bool usable(const Frustum& f) {
    const auto bounded = [](double low, double high) {
        return std::isfinite(low) && std::isfinite(high) && std::isgreater(high, low);
    };
    return f.width > 0 && f.height > 0 && usable(f.eye_m) && usable(f.forward) && usable(f.right) && usable(f.up) &&
           bounded(f.tan_left, f.tan_right) && bounded(f.tan_bottom, f.tan_top);
}

bool warped(Representation r) {
    return r == Representation::depth_warp || r == Representation::warped_layers;
}
bool single(Representation r) {
    return r == Representation::plane || r == Representation::depth_warp;
}

int layers_of(const SceneObject& object) {
    return single(object.representation) ? 1 : std::clamp(object.layers, 1, 16);
}

// Far down in resolution layers are the first thing to go.
void degrade(CaptureSettings& settings, int level) {
    if (level >= 2 && !single(settings.representation)) {
        settings.representation = warped(settings.representation) ? Representation::depth_warp : Representation::plane;
        settings.layers = 1;
    }
}

bool same(const Frustum& a, const Frustum& b) {
    return a.eye_m == b.eye_m && a.right == b.right && a.up == b.up && a.forward == b.forward && a.width == b.width &&
           a.height == b.height && a.tan_left == b.tan_left && a.tan_right == b.tan_right &&
           a.tan_bottom == b.tan_bottom && a.tan_top == b.tan_top;
}

double smooth(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

} // namespace

struct Scheduler::Candidate {
    std::size_t object = 0;
    std::size_t view = 0;
    Record* record = nullptr;
    double urgency = 0.0;
    double importance = 0.0;
    int required = 0;
    bool missing = false;
    SlotId judged = no_slot; // whose urgency it is
};

Result<Scheduler> Scheduler::create(const SchedulerSettings& settings) {
    auto atlas = Atlas::create(settings.atlas_side, settings.device_limit, settings.least_tile);
    if (!atlas) {
        return atlas.error();
    }
    const auto refuse = [](const char* field, double value, const char* expected) {
        return Error{std::string("it is ") + std::to_string(value), std::string("impostors: ") + field, expected};
    };
    if (settings.least_tile < 8) {
        return refuse("least_tile", settings.least_tile, "a power of two from 8");
    }
    if (settings.most_tile < settings.least_tile || settings.most_tile > settings.atlas_side) {
        return refuse("most_tile", settings.most_tile, "least_tile .. atlas_side");
    }
    if (!(settings.fade_s >= 0.0)) {
        return refuse("fade_s", settings.fade_s, "0 or more");
    }
    if (!(settings.headroom >= 1.0)) {
        return refuse("headroom", settings.headroom, "1 or more");
    }
    if (!(settings.inside_full >= 1.05) || !(settings.inside_start > settings.inside_full)) {
        return refuse("inside_start", settings.inside_start, "above inside_full, which is 1.05 or more");
    }
    if (!(settings.inside_downscale >= 1.0)) {
        return refuse("inside_downscale", settings.inside_downscale, "1 or more");
    }
    return Scheduler(settings, std::move(atlas.value()));
}

void Scheduler::set_budget(double texels, double ms) {
    settings_.budget_texels = texels;
    settings_.budget_ms = ms;
}

void Scheduler::measured(SlotId id, const Sensitivity& sensitivity, const glm::vec4& mean) {
    const auto slot = slots_.find(id);
    if (slot == slots_.end()) {
        return;
    }
    slot->second.sensitivity = sensitivity;
    if (const auto record = records_.find(slot->second.object); record != records_.end()) {
        record->second.mean = mean;
        if (settings_.detail_error > 0.0) { // what filtering loses grows with the square of the texel
            const double scale = std::sqrt(sensitivity.resample / settings_.detail_error);
            record->second.detail = std::clamp(slot->second.texels * scale / slot->second.required, 0.25, 1.0);
        }
    }
}

void Scheduler::measured_inside(std::uint64_t object, std::uint32_t view, const Sensitivity& sensitivity,
                                double downscale) {
    const auto record = records_.find(object);
    if (record == records_.end()) {
        return;
    }
    for (Shown& shown : record->second.shown) {
        if (shown.view == view) {
            shown.downscale = choose_downscale(sensitivity, downscale, settings_.inside_error);
        }
    }
}

void Scheduler::failed(SlotId id) {
    failed_.push_back(id);
}

void Scheduler::captured_in(double texels, double ms) {
    if (texels > 0.0 && ms >= 0.0 && std::isfinite(ms)) {
        const double now = ms / texels;
        ms_per_texel_ = ms_per_texel_ > 0.0 ? 0.8 * ms_per_texel_ + 0.2 * now : now;
    }
}

double Scheduler::urgency(const Slot& slot, const SceneObject& object, const Frustum& view, const Lights& lights,
                          int granted, double detail) const {
    const glm::dvec3 eye = view.eye_m - object.bounds.centre_m;
    const Tolerance& tolerance = object.tolerance;
    double worst = 0.0;
    if (eye != slot.eye_m) {
        const Sphere centred{glm::dvec3(0.0), std::max(object.bounds.radius_m, slot.radius_m)};
        if (slot.sensitivity) {
            const glm::dvec3 motion = eye - slot.eye_m;
            const glm::dvec3 t(glm::dot(motion, slot.frustum.right), glm::dot(motion, slot.frustum.up),
                               glm::dot(motion, slot.frustum.forward));
            const double squared =
                std::max(glm::dot(t, slot.sensitivity->radiance * t), glm::dot(t, slot.sensitivity->alpha * t));
            worst = std::max(worst, over_tolerance(std::sqrt(std::max(0.0, squared)), tolerance.image));
        }
        // The bound by geometry alone; what a warp leaves depends on the content, once that is known.
        if (!slot.sensitivity || !warped(slot.representation)) {
            const int planes = warped(slot.representation) ? (slot.layers + 1) / 2 : slot.layers;
            const double per_radian = pixels_per_radian(view, object.bounds);
            const auto share = [&](double angle) {
                return std::max(over_tolerance(angle, tolerance.angle_rad),
                                over_tolerance(angle * per_radian, tolerance.pixels));
            };
            const double quick = share(translation_angle_quick(centred, slot.eye_m, eye, planes));
            worst = std::max(worst, quick <= 0.5 * settings_.ahead
                                        ? quick
                                        : share(translation_angle(centred, slot.eye_m, eye, planes)));
        }
        if (object.phase_g != 0.0) {
            worst = std::max(
                worst, over_tolerance(view_shading_error(centred, slot.eye_m, eye, object.phase_g), tolerance.light));
        }
    }
    // Resolution: 0 with all the headroom left, 1 with none.
    if (slot.texels < granted) {
        const double need =
            std::min(required_texels(view, object.bounds, view.eye_m) * detail, static_cast<double>(granted));
        const double used = need * settings_.headroom / slot.texels;
        worst = std::max(worst, need > slot.texels
                                    ? need / slot.texels
                                    : std::max(0.0, (used - 1.0) / std::max(settings_.headroom - 1.0, 1e-6)));
    }
    worst = std::max(worst, over_tolerance(light_error(slot.lights, lights, object.phase_g), tolerance.light));
    if (slot.layers < layers_of(object) && degrade_level_ < 2) {
        worst = std::max(worst, 2.5); // asked for more layers since: something is inside now
    }
    return std::max(worst, over_tolerance(content_error(slot.content, object.content), tolerance.content));
}

void Scheduler::release(SlotId id, Plan& out) {
    const auto found = slots_.find(id);
    if (found == slots_.end()) {
        return;
    }
    for (const AtlasTile& tile : found->second.tiles) {
        atlas_.release(tile);
    }
    if (const auto owner = records_.find(found->second.object); owner != records_.end()) {
        Record& record = owner->second;
        std::erase(record.slots, id);
        for (Shown& shown : record.shown) {
            if (shown.before == id) {
                shown.before = no_slot;
            }
            if (shown.slot == id) {
                shown.slot = std::exchange(shown.before, no_slot);
            }
        }
    }
    slots_.erase(found);
    out.released.push_back(id);
}

void Scheduler::drop_unused(Record& record, Plan& out) {
    for (std::size_t i = record.slots.size(); i-- > 0;) {
        const SlotId id = record.slots[i];
        const bool used = std::any_of(record.shown.begin(), record.shown.end(),
                                      [id](const Shown& s) { return s.slot == id || s.before == id; });
        if (!used) {
            release(id, out);
        }
    }
}

// Room for `layers` tiles, evicting pictures that matter less: first those out of view, longest unseen first, then
// those that are smaller on screen. False, and nothing held, where there is none.
bool Scheduler::make_room(int texels, int layers, double importance, std::vector<AtlasTile>& tiles, Plan& out) {
    const auto give_back = [&] {
        for (const AtlasTile& tile : tiles) {
            atlas_.release(tile);
        }
        tiles.clear();
    };
    const auto take = [&] {
        while (static_cast<int>(tiles.size()) < layers) {
            const auto tile = atlas_.allocate(texels);
            if (!tile) {
                return false;
            }
            tiles.push_back(*tile);
        }
        return true;
    };
    if (take()) {
        return true;
    }
    struct Victim {
        std::tuple<bool, std::uint64_t, double, SlotId> order;
        std::int64_t texels;
    };
    std::vector<Victim> victims;
    std::int64_t within_reach = atlas_.free_texels();
    for (const auto& [id, slot] : slots_) {
        const bool seen = slot.last_used >= frame_;
        if (seen && slot.importance >= 0.8 * importance) {
            continue;
        }
        std::int64_t area = 0;
        for (const AtlasTile& tile : slot.tiles) {
            area += static_cast<std::int64_t>(tile.side) * tile.side;
        }
        victims.push_back({{seen, seen ? 0 : slot.last_used, slot.importance, id}, area});
        within_reach += area;
    }
    const std::int64_t side = atlas_.tile_side(texels);
    if (within_reach >= side * side * (layers - static_cast<std::int64_t>(tiles.size()))) {
        std::sort(victims.begin(), victims.end(), [](const Victim& a, const Victim& b) { return a.order < b.order; });
        // A large tile may need several neighbours gone; not at the price of many.
        std::int64_t worth = 4 * side * side * layers;
        for (const Victim& victim : victims) {
            worth -= victim.texels;
            if (worth < 0) {
                break;
            }
            release(std::get<3>(victim.order), out);
            ++out.report.evicted;
            if (take()) {
                return true;
            }
        }
    }
    give_back();
    return false;
}

void Scheduler::plan(std::span<const SceneObject> objects, std::span<const SceneView> views, const Lights& lights,
                     double now_s, Plan& out) {
    out = Plan{};
    ++frame_;
    for (const SlotId id : std::exchange(failed_, {})) {
        release(id, out);
    }
    ScheduleReport& report = out.report;

    double budget = std::isgreater(settings_.budget_texels, 0.0) ? settings_.budget_texels : 0.0;
    if (!std::isgreaterequal(settings_.budget_ms, infinite)) {
        const double ms = std::isgreater(settings_.budget_ms, 0.0) ? settings_.budget_ms : 0.0;
        constexpr double unknown = 65536.0; // until the first cost is known
        budget = std::min(budget, ms_per_texel_ > 0.0 ? ms / ms_per_texel_ : (ms > 0.0 ? unknown : 0.0));
    }
    const bool spread = std::isgreater(settings_.spread_frames, 1.0);
    const double backlog = spread && std::isgreater(backlog_, 0.0) ? backlog_ : 0.0;
    const auto pending = [&](SlotId id) { return spread && id != no_slot && !slots_.at(id).sensitivity; };
    if (spread) {
        budget *= settings_.spread_frames;
    }
    const double affordable = std::sqrt(std::min(budget, 1e9));

    // What can be seen, and how large.
    std::vector<Candidate> seen;
    for (std::size_t o = 0; o < objects.size(); ++o) {
        const SceneObject& object = objects[o];
        Record& record = records_[object.id];
        record.last_presented = frame_;
        std::erase_if(record.shown, [&](const Shown& s) {
            return std::none_of(views.begin(), views.end(), [&](const SceneView& view) { return view.id == s.view; });
        });
        for (std::size_t v = 0; v < views.size(); ++v) {
            ++report.considered;
            const Frustum& view = views[v].frustum;
            if (!usable(object) || !usable(view)) {
                ++report.rejected;
                continue;
            }
            if (!object.visible || !(object.bounds.radius_m > 0.0) || visible_rect(object.bounds, view).empty()) {
                continue;
            }
            const int required =
                static_cast<int>(std::ceil(required_texels(view, object.bounds, view.eye_m) * record.detail));
            const double pixels = 2.0 * object.bounds.radius_m /
                                  std::max(glm::length(object.bounds.centre_m - view.eye_m), object.bounds.radius_m) *
                                  std::max(view.pixels_per_tan_x(), view.pixels_per_tan_y());
            if (pixels < settings_.smallest_pixels) {
                continue;
            }
            seen.push_back({o, v, &record, 0.0, pixels, required, false, no_slot});
        }
    }
    report.seen = static_cast<std::uint32_t>(seen.size());
    for (auto it = records_.begin(); it != records_.end();) {
        if (it->second.last_presented == frame_) {
            ++it;
            continue;
        }
        it->second.shown.clear();
        drop_unused(it->second, out);
        it = records_.erase(it);
    }
    // Rehashing is over: records stay where they are.
    for (Candidate& c : seen) {
        c.record = &records_.at(objects[c.object].id);
    }

    // A resolution at which everything fits, with hysteresis.
    const auto granted_side = [&](int required, int level) {
        const double wanted = std::ceil(required * settings_.headroom) / std::exp2(level);
        return static_cast<int>(std::clamp(std::min(wanted, affordable), static_cast<double>(settings_.least_tile),
                                           static_cast<double>(settings_.most_tile)));
    };
    const auto demand = [&](int level) {
        double texels = 0.0;
        for (const Candidate& c : seen) {
            CaptureSettings s;
            s.representation = objects[c.object].representation;
            s.layers = layers_of(objects[c.object]);
            degrade(s, level);
            const double side = atlas_.tile_side(granted_side(c.required, level));
            texels += side * side * s.layers;
        }
        return texels / static_cast<double>(atlas_.texels());
    };
    int level = 0;
    while (level < 8 && demand(level) > (level >= degrade_level_ ? 0.75 : 0.6)) {
        ++level;
    }
    degrade_level_ = level;
    report.degrade_level = level;

    // What each shows now, and how wrong that is. Granted sizes are what a fresh capture could have.
    std::vector<DrawItem> draws;
    std::vector<Shown*> shown_of(seen.size(), nullptr);
    const auto shown_in = [&](Record& record, std::uint32_t view) -> Shown& {
        for (Shown& s : record.shown) {
            if (s.view == view) {
                return s;
            }
        }
        record.shown.push_back({});
        record.shown.back().view = view;
        return record.shown.back();
    };
    for (const Candidate& c : seen) { // all of them first: references into a vector that no longer grows
        (void)shown_in(*c.record, views[c.view].id);
    }
    const auto begin_fade = [&](Shown& shown, SlotId to) {
        const double weight =
            shown.before == no_slot ? 1.0 : smooth((now_s - shown.fade_start_s) / std::max(settings_.fade_s, 1e-9));
        // In the middle of a fade the more visible of the two goes on fading.
        if (shown.slot != no_slot && (weight >= 0.5 || shown.before == to)) {
            shown.before = shown.slot;
        }
        shown.slot = to;
        shown.fade_start_s = now_s;
        if (shown.before == to || !(settings_.fade_s > 0.0)) {
            shown.before = no_slot;
        }
    };
    std::vector<Candidate> due;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        Candidate& c = seen[i];
        const SceneObject& object = objects[c.object];
        const Frustum& view = views[c.view].frustum;
        Shown& shown = shown_in(*c.record, views[c.view].id);
        shown_of[i] = &shown;
        if (pending(shown.slot)) {
            shown.fade_start_s = now_s;
        }
        const double fade = now_s - shown.fade_start_s;
        if (shown.before != no_slot && !(fade >= 0.0 && fade < settings_.fade_s)) {
            shown.before = no_slot;
        }
        // The first half of a fade is left alone: what was renewed there would begin to fade in anew each time, and the
        // old picture would stay.
        const bool early = shown.before != no_slot && fade < 0.5 * settings_.fade_s;
        const double distance = glm::length(object.bounds.centre_m - view.eye_m) / object.bounds.radius_m;
        if (distance < settings_.inside_full) {
            shown.last_seen = frame_;
            continue; // the screen-aligned picture alone
        }
        const int granted = granted_side(c.required, level);
        c.missing = shown.slot == no_slot;
        if (!c.missing && !pending(shown.slot)) {
            c.urgency = urgency(slots_.at(shown.slot), object, view, lights, granted, c.record->detail);
        }
        if (c.missing || (c.urgency > 1.0 && !early)) { // another view's picture may do
            SlotId best = no_slot;
            double least = c.missing ? infinite : c.urgency;
            for (const SlotId id : c.record->slots) {
                const double u = id == shown.slot || pending(id)
                                     ? infinite
                                     : urgency(slots_.at(id), object, view, lights, granted, c.record->detail);
                if (u < least && (u <= settings_.ahead || c.missing)) {
                    least = u;
                    best = id;
                }
            }
            if (best != no_slot) {
                begin_fade(shown, best);
                c.urgency = least;
                c.missing = false;
            }
        }
        c.judged = shown.slot;
        for (const SlotId id : {shown.slot, shown.before}) {
            if (id != no_slot) {
                Slot& slot = slots_.at(id);
                slot.importance = slot.last_used == frame_ ? std::max(slot.importance, c.importance) : c.importance;
                slot.last_used = frame_;
            }
        }
        shown.last_seen = frame_;
        // In the second half only what has gone badly wrong is renewed.
        if (c.missing || (!early && c.urgency > (shown.before != no_slot ? 2.0 : settings_.ahead))) {
            due.push_back(c);
        }
    }

    // Screen-aligned pictures for viewers inside: nothing else can stand in for them.
    double spent = backlog;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const Candidate& c = seen[i];
        const SceneObject& object = objects[c.object];
        const Frustum& view = views[c.view].frustum;
        if (glm::length(object.bounds.centre_m - view.eye_m) >= settings_.inside_start * object.bounds.radius_m) {
            shown_of[i]->inside.reset();
            shown_of[i]->downscale = 0.0;
            continue;
        }
        Shown& shown = *shown_of[i];
        double downscale = shown.downscale > 0.0 ? shown.downscale : settings_.inside_downscale;
        // No more than half the budget, down to a picture of some 32 pixels.
        const double pixels = static_cast<double>(view.width) * view.height;
        const double most = std::max(1.0, std::min(view.width, view.height) / 32.0);
        if (pixels / (downscale * downscale) > 0.5 * budget) {
            downscale = budget > 0.0 ? std::max(downscale, std::sqrt(pixels / (0.5 * budget))) : most;
        }
        downscale = std::min(downscale, std::max(most, 1.0));
        const Frustum frustum = screen_aligned(view, downscale, settings_.margin_inside);
        const bool lights_hold = light_error(shown.inside_lights, lights, object.phase_g) <= object.tolerance.light;
        if (shown.inside && same(*shown.inside, frustum) && lights_hold && shown.inside_content == object.content) {
            continue;
        }
        shown.inside = frustum;
        shown.inside_content = object.content;
        shown.inside_lights = lights;
        const auto texels = static_cast<std::size_t>(frustum.width) * static_cast<std::size_t>(frustum.height);
        out.inside.push_back({c.object, c.view, frustum, downscale, texels});
        spent += spread ? 0.0 : static_cast<double>(texels);
        ++report.inside;
    }

    // Worst error first. Those with nothing to show come before all, the largest first.
    std::sort(due.begin(), due.end(), [&](const Candidate& a, const Candidate& b) {
        const auto key = [&](const Candidate& c) {
            return std::tuple(!c.missing, c.missing ? -c.importance : -c.urgency, -c.importance, objects[c.object].id,
                              views[c.view].id);
        };
        return key(a) < key(b);
    });
    double share = 1.0; // of their texels that missing ones get, for all to have some at once
    if (spread) {
        double demand_missing = 0.0;
        for (const Candidate& c : due) {
            const double side = c.missing ? granted_side(c.required, level) : 0.0;
            demand_missing += side * side * layers_of(objects[c.object]);
        }
        if (demand_missing > budget - spent) {
            share = std::max(0.0, budget - spent) / demand_missing;
        }
    }
    double hopeless = -infinite; // for what matters no more than this there is no room, and no more is made
    for (const Candidate& c : due) {
        const SceneObject& object = objects[c.object];
        const Frustum& view = views[c.view].frustum;
        Shown& shown = shown_in(*c.record, views[c.view].id);
        if (c.importance <= hopeless) {
            ++report.deferred;
            continue;
        }
        const bool must = c.missing || c.urgency > 1.0;
        int side = granted_side(c.required, level);
        if (c.missing && share < 1.0) {
            side = std::max(settings_.least_tile, static_cast<int>(side * std::sqrt(share)));
        }
        const double left = budget - spent;
        if (!must) { // ahead of need: within half the budget
            if (spent + static_cast<double>(side) * side > 0.5 * budget / (spread ? settings_.spread_frames : 1.0)) {
                continue;
            }
        } else if (static_cast<double>(side) * side > left) {
            // What is missing takes what is left, however coarse; what is merely old waits, unless it is the worst.
            const int coarse = left > 0.0 ? static_cast<int>(std::sqrt(left)) : 0;
            if (coarse >= settings_.least_tile && (c.missing || out.captures.empty())) {
                side = coarse;
            } else if (out.captures.empty()) {
                side = settings_.least_tile;
            } else {
                ++report.deferred;
                continue;
            }
        }
        CaptureSettings settings{.representation = object.representation,
                                 .layers = layers_of(object),
                                 .lights = lights,
                                 .content = object.content,
                                 .warp_cell = settings_.warp_cell};
        degrade(settings, level);
        std::vector<AtlasTile> tiles;
        while (!make_room(side, settings.layers, c.importance, tiles, out) && side > settings_.least_tile) {
            side = std::max(settings_.least_tile, side / 2);
        }
        if (tiles.empty()) {
            hopeless = std::max(hopeless, c.importance);
        }
        const std::optional<Frustum> frustum =
            tiles.empty() ? std::nullopt : fit_frustum(object.bounds, view.eye_m, view.up, side);
        if (!frustum) {
            for (const AtlasTile& tile : tiles) {
                atlas_.release(tile);
            }
            ++report.deferred;
            continue;
        }
        const SlotId id = next_slot_++;
        Slot& slot = slots_[id];
        slot.object = object.id;
        slot.eye_m = view.eye_m - object.bounds.centre_m;
        slot.frustum = *frustum;
        slot.representation = settings.representation;
        slot.layers = settings.layers;
        slot.texels = side;
        slot.required = required_texels(view, object.bounds, view.eye_m);
        slot.radius_m = object.bounds.radius_m;
        slot.tiles = tiles;
        slot.lights = lights;
        slot.content = object.content;
        slot.importance = infinite; // not to be evicted in the frame that it is drawn in
        slot.last_used = frame_;
        c.record->slots.push_back(id);
        begin_fade(shown, id);
        if (side < std::min(settings_.most_tile, c.required)) {
            ++report.degraded;
        }
        const auto texels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
        spent += static_cast<double>(texels);
        out.captures.push_back(
            {id, c.object, c.view, *frustum, settings, std::move(tiles), c.missing ? infinite : c.urgency, texels});
        ++report.captured;
    }
    report.texels = spent - backlog;

    // What is shown.
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const Candidate& c = seen[i];
        const SceneObject& object = objects[c.object];
        const Frustum& view = views[c.view].frustum;
        const Shown& shown = *shown_of[i];
        DrawItem item;
        item.object = c.object;
        item.view = c.view;
        item.distance_m = glm::length(object.bounds.centre_m - view.eye_m);
        item.impostor_weight =
            static_cast<float>(smooth((item.distance_m / object.bounds.radius_m - settings_.inside_full) /
                                      (settings_.inside_start - settings_.inside_full)));
        if (item.impostor_weight > 0.0F) {
            item.slot = shown.slot;
            item.before = shown.before;
            if (shown.slot == no_slot) {
                ++report.unserved;
            } else {
                item.urgency = shown.slot == c.judged ? c.urgency
                                                      : urgency(slots_.at(shown.slot), object, view, lights,
                                                                granted_side(c.required, level), c.record->detail);
                if (std::isfinite(item.urgency)) {
                    report.worst_urgency = std::max(report.worst_urgency, item.urgency);
                }
            }
            if (item.before != no_slot) {
                item.weight = static_cast<float>(smooth((now_s - shown.fade_start_s) / settings_.fade_s));
            }
        }
        item.stand_in = c.record->mean;
        draws.push_back(item);
    }
    std::sort(draws.begin(), draws.end(), [&](const DrawItem& a, const DrawItem& b) {
        return std::tuple(a.view, -a.distance_m, objects[a.object].id) <
               std::tuple(b.view, -b.distance_m, objects[b.object].id);
    });
    out.draws = std::move(draws);
    report.reused = report.seen - std::min(report.seen, report.captured + report.inside);

    for (const SceneObject& object : objects) {
        drop_unused(records_.at(object.id), out);
    }
}

} // namespace alpenglow::impostors
