#include "sandbox/app/impostor_inside.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "sandbox/app/impostor_work.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr double kTexels = 60000.0; // of a key, at most
constexpr double kLeastDownscale = 3.0;
constexpr double kMargin = 0.05;                  // of the window, for turns that were not foreseen
constexpr double kSlack = 0.01;                   // its last texels are held to the rim
constexpr double kLeastDepth = 20.0;              // of a mesh, over the way from key to key
constexpr int kShortest = 3, kLongest = 10;       // frames from key to key
constexpr double kJump_m = 40.0, kJump_rad = 0.2; // in one frame: not a flight

double work_of(double seen, double texels) {
    return seen * WorkCost::inside_seen_texel + (texels - seen) * WorkCost::inside_empty_texel;
}

double yaw_of(const glm::dvec3& forward) {
    return std::atan2(forward.x, forward.y);
}
double pitch_of(const glm::dvec3& forward) {
    return std::atan2(forward.z, std::hypot(forward.x, forward.y));
}

bool same_view(const impostors::Frustum& a, const impostors::Frustum& b) {
    return a.eye_m == b.eye_m && a.forward == b.forward && a.up == b.up && a.width == b.width && a.height == b.height &&
           a.tan_top == b.tan_top && a.tan_right == b.tan_right;
}

} // namespace

void ViewPrediction::see(const impostors::Frustum& view) {
    motion_m_ = view.eye_m - now_.eye_m;
    turn_ = std::remainder(yaw_of(view.forward) - yaw_of(now_.forward), 2.0 * 3.14159265358979323846);
    rise_ = pitch_of(view.forward) - pitch_of(now_.forward);
    if (glm::length(motion_m_) > kJump_m || std::abs(turn_) > kJump_rad || std::abs(rise_) > kJump_rad) {
        motion_m_ = glm::dvec3(0.0);
        turn_ = 0.0;
        rise_ = 0.0;
    }
    now_ = view;
}

impostors::Frustum ViewPrediction::after(int frames) const {
    impostors::Frustum view = now_;
    if (frames == 0 || (motion_m_ == glm::dvec3(0.0) && turn_ == 0.0 && rise_ == 0.0)) {
        return view;
    }
    view.eye_m += motion_m_ * static_cast<double>(frames);
    const double yaw = yaw_of(now_.forward) + turn_ * frames;
    const double pitch = std::clamp(pitch_of(now_.forward) + rise_ * frames, -1.55, 1.55);
    view.forward = {std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch), std::sin(pitch)};
    view.right = glm::normalize(glm::cross(view.forward, glm::dvec3(0.0, 0.0, 1.0)));
    view.up = glm::cross(view.right, view.forward);
    return view;
}

double ViewPrediction::motion_m() const {
    return glm::length(motion_m_);
}

bool covers(const impostors::Frustum& picture, const impostors::Frustum& view, double slack) {
    const double wide = slack * (picture.tan_right - picture.tan_left);
    const double high = slack * (picture.tan_top - picture.tan_bottom);
    for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec3 ray = view.direction(corner % 2 == 0 ? 0.0 : view.width, corner < 2 ? 0.0 : view.height);
        const double z = glm::dot(ray, picture.forward);
        if (!(z > 0.0)) {
            return false;
        }
        const double x = glm::dot(ray, picture.right) / z;
        const double y = glm::dot(ray, picture.up) / z;
        if (x < picture.tan_left - wide || x > picture.tan_right + wide || y < picture.tan_bottom - high ||
            y > picture.tan_top + high) {
            return false;
        }
    }
    return true;
}

InsidePictures::Cloud* InsidePictures::find(std::uint64_t object) {
    const auto found = clouds_.find(object);
    return found == clouds_.end() ? nullptr : &found->second;
}
const InsidePictures::Cloud* InsidePictures::find(std::uint64_t object) const {
    const auto found = clouds_.find(object);
    return found == clouds_.end() ? nullptr : &found->second;
}

// Tiles of one size, row by row.
std::optional<glm::ivec2> InsidePictures::free_tile(const glm::ivec4& strip, const glm::ivec2& size) const {
    for (int y = strip.y; y + size.y <= strip.y + strip.w; y += size.y) {
        for (int x = strip.x; x + size.x <= strip.x + strip.z; x += size.x) {
            const auto taken = [&](const Key& key) {
                return x < key.tile.x + key.view.width && key.tile.x < x + size.x && y < key.tile.y + key.view.height &&
                       key.tile.y < y + size.y;
            };
            const bool any = std::any_of(clouds_.begin(), clouds_.end(), [&](const auto& entry) {
                const Cloud& c = entry.second;
                return (c.from && taken(*c.from)) || (c.to && taken(*c.to)) || (c.march && taken(c.next));
            });
            if (!any) {
                return glm::ivec2(x, y);
            }
        }
    }
    return std::nullopt;
}

bool InsidePictures::begin(Cloud& cloud, const Wanted& wanted, const impostors::Frustum& view, int frames,
                           double downscale, const glm::ivec4& strip, const Subject& subject, const Cuts& cuts) {
    cloud.march.reset();
    const impostors::Frustum wide = impostors::screen_aligned(view, downscale, kMargin);
    std::optional<CloudSubject> what = subject(wanted.object);
    if (!what) {
        return false;
    }
    std::vector<Cut> at = cuts(wanted.object, wide, frames);
    const std::optional<glm::ivec2> tile =
        free_tile(strip, {wide.width, wide.height * static_cast<int>(at.size() + 1)});
    if (!tile) {
        return false;
    }
    std::vector<double> edges{0.0};
    for (const Cut& cut : at) {
        edges.push_back(cut.at_m);
    }
    edges.push_back(1e6);
    cloud.next_units = WorkCost::picture;
    cloud.next = Key{};
    cloud.next.view = wide;
    cloud.next.tile = *tile;
    cloud.next.cuts = std::move(at);
    cloud.next.content = wanted.content;
    what->march.optical_step = 0.25F; // as the picture is coarser anyway
    cloud.march.emplace(*what, wide, edges, false);
    return true;
}

void InsidePictures::finish(Cloud& cloud, std::vector<std::uint64_t>& taken, std::uint64_t object) {
    for (std::size_t k = 0; k <= cloud.next.cuts.size(); ++k) {
        const clouds::Picture& picture = cloud.march->slab(k);
        Slab slab;
        slab.texels.resize(picture.radiance.size());
        for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
            slab.texels[i] = glm::vec4(picture.radiance[i], 1.0F - picture.transmittance[i]);
        }
        slab.mesh = mean_depth_mesh(picture, cloud.next.view, kLeastDepth * prediction_.motion_m() * cloud.period);
        cloud.next.slabs.push_back(std::move(slab));
    }
    cloud.from = std::exchange(cloud.to, std::move(cloud.next));
    cloud.next = Key{};
    cloud.march.reset();
    cloud.since = 0;
    taken.push_back(object);
}

double InsidePictures::update(std::span<const Wanted> wanted, const impostors::Frustum& view, const glm::ivec4& strip,
                              double units, const Subject& subject, const Cuts& cuts,
                              std::vector<std::uint64_t>& taken) {
    prediction_.see(view);
    std::erase_if(clouds_, [&](const auto& entry) {
        return std::none_of(wanted.begin(), wanted.end(), [&](const Wanted& w) { return w.object == entry.first; });
    });
    const double pixels = static_cast<double>(view.width) * view.height;
    const double downscale = std::max(kLeastDownscale, std::sqrt(pixels / kTexels));
    const double key_units =
        WorkCost::picture + WorkCost::inside_seen_texel * pixels / (downscale * downscale) * (1.0 + 4.0 * kMargin);
    // As long as keys take within the budget, by what the last ones took.
    double needed = 0.0;
    for (const Wanted& w : wanted) {
        const Cloud* cloud = find(w.object);
        needed += cloud != nullptr && cloud->units > 0.0 ? cloud->units : key_units;
    }
    // Where things cut the clouds, a little longer: more of the pictures are in use there.
    const bool cut = std::any_of(clouds_.begin(), clouds_.end(),
                                 [](const auto& entry) { return entry.second.to && !entry.second.to->cuts.empty(); });
    const int shortest = cut ? kShortest + 1 : kShortest;
    const int wait = cut && wanted.size() > 1 ? 1 : 0;
    const int period =
        std::clamp(static_cast<int>(std::ceil(needed / std::max(units, 1.0))) + wait, shortest, kLongest);
    double spent = 0.0;
    bool begun = false;
    for (const Wanted& w : wanted) {
        Cloud& cloud = clouds_[w.object];
        ++cloud.since;
        const bool lost = cloud.to && !covers(cloud.to->view, view, kSlack);
        if ((lost || (!cloud.to && w.at_once)) && spent < units) { // a coarse one now
            if (begin(cloud, w, view, 0, 3.0 * downscale, strip, subject, cuts)) {
                while (!cloud.march->done()) {
                    const std::size_t before = cloud.march->texels_left();
                    const auto seen = static_cast<double>(cloud.march->march(cloud.next.view.height));
                    spent += work_of(seen, static_cast<double>(before - cloud.march->texels_left()));
                }
                cloud.next.coarse = true;
                finish(cloud, taken, w.object);
                cloud.from.reset();
                cloud.period = kShortest;
                spent += WorkCost::picture;
            }
        }
        // The next key comes when this one is due.
        if (cloud.march && cloud.march->done() && cloud.since >= cloud.period) {
            finish(cloud, taken, w.object);
            cloud.period = period;
        }
        if (!cloud.march) {
            const int ahead = (cloud.to ? std::max(cloud.period - cloud.since, 0) : 0) + period;
            const impostors::Frustum then = prediction_.after(ahead);
            const bool holds = cloud.to && !cloud.to->coarse && cloud.to->content == w.content &&
                               same_view(cloud.to->view, impostors::screen_aligned(then, downscale, kMargin));
            if (!holds && !begun && begin(cloud, w, then, ahead, downscale, strip, subject, cuts)) {
                spent += WorkCost::picture;
                begun = true; // one a frame: each costs its fields at once
                if (!cloud.to) {
                    cloud.period = period;
                    cloud.since = 0;
                }
            }
        }
        if (cloud.march && !cloud.march->done()) { // its share of the rows
            const int height = cloud.next.view.height * static_cast<int>(cloud.next.cuts.size() + 1);
            const int frames_left = std::max(1, cloud.period - cloud.since);
            const auto rows_left =
                static_cast<int>(cloud.march->texels_left() / static_cast<std::size_t>(cloud.next.view.width));
            const std::size_t before = cloud.march->texels_left();
            const int rows = std::clamp((rows_left + frames_left - 1) / frames_left, 1,
                                        std::max(1, (height + kShortest - 1) / kShortest));
            const auto seen = static_cast<double>(cloud.march->march(rows));
            const double work = work_of(seen, static_cast<double>(before - cloud.march->texels_left()));
            cloud.next_units += work;
            spent += work;
            if (cloud.march->done()) {
                cloud.units = cloud.next_units;
            }
        }
        cloud.weight = cloud.from
                           ? std::clamp(static_cast<float>(cloud.since) / static_cast<float>(std::max(cloud.period, 1)),
                                        0.0F, 1.0F)
                           : 1.0F;
    }
    return spent;
}

} // namespace alpenglow::sandbox
