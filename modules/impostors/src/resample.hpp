// The vectorised inner loop of draw(): one row of pixels, all layers.
#pragma once

#include <cstdint>

namespace alpenglow::impostors {

// Linear along the row: value at the first pixel, and its step.
struct Ramp {
    float first = 0.0F, step = 0.0F;
};

// A pixel's ray sees, at inverse depth w, the texel ((u + w eu) / vz, (v + w ev) / vz) of level 0.
struct ResampleRow {
    Ramp u, v, eu, ev, vz;
    int pixels = 0;
};

struct ResampleMip {
    const float* colour = nullptr; // RGBA
    const float* fill = nullptr;   // RGB and one unused; null: none
    int width = 0, height = 0;
    float scale = 1.0F;   // of level 0's texels
    float weight = 1.0F;  // of two mips
    float cubic_b = 0.0F; // of the cubic filter: see cubic_weights in reproject.cpp
};

struct ResampleLayer {
    ResampleMip mips[2];
    int mip_count = 1;
    int width = 0, height = 0; // level 0
    float w_plane = 0.0F, spread = 0.0F;
    int search = 0;              // steps of first_crossing in reproject.cpp; 0: fixed point
    const float* warp = nullptr; // null: a plane
    float near_m = 0.0F, far_m = 0.0F;
    const std::uint8_t* occupied = nullptr;
    int blocks_across = 0;
    bool skip_by_blocks = false; // level 0 is read
};

struct ResampleInput {
    const ResampleLayer* layers = nullptr; // from front to back as the view sees them
    int layer_count = 0;
    float eye_z = 0.0F; // of the view, in the capture's axes
    float depth_origin_m = 0.0F, depth_scale_m = 1.0F;
    float key[3] = {1.0F, 1.0F, 1.0F};
    float fill[3] = {1.0F, 1.0F, 1.0F};
    bool open_edges = false;
    bool cubic = false; // else bilinear
    float weight = 1.0F;
};

// Adds to `rgba`, premultiplied, row.pixels x 4.
void resample_row(const ResampleInput& input, const ResampleRow& row, float* rgba);

} // namespace alpenglow::impostors
