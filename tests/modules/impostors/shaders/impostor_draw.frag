#version 450
#extension GL_GOOGLE_include_directive : require
// One layer of a capture from another eye, by the library's resampler.
#include "alpenglow/impostor.glsl"

layout(push_constant) uniform Draw {
    vec4 eye;    // of the view, in the capture's axes
    vec4 window; // tan_left, tan_top; texels a tangent
    vec4 size;   // texels; origin and scale of s
    vec4 ray;    // of the first pixel, in the capture's axes, and its steps
    vec4 ray_x;
    vec4 ray_y;
    vec4 slab; // near, far, 1 / plane, steps of a search; 0: fixed point; -1: no warp
};
layout(set = 0, binding = 0) uniform sampler2D key;
layout(set = 0, binding = 1) uniform sampler2D fill;
layout(set = 0, binding = 2) uniform sampler2D warp;
layout(location = 0) out vec4 target;

void main() {
    vec2 pixel = gl_FragCoord.xy - 0.5;
    vec3 v = ray.xyz + pixel.x * ray_x.xyz + pixel.y * ray_y.xyz;
    ImpostorView view = ImpostorView(eye.xyz, window.xy, window.zw, size.xy, size.z, size.w);
    vec2 texel = 1.0 / size.xy;
    float w = slab.z;
    if (slab.w > 0.0) {
        w = impostor_search(view, warp, vec2(0.0), texel, v, int(slab.w), slab.x, slab.y);
    } else if (slab.w == 0.0) {
        w = impostor_warp(view, warp, vec2(0.0), texel, v, w, slab.x, slab.y);
    }
    vec2 epipole;
    vec2 t = impostor_texel(view, v, w, epipole);
    vec4 c = impostor_fetch(key, fill, size.xy, vec2(0.0), texel, t, vec3(1.5, 1.0, 0.5), vec3(0.5, 1.0, 2.0));
    target = impostor_ahead(view, v, w) ? c : vec4(0.0);
}
