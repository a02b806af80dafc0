#version 450
#extension GL_GOOGLE_include_directive : require
// The sun's disc, darker towards its limb: I / I_centre = 1 - 0.6 (1 - mu), the linear law in the middle of the spectrum.
#include "frame.glsl"
#include "tone.glsl"
#include "disc.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec2 place;
layout(location = 1) flat in float radius_px;
layout(location = 0) out vec4 target;

void main() {
    float mu = sqrt(max(1.0 - dot(place, place), 0.0));
    vec3 radiance = frame.sun_disc.rgb * (0.4 + 0.6 * mu) / 0.8; // mean 1 over the disc
    // Half floats end at 65504.
    target = vec4(hdr ? min(radiance, 6e4) : display(radiance), disc_coverage(place, radius_px));
}
