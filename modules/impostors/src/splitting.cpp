#include <alpenglow/impostors/splitting.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include <glm/geometric.hpp>

#include <alpenglow/impostors/error.hpp>

namespace alpenglow::impostors {
namespace {

bool touch(const Sphere& a, const Sphere& b) {
    return glm::length(a.centre_m - b.centre_m) < a.radius_m + b.radius_m;
}

// Whether any ray from the eye can meet both.
bool share_rays(const Sphere& a, const Sphere& b, const glm::dvec3& eye) {
    const auto half_angle = [&eye](const Sphere& s) {
        const double d = glm::length(s.centre_m - eye);
        return d > s.radius_m ? std::asin(s.radius_m / d) : 4.0;
    };
    return angle_between(a.centre_m - eye, b.centre_m - eye) < half_angle(a) + half_angle(b);
}

double power(const Sphere& s, const glm::dvec3& eye) {
    const double d = glm::length(s.centre_m - eye);
    return (d - s.radius_m) * (d + s.radius_m);
}

// Ascending, without twins, at most `most`: the cut that leaves the thinnest piece goes first.
void thin_out(std::vector<double>& cuts, std::size_t most) {
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    if (most == 0) {
        cuts.clear();
    }
    while (cuts.size() > most) { // there are two at least
        std::size_t closest = 1;
        for (std::size_t i = 1; i < cuts.size(); ++i) {
            if (cuts[i] - cuts[i - 1] < cuts[closest] - cuts[closest - 1]) {
                closest = i;
            }
        }
        cuts.erase(cuts.begin() + static_cast<std::ptrdiff_t>(closest));
    }
}

} // namespace

std::vector<OrderedItem> order_back_to_front(std::span<const Sphere> volumes, std::span<const Sphere> objects,
                                             const Frustum& view, const SplitSettings& settings) {
    assert(settings.most_slices >= 1 && settings.interleave >= 1);
    const auto range = [&view](const Sphere& s) {
        DepthRange r = depth_range(s, view);
        r.near_m = std::max(r.near_m, 0.0);
        return r;
    };
    std::vector<OrderedItem> items;
    for (std::size_t v = 0; v < volumes.size(); ++v) {
        const DepthRange whole = range(volumes[v]);
        if (whole.far_m <= 0.0) {
            continue;
        }
        std::vector<double> cuts;
        for (const Sphere& object : objects) {
            const double depth = glm::dot(object.centre_m - view.eye_m, view.forward);
            if (touch(volumes[v], object) && depth > whole.near_m && depth < whole.far_m) {
                cuts.push_back(depth);
            }
        }
        thin_out(cuts, static_cast<std::size_t>(settings.most_slices - 1));
        const std::size_t for_objects = cuts.size();
        std::vector<double> between;
        for (std::size_t other = 0; other < volumes.size(); ++other) {
            if (other == v || !touch(volumes[v], volumes[other])) {
                continue;
            }
            // Common to both, so that the pieces of one lie wholly before or behind, or level with, those of the other.
            const DepthRange theirs = range(volumes[other]);
            const double near = std::max(whole.near_m, theirs.near_m);
            const double far = std::min(whole.far_m, theirs.far_m);
            for (int k = 0; k <= settings.interleave; ++k) {
                const double depth = near + (far - near) * k / settings.interleave;
                if (depth > whole.near_m && depth < whole.far_m) {
                    between.push_back(depth);
                }
            }
            // An object within the other must find this one cut as well.
            for (const Sphere& object : objects) {
                const double depth = glm::dot(object.centre_m - view.eye_m, view.forward);
                if (touch(volumes[other], object) && depth > near && depth < far) {
                    between.push_back(depth);
                }
            }
        }
        // Cuts for objects have precedence over those that interleave volumes.
        thin_out(between, static_cast<std::size_t>(settings.most_slices - 1) - for_objects);
        cuts.insert(cuts.end(), between.begin(), between.end());
        thin_out(cuts, static_cast<std::size_t>(settings.most_slices - 1));
        double near = whole.near_m;
        for (const double cut : cuts) {
            items.push_back({false, v, near, cut});
            near = cut;
        }
        items.push_back({false, v, near, whole.far_m});
    }
    for (std::size_t o = 0; o < objects.size(); ++o) {
        const DepthRange r = range(objects[o]);
        if (r.far_m > 0.0) {
            items.push_back({true, o, r.near_m, r.far_m});
        }
    }
    // Who is behind whom, where it matters; then take one after the other, the farthest of those with nothing behind
    // them.
    const auto sphere = [&](const OrderedItem& i) { return i.object ? objects[i.index] : volumes[i.index]; };
    const auto depth = [&](const OrderedItem& i) {
        return i.object ? glm::dot(objects[i.index].centre_m - view.eye_m, view.forward) : 0.5 * (i.near_m + i.far_m);
    };
    const auto behind = [&](const OrderedItem& a, const OrderedItem& b) { // a has to be drawn before b
        if (a.object == b.object && a.index == b.index) {
            return a.near_m > b.near_m;
        }
        const Sphere sa = sphere(a);
        const Sphere sb = sphere(b);
        if (!touch(sa, sb)) {
            return share_rays(sa, sb, view.eye_m) && power(sa, view.eye_m) > power(sb, view.eye_m);
        }
        // A piece against an object in its volume: the cut goes through the object's centre, which is what counts.
        if (a.object != b.object) {
            const OrderedItem& piece = a.object ? b : a;
            const double z = depth(a.object ? a : b);
            const bool piece_behind = piece.near_m >= z || (piece.far_m > z && depth(piece) > z);
            return piece_behind == !a.object;
        }
        if (a.near_m >= b.far_m || b.near_m >= a.far_m) {
            return a.near_m >= b.far_m;
        }
        return std::tuple(depth(a), a.index) > std::tuple(depth(b), b.index);
    };
    const std::size_t n = items.size();
    std::vector<std::vector<std::size_t>> in_front(n); // of each, the ones that wait for it
    std::vector<int> waits(n, 0);
    for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b < n; ++b) {
            if (a != b && behind(items[a], items[b])) {
                in_front[a].push_back(b);
                ++waits[b];
            }
        }
    }
    std::vector<OrderedItem> ordered;
    std::vector<bool> done(n, false);
    while (ordered.size() < n) {
        std::size_t next = n;
        bool free = false;
        for (std::size_t i = 0; i < n; ++i) { // without a free one (a ring of overlaps) the farthest has to do
            if (!done[i] && (next == n || (waits[i] == 0 && !free) ||
                             ((waits[i] == 0) == free && depth(items[i]) > depth(items[next])))) {
                next = i;
                free = waits[i] == 0;
            }
        }
        done[next] = true;
        ordered.push_back(items[next]);
        for (const std::size_t i : in_front[next]) {
            --waits[i];
        }
    }
    return ordered;
}

} // namespace alpenglow::impostors
