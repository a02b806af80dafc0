#version 450
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "terrain_grid.glsl"
#include "tone.glsl"
#include "dither.glsl"

layout(set = 1, binding = 0) uniform sampler2D grid_image;

layout(location = 0) in vec2 place;
layout(location = 1) in vec3 key_light;
layout(location = 2) in vec3 sky_light;
layout(location = 3) in vec3 air;
layout(location = 0) out vec4 target;

void main() {
    Ground g = ground_from_texel(texture(grid_image, place, -0.5));
    vec3 light = key_light * max(dot(g.normal, frame.key.xyz), 0.0) + sky_light * g.ambient;
    target = vec4(display(g.luminance * light + air) + dither(), 1.0);
}
