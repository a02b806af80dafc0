// The vectorised passes over texels that capture() is made of. Images are rows of RGBA or of depth moments, as in
// MipLevel; ranges of x start at a multiple of 8.
#pragma once

#include <cstddef>
#include <cstdint>

namespace alpenglow::impostors {

// Where a layer holds anything, in texels; everything outside is zero.
struct TexelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
};

// One row as a Drawable left it.
struct RowIn {
    const float* colour = nullptr;    // RGBA
    const float* fill = nullptr;      // RGB; null: none
    float* depth = nullptr;           // two moments: held to what alpha allows
    float* fill_out = nullptr;        // RGBA with a zero, written
    float* alpha = nullptr;           // planes of alpha and of the first moment, written; null: not wanted
    float* depth_1 = nullptr;         //
    std::uint8_t* occupied = nullptr; // by 8 texels: set where there is anything
    int count = 0;
};
struct RowSums {
    double colour[4] = {}; // with fill
    double depth_1 = 0.0;
    float most = 0.0F; // of radiance
};
// False, and nothing done, where a texel is not finite or not physical.
bool read_row(const RowIn& row, RowSums& sums);

// Averages of 2 x 2 within `box` of `from`; beyond an odd border lies zero. `channels` is 1, 2 or 4.
void halve(const float* from, int from_stride, int width, int height, const TexelRect& box, int channels, float* to,
           int to_stride);

// One level of the push: the map of the next coarser level between its texels, and what is there where alpha says so.
struct Push {
    const float* coarse = nullptr;
    int coarse_width = 0, coarse_height = 0;
    const float* alpha = nullptr;
    const float* depth_1 = nullptr;
    int width = 0, height = 0;
    float* map = nullptr;
    float* scratch = nullptr; // 2 x (width + 32)
};
void push(const Push& level);

// A layer's part of the composite, of the sensitivity, and its sharpening, in one pass over its rows.
struct LayerPass {
    int width = 0, height = 0;
    TexelRect box;
    float* colour = nullptr;
    float* fill = nullptr;
    float* depth = nullptr;
    const float* warp = nullptr;
    float* whole = nullptr;      // what the layers in front show together, RGBA: this one is added
    float* whole_fill = nullptr; //
    int whole_stride = 0;        // in texels; rows may be read and written 8 texels past their end
    bool sharpen = false, open_edges = false;
    float radiance_scale = 1.0F; // brings radiance to about 1
    // Axis depth over a reference: origin + scale x s; what it is clamped to, and where the layer's plane is.
    float origin = 1.0F, scale = 0.0F;
    float s_floor = 0.0F, s_near = 0.0F, s_far = 0.0F, s_plane = 0.0F;
    // Tangents at a texel's centre: left + x step, top + y step.
    float left = 0.0F, step_x = 0.0F, top = 0.0F, step_y = 0.0F;
    float aspect = 1.0F;      // texels per tangent, vertically over horizontally
    float* scratch = nullptr; // layer_scratch(width) floats
};
[[nodiscard]] std::size_t layer_scratch(int width);
// Adds xx, xy, yy, xz, yz, zz of radiance's matrix, then of alpha's, in units of what the caller scaled.
void layer_pass(const LayerPass& pass, double sums[12]);

// Sums of squares of the whole and of its second differences: of radiance x scale, and of alpha. A border of one texel
// around the box can be read.
struct Curvature {
    double energy = 0.0, energy_alpha = 0.0, curvature = 0.0, curvature_alpha = 0.0;
};
Curvature curvature(const float* whole, const float* whole_fill, int stride, const TexelRect& box,
                    float radiance_scale);

// Scales optical depths and radiances of one mip of all layers to what they should show together.
struct MatchMips {
    struct One {
        float* colour = nullptr;
        float* fill = nullptr;
        float* depth = nullptr;
    };
    const One* layers = nullptr; // front to back
    int count = 0;
    const float* target = nullptr;      // RGBA
    const float* target_fill = nullptr; // null: none
    std::size_t first = 0, last = 0;    // texels
};
void match_mips(const MatchMips& level);

// A warp map's nodes: for one row of nodes, tent-weighted sums down the columns of the rows around it.
void add_node_row(const float* map, const float* colour, float weight, int width, float* sum, float* weights);

} // namespace alpenglow::impostors
