#version 450
#extension GL_GOOGLE_include_directive : require
// Terrain and objects lit per pixel, into a half-float target.
#include "frame.glsl"
#include "light.glsl"
#include "terrain_grid.glsl"

layout(constant_id = 0) const bool instanced = false; // objects; terrain reads its grid's image

layout(set = 0, binding = 1) uniform sampler2DShadow shadow_map;
layout(set = 1, binding = 0) uniform sampler2D grid_image;
layout(set = 2, binding = 0) uniform sampler2D detail_image;

layout(location = 0) in vec3 relative_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 albedo;
layout(location = 3) in vec4 place;
layout(location = 0) out vec4 target;

// Fraction of the key light that objects let through: the mean of 16 bilinear compares, 4 texels across.
float shadow(vec3 at_m, vec3 n) {
    // Off the surface by the width of the filter, as far as the surface leans away from the light, so that it does not
    // shade itself. Rows of the matrix give the width of a texel.
    float cosine = dot(n, frame.key.xyz);
    vec3 across = vec3(frame.shadow_from_relative[0].x, frame.shadow_from_relative[1].x, frame.shadow_from_relative[2].x);
    float texel_m = 2.0 / (length(across) * float(textureSize(shadow_map, 0).x));
    float off_m = texel_m * (0.5 + 3.0 * sqrt(max(1.0 - cosine * cosine, 0.0)));
    vec4 clip = frame.shadow_from_relative * vec4(at_m + off_m * n, 1.0);
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

// Three sizes of the detail's tile; each fades out where it would be finer than a pixel, by its mip levels.
vec3 detail_at(vec2 world_m) {
    return texture(detail_image, world_m / 6.0).rgb + texture(detail_image, world_m / 60.0).rgb +
           texture(detail_image, world_m / 700.0).rgb - 1.0;
}

void main() {
    vec3 n = normalize(normal);
    vec3 reflectance = albedo.rgb;
    float ambient = albedo.a;
    if (!instanced) {
        Ground g = ground_from_texel(texture(grid_image, place.xy));
        vec3 tint = ground_tint(chroma_of(albedo.rgb), dot(albedo.rgb, luminance_weights), g.luminance);
        g = with_detail(g, detail_at(relative_m.xy + frame.camera_m.xy));
        n = g.normal;
        reflectance = tint * g.luminance;
        ambient = g.ambient;
    }
    float through = shadow(relative_m, n);
    vec2 visible = place.zw * cloud_visibility(relative_m) * (frame.key.w > 0.5 ? vec2(1.0, through) : vec2(through, 1.0));
    vec3 light = direct_irradiance(n, visible.x, visible.y) + ambient * sky_irradiance(n);
    target = vec4(through_air(reflectance * light, relative_m, sky_light_visibility(place.z, place.w)), 1.0);
}
