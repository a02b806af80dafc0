#version 450
#extension GL_GOOGLE_include_directive : require
// Balls that each bring the light of their place: radiance by normal on SH of order 3.
#include "alpenglow/sh.glsl"
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec3 normal;   // of the unit sphere, and its vertices
layout(location = 1) in vec4 ball;     // centre, radius
layout(location = 2) in vec4 lines[7]; // nine RGB coefficients as they lie in memory
layout(location = 0) out vec3 color;

void main() {
    vec3 relative_m = ball.xyz + ball.w * normal - frame.camera_m.xyz;
    gl_Position = frame.clip_from_relative * vec4(relative_m, 1.0);
    vec3 c[9] = vec3[9](ALPENGLOW_SH_RGB(lines, 0), ALPENGLOW_SH_RGB(lines, 1), ALPENGLOW_SH_RGB(lines, 2),
                        ALPENGLOW_SH_RGB(lines, 3), ALPENGLOW_SH_RGB(lines, 4), ALPENGLOW_SH_RGB(lines, 5),
                        ALPENGLOW_SH_RGB(lines, 6), ALPENGLOW_SH_RGB(lines, 7), ALPENGLOW_SH_RGB(lines, 8));
    vec3 radiance = max(alpenglow_sh_evaluate3(c, normal), 0.0) * frame.sun.w;
    radiance = through_air(radiance, relative_m, 1.0);
    color = hdr ? radiance : display(radiance);
}
