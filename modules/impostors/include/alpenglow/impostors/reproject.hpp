// Drawing a picture from another place, on the CPU: every representation.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include <glm/vec4.hpp>

#include <alpenglow/impostors/capture.hpp>

namespace alpenglow::impostors {

enum class Filter {
    bilinear, // what a GPU has
    cubic,    // 16 taps: sharper, above all where the picture is enlarged
};

struct DrawSettings {
    LightGain gain;
    float weight = 1.0F; // opacity of the whole, for cross-fades: pictures whose weights sum to 1 are added
    Filter filter = Filter::bilinear;
    // Only what lies between these axis depths of the view (a part of a layer counts by its share of optical depth):
    // the slices between which other translucent things are drawn.
    double near_m = 0.0;
    double far_m = std::numeric_limits<double>::infinity();
    // Axis depth of opaque geometry for each pixel of the view; empty: none. A layer that straddles it shows the part
    // in front, so that solids dip into clouds softly.
    std::span<const float> scene_depth_m = {};
    unsigned threads = 0;
};

// Adds weight x the impostor's premultiplied radiance and alpha to `image` (view.width x view.height), which starts at
// zero. Returns the pixels touched. The result goes over what is behind it: image + (1 - image.a) x background.
std::size_t draw(const Capture& capture, const Frustum& view, const DrawSettings& settings, std::span<glm::vec4> image);

// The same pixel by pixel in double and plain code: what a test holds draw() to, which is vectorised over pixels where
// nothing cuts the picture.
std::size_t draw_scalar(const Capture& capture, const Frustum& view, const DrawSettings& settings,
                        std::span<glm::vec4> image);

// Composites premultiplied `front` over `back`, in place.
void over(std::span<const glm::vec4> front, std::span<glm::vec4> back);

// The share of a layer's optical depth that lies in front of s, given alpha times the mean of s and of s^2: matter is
// taken as spread evenly over mean +- sqrt(3) standard deviations.
[[nodiscard]] float share_in_front(float alpha, float depth_1, float depth_2, float s);

} // namespace alpenglow::impostors
