#version 450
#extension GL_GOOGLE_include_directive : require
// Surfaces whose vertices bring their own light, or symbols of a fixed colour.
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 light; // rgb: radiance in cd/m^2, or, where w is 1, as exposed
layout(location = 0) out vec3 color;

void main() {
    vec3 relative_m = position_m - frame.camera_m.xyz;
    gl_Position = frame.clip_from_relative * vec4(relative_m, 1.0);
    vec3 radiance = light.rgb * mix(frame.sun.w, 1.0, light.w);
    radiance = through_air(radiance, relative_m, 1.0);
    color = hdr ? radiance : display(radiance);
}
