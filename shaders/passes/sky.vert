#version 450
#extension GL_GOOGLE_include_directive : require
// The sky dome, infinitely far.
#include "frame.glsl"
#include "tone.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec3 direction;
layout(location = 1) in vec3 radiance_cd_m2;
layout(location = 0) out vec3 color;

void main() {
    gl_Position = frame.clip_from_relative * vec4(direction, 0.0);
    gl_Position.z = 0.0;
    vec3 radiance = radiance_cd_m2 * frame.sun.w;
    color = hdr ? radiance : display(radiance);
}
