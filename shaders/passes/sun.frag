#version 450
#extension GL_GOOGLE_include_directive : require
// The sun's disc, darker and redder towards its limb: mu^a, a = -0.023 + 0.292 um / wavelength (Hestroffer and Magnan
// 1998) at 630, 550 and 450 nm; its mean over the disc is 1 / (1 + a / 2).
#include "frame.glsl"
#include "tone.glsl"
#include "disc.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec2 place;
layout(location = 1) flat in float radius_px;
layout(location = 2) in float over_horizon_px;
layout(location = 0) out vec4 target;

void main() {
    float mu = sqrt(max(1.0 - dot(place, place), 0.0));
    const vec3 a = vec3(0.4405, 0.5079, 0.6259);
    vec3 radiance = frame.sun_disc.rgb * (1.0 + 0.5 * a) * pow(vec3(max(mu, 1e-3)), a);
    // Half floats end at 65504.
    target = vec4(hdr ? min(radiance, 6e4) : display(radiance), disc_coverage(place, radius_px, over_horizon_px));
}
