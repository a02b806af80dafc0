#version 450
#extension GL_GOOGLE_include_directive : require
// Smoke that the CPU has marched through: radiance and cover by vertex.
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 smoke; // premultiplied radiance in cd/m^2, cover
layout(location = 0) out vec4 color;

void main() {
    vec3 relative_m = position_m - frame.camera_m.xyz;
    gl_Position = frame.clip_from_relative * vec4(relative_m, 1.0);
    vec3 radiance = through_air(smoke.rgb / max(smoke.a, 1e-4) * frame.sun.w, relative_m, 1.0);
    color = vec4((hdr ? radiance : display(radiance)) * smoke.a, smoke.a);
}
