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
    vec4 grid;   // image coordinates = grid.x * position + grid.yz
    vec2 tiles;  // sides of the two sizes of the detail's tile, metres, the finer first
    vec2 levels; // mip levels of the grid's image and of the coarser detail: one for the run of triangles, which costs
                 // less than finding them for each pixel
};

layout(location = 0) in vec2 ground_m;
layout(location = 1) in vec3 key_light;
layout(location = 2) in vec3 sky_light;
layout(location = 3) in vec3 air;
layout(location = 4) in vec4 albedo;
layout(location = 0) out vec4 target;

void main() {
    vec3 detail = textureLod(detail_image, ground_m / tiles.y, levels.y).rgb;
    if (two_tiles) {
        float depth_m = 1.0 / gl_FragCoord.w;
        float fine = 1.0 - smoothstep(3.0, 5.5, depth_m / tiles.x);
        detail += fine * (texture(detail_image, ground_m / tiles.x, -1.0).rgb - 0.5);
    }
    Ground g = ground_from_texel(textureLod(grid_image, grid.x * ground_m + grid.yz, levels.x));
    vec3 tint = ground_tint(albedo.rgb, albedo.a, g.luminance);
    g = with_detail(g, detail);
    vec3 light = tint * (key_light * max(dot(g.normal, frame.key.xyz), 0.0) + sky_light * g.ambient);
    target = vec4(display(g.luminance * light + air) + dither(), 1.0);
}
