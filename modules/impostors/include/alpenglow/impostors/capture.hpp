// The picture of an object: what a Drawable fills, and what is kept of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/core/result.hpp>
#include <alpenglow/impostors/geometry.hpp>

namespace alpenglow::impostors {

// The two lights that a picture keeps apart. Each has one colour; a picture holds radiance made by each, so that a
// change of either's colour, or of the exposure, is a factor at drawing (see light_gain) and needs no new capture.
struct Lights {
    glm::vec3 to_key{0.0F, 0.0F, 1.0F}; // unit vector towards sun or moon
    glm::vec3 key{1.0F};                // its illuminance
    glm::vec3 fill{1.0F};               // of the sky and all the rest
};

// One slab of a picture, as a Drawable leaves it: only the matter between two axis depths, as if nothing stood in
// front.
struct SlabImage {
    // Premultiplied radiance made by the key light, and alpha (1 - transmittance). Row 0 on top.
    std::vector<glm::vec4> colour;
    // Premultiplied radiance made by the fill light. Empty: `colour` holds everything and follows the key light.
    std::vector<glm::vec3> fill;
    // Alpha times the mean of s, and of s^2, over what the pixel sees, with s = (axis depth - origin) / scale of the
    // request: -1 .. 1 from the front to the back of the bounds.
    std::vector<glm::vec2> depth;
};

// What a Drawable is asked for.
struct CaptureRequest {
    Frustum view;
    std::vector<double> edges_m; // slab k lies between the axis depths edges_m[k] and edges_m[k + 1], front to back
    double depth_origin_m = 0.0;
    double depth_scale_m = 1.0;
    Lights lights;
};

// Fills one image a slab (sized, and zero, on entry). Any renderer will do: a march, a rasterizer, a read-back.
using Drawable = std::function<Status(const CaptureRequest&, std::span<SlabImage>)>;

enum class Representation {
    plane,         // one picture in the plane through the centre: Schaufler's and Harris's impostor
    layers,        // a picture for each slab, each in its own plane
    depth_warp,    // one picture, each texel at its own mean depth
    warped_layers, // a picture for each slab, each texel at its mean depth in the slab
};

// A picture at one resolution. Premultiplied throughout, so that bilinear filtering and box mips have no halos and keep
// coverage: the sum over texels of the area times what all layers show together is the same in every level. (Averages
// of single layers would let matter in front and behind, once lined up, stand side by side: too opaque by some
// percent.)
struct MipLevel {
    int width = 0;
    int height = 0;
    std::vector<glm::vec4> colour;
    std::vector<glm::vec4> fill;  // w unused; empty where the Drawable keeps no fill light apart
    std::vector<glm::vec2> depth; // as in SlabImage
};

struct Layer {
    double plane_m = 0.0; // axis depth of its plane
    double near_m = 0.0;  // what it holds lies between these axis depths
    double far_m = 0.0;
    std::vector<MipLevel> mips; // 0 is full resolution; level n + 1 has half the size of n, rounded up
    std::vector<float> warp;    // s for each texel of level 0, continued smoothly where nothing is; warped kinds only
    std::vector<std::uint8_t>
        occupied; // by blocks of 8 x 8 texels of level 0: whether they or their neighbours hold anything
};

// How a capture's image answers to motion of the eye: see predicted_error in error.hpp.
struct Sensitivity {
    // Squared relative RMSE for a translation t of the eye, in units of metres^-2: t^T M t in the capture's axes
    // (right, up, forward), for radiance and for alpha. The worse of the two counts.
    glm::dmat3 radiance{0.0};
    glm::dmat3 alpha{0.0};
    double resample = 0.0; // relative RMSE of bilinear filtering at a random phase
};

struct Capture {
    Frustum view;
    Sphere bounds;
    Representation representation = Representation::plane;
    bool open_edges = false;
    bool sharpened = false;
    double depth_origin_m = 0.0;
    double depth_scale_m = 1.0;
    std::vector<Layer> layers; // front to back
    Lights lights;
    double content = 0.0; // the object's content clock at capture: see content_error
    Sensitivity sensitivity;
    glm::vec4 mean{0.0F};            // mean premultiplied colour over the tile, for a stand-in once the picture is gone
    std::size_t rejected_texels = 0; // texels that were not finite, or negative: made transparent, or clamped

    [[nodiscard]] std::size_t texels() const {
        return static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height) * layers.size();
    }
};

// What the scheduler, or a game, asks to be captured.
struct CaptureSettings {
    Representation representation = Representation::warped_layers;
    int layers = 8; // 4 .. 16; the single-picture kinds take one
    Lights lights;
    double content = 0.0;
    // The picture goes on beyond its window, as a screen-aligned one does: its last texels are held to the rim, where a
    // tight window would fade into transparency.
    bool open_edges = false;
    // Bilinear filtering at a random phase takes 1/12 of the second difference off the picture on average. Adding it
    // beforehand (and staying within the range of the neighbours, so that nothing rings) leaves 2/5 of the error: for
    // GPUs as for draw(). Off, a picture is exact where its texels are hit.
    bool sharpen = true;
    // Warped kinds: > 0 lets the surface bend only at every so many texels (bilinear between), as a mesh of such cells
    // that a GPU draws for one fetch a pixel does. What a picture is off by is measured against that surface.
    int warp_cell = 0;
    // Off: level 0 alone, for a renderer that makes its own mips or shows pictures near the size that they were taken.
    bool mips = true;
};

// Slab borders for a capture: n slabs of equal thickness in inverse depth where the near side is well in front of the
// eye (parallax is linear in inverse depth, so that each slab carries the same error), of equal thickness otherwise.
[[nodiscard]] std::vector<double> slab_edges(const Sphere& bounds, const Frustum& view, int slabs);

// Draws and keeps a picture. Fails with the Drawable's own error, or where it resized an image. Not-finite texels are
// made transparent and counted: a NaN never leaves here.
[[nodiscard]] Result<Capture> capture(const Sphere& bounds, const Frustum& view, const CaptureSettings& settings,
                                      const Drawable& drawable);

// The same with slab borders given (ascending, at least two), for splitting around objects (003, section 3.2).
[[nodiscard]] Result<Capture> capture(const Sphere& bounds, const Frustum& view, std::span<const double> edges_m,
                                      const CaptureSettings& settings, const Drawable& drawable);

// The first in plain code and double, texel by texel: what a test holds capture() to.
[[nodiscard]] Result<Capture> capture_scalar(const Sphere& bounds, const Frustum& view, const CaptureSettings& settings,
                                             const Drawable& drawable);

// Factors on key and fill radiance of a picture taken under `captured`, now that the lights are `now`. A channel that
// was dark at capture stays dark (light_error says that the picture does not hold).
struct LightGain {
    glm::vec3 key{1.0F};
    glm::vec3 fill{1.0F};
};
[[nodiscard]] LightGain light_gain(const Lights& captured, const Lights& now);

} // namespace alpenglow::impostors
