#version 450
#extension GL_GOOGLE_include_directive : require
// Bodies whose radiance the CPU has evaluated at each vertex.
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"
#include "transfer_place.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec3 position_m;
layout(location = 3) in vec3 light; // radiance, cd/m^2
layout(location = 0) out vec3 color;

void main() {
    vec3 relative_m = relative_to_camera(position_m);
    gl_Position = frame.clip_from_relative * vec4(relative_m, 1.0);
    vec3 radiance = through_air(light * frame.sun.w, relative_m, 1.0);
    color = hdr ? radiance : display(radiance);
}
