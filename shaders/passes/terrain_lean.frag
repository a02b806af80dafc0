#version 450
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "terrain_grid.glsl"
#include "tone.glsl"
#include "dither.glsl"

layout(constant_id = 1) const bool two_tiles = true; // false: the coarser alone

layout(set = 1, binding = 0) uniform sampler2D grid_image;
layout(set = 2, binding = 0) uniform sampler2D detail_image;

layout(push_constant) uniform Push {
    layout(offset = 16) vec2 tiles; // as the vertex shader has it
};

layout(location = 0) in vec2 place;
layout(location = 1) in vec3 key_light;
layout(location = 2) in vec3 sky_light;
layout(location = 3) in vec3 air;
layout(location = 4) in vec4 detail_place;
layout(location = 0) out vec4 target;

void main() {
    vec3 detail = texture(detail_image, detail_place.xy, -1.0).rgb;
    if (two_tiles) {
        float depth_m = 1.0 / gl_FragCoord.w;
        float fine = 1.0 - smoothstep(3.0, 5.5, depth_m / tiles.x);
        detail += fine * (texture(detail_image, detail_place.zw, -1.0).rgb - 0.5);
    }
    Ground g = with_detail(ground_from_texel(texture(grid_image, place, -0.5)), detail);
    vec3 light = key_light * max(dot(g.normal, frame.key.xyz), 0.0) + sky_light * g.ambient;
    target = vec4(display(g.luminance * light + air) + dither(), 1.0);
}
