#version 450
#extension GL_GOOGLE_include_directive : require
// Terrain and objects lit per pixel, into a half-float target.
#include "frame.glsl"
#include "light.glsl"
#include "terrain_grid.glsl"

layout(constant_id = 0) const bool instanced = false; // objects; terrain reads its grid's image

layout(set = 0, binding = 1) uniform sampler2DShadow shadow_map;
layout(set = 1, binding = 0) uniform sampler2D grid_image;

layout(location = 0) in vec3 relative_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 albedo;
layout(location = 3) in vec4 place;
layout(location = 0) out vec4 target;

// Fraction of the key light that objects let through: 16 compares over a penumbra's width (4 x 4 bilinear taps).
float shadow(vec3 at_m, vec3 n) {
    // Off the surface by about a texel, so that it does not shade itself.
    vec4 clip = frame.shadow_from_relative * vec4(at_m + 0.25 * n, 1.0);
    vec2 uv = 0.5 * clip.xy + 0.5;
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) {
        return 1.0;
    }
    vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
    float sum = 0.0;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            sum += texture(shadow_map, vec3(uv + (vec2(x, y) - 1.5) * texel, clip.z));
        }
    }
    return sum / 16.0;
}

// Value noise, 0 .. 1, for the ground's grain.
float hash(ivec2 p) {
    uint h = uint(p.x) * 0x9E3779B1u + uint(p.y) * 0x85EBCA77u;
    h = (h ^ (h >> 15u)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12u)) * 0x297A2D39u;
    return float((h ^ (h >> 15u)) >> 8u) / 16777216.0;
}

float value_noise(vec2 p) {
    ivec2 cell = ivec2(floor(p));
    vec2 f = fract(p);
    f = f * f * (3.0 - 2.0 * f);
    return mix(mix(hash(cell), hash(cell + ivec2(1, 0)), f.x), mix(hash(cell + ivec2(0, 1)), hash(cell + ivec2(1, 1)), f.x),
               f.y);
}

// Octaves of grain, each faded out where it would be finer than a pixel. Mean 1.
float grain(vec2 world_m, float pixel_m) {
    float sum = 0.0;
    float size_m = 6.0;
    for (int octave = 0; octave < 5; ++octave) {
        sum += (value_noise(world_m / size_m) - 0.5) * clamp(size_m / pixel_m - 1.0, 0.0, 1.0);
        size_m *= 0.41;
    }
    return 1.0 + 0.35 * sum;
}

void main() {
    vec3 n = normalize(normal);
    vec3 reflectance = albedo.rgb;
    float ambient = albedo.a;
    if (!instanced) {
        Ground g = ground_from_texel(texture(grid_image, place.xy));
        n = g.normal;
        float pixel_m = 1.5 * length(relative_m) / frame.camera_m.w;
        reflectance = chroma_of(albedo.rgb) * g.luminance * grain(relative_m.xy + frame.camera_m.xy, pixel_m);
        ambient = g.ambient;
    }
    float through = shadow(relative_m, n);
    vec2 visible = place.zw * (frame.key.w > 0.5 ? vec2(1.0, through) : vec2(through, 1.0));
    vec3 light = direct_irradiance(n, visible.x, visible.y) + ambient * sky_irradiance(n);
    target = vec4(through_air(reflectance * light, relative_m), 1.0);
}
