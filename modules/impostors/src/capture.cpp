#include <alpenglow/impostors/capture.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "keep.hpp"

namespace alpenglow::impostors {
namespace {

Result<Capture> take(const Sphere& bounds, const Frustum& view, std::span<const double> edges_m,
                     const CaptureSettings& settings, const Drawable& drawable, bool vectors) {
    if (view.width < 1 || view.height < 1) {
        return Error{"the picture is " + std::to_string(view.width) + " x " + std::to_string(view.height) + " texels",
                     "impostors::capture: view", "at least 1 x 1"};
    }
    if (edges_m.size() < 2 || !std::is_sorted(edges_m.begin(), edges_m.end()) || !std::isfinite(edges_m.front()) ||
        !std::isfinite(edges_m.back())) {
        return Error{std::to_string(edges_m.size()) + " slab borders, or not ascending", "impostors::capture: edges_m",
                     "at least two finite, ascending axis depths"};
    }
    CaptureRequest request;
    request.view = view;
    request.edges_m.assign(edges_m.begin(), edges_m.end());
    request.depth_origin_m = 0.5 * (edges_m.front() + edges_m.back());
    request.depth_scale_m = std::max(0.5 * (edges_m.back() - edges_m.front()), 1e-12 * std::abs(edges_m.back()));
    request.depth_scale_m = std::max(request.depth_scale_m, 1e-30);
    request.lights = settings.lights;

    const auto texels = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
    std::vector<SlabImage> slabs(edges_m.size() - 1);
    for (SlabImage& slab : slabs) {
        slab.colour.assign(texels, glm::vec4(0.0F));
        slab.depth.assign(texels, glm::vec2(0.0F));
    }
    if (Status drawn = drawable(request, slabs); !drawn) {
        return drawn.error();
    }
    Capture result;
    result.view = view;
    result.bounds = bounds;
    result.representation = settings.representation;
    result.open_edges = settings.open_edges;
    result.sharpened = settings.sharpen;
    result.depth_origin_m = request.depth_origin_m;
    result.depth_scale_m = request.depth_scale_m;
    result.lights = settings.lights;
    result.content = settings.content;
    for (std::size_t k = 0; k < slabs.size(); ++k) {
        const SlabImage& slab = slabs[k];
        if (slab.colour.size() != texels || slab.depth.size() != texels ||
            (!slab.fill.empty() && slab.fill.size() != texels)) {
            return Error{"slab " + std::to_string(k) + " came back with " + std::to_string(slab.colour.size()) +
                             " colours, " + std::to_string(slab.depth.size()) + " depths and " +
                             std::to_string(slab.fill.size()) + " fill colours",
                         "impostors::capture: drawable", std::to_string(texels) + " of each (fill may be empty)"};
        }
    }
    (vectors ? keep : keep_scalar)(result, edges_m, settings, slabs);
    return result;
}

int slab_count(const CaptureSettings& settings) {
    return single_picture(settings.representation) ? 1 : std::max(1, settings.layers);
}

} // namespace

std::vector<double> slab_edges(const Sphere& bounds, const Frustum& view, int slabs) {
    assert(slabs >= 1);
    const DepthRange range = depth_range(bounds, view);
    // Nothing behind the eye is seen; a viewer inside has slabs from where he stands.
    const double far = std::max(range.far_m, 1e-6);
    const double near = std::max(range.near_m, 1e-3 * far);
    std::vector<double> edges(static_cast<std::size_t>(slabs) + 1);
    const bool inverse = range.near_m > 0.02 * far;
    for (int k = 0; k <= slabs; ++k) {
        const double t = static_cast<double>(k) / slabs;
        edges[static_cast<std::size_t>(k)] = inverse ? near * far / (far + (near - far) * t) : near + (far - near) * t;
    }
    edges.front() = near;
    edges.back() = far;
    return edges;
}

Result<Capture> capture(const Sphere& bounds, const Frustum& view, const CaptureSettings& settings,
                        const Drawable& drawable) {
    return take(bounds, view, slab_edges(bounds, view, slab_count(settings)), settings, drawable, true);
}

Result<Capture> capture(const Sphere& bounds, const Frustum& view, std::span<const double> edges_m,
                        const CaptureSettings& settings, const Drawable& drawable) {
    return take(bounds, view, edges_m, settings, drawable, true);
}

Result<Capture> capture_scalar(const Sphere& bounds, const Frustum& view, const CaptureSettings& settings,
                               const Drawable& drawable) {
    return take(bounds, view, slab_edges(bounds, view, slab_count(settings)), settings, drawable, false);
}

LightGain light_gain(const Lights& captured, const Lights& now) {
    const auto factor = [](float before, float after) {
        return before > 0.0F && std::isfinite(after) && after >= 0.0F ? after / before : 1.0F;
    };
    LightGain gain;
    for (int c = 0; c < 3; ++c) {
        gain.key[c] = factor(captured.key[c], now.key[c]);
        gain.fill[c] = factor(captured.fill[c], now.fill[c]);
    }
    return gain;
}

} // namespace alpenglow::impostors
