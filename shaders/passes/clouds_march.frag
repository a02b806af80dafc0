#version 450
#extension GL_GOOGLE_include_directive : require
// All clouds in view through a pinhole: radiance, and packed into the last word what they hide and at which distance.

layout(set = 0, binding = 1) readonly buffer Tables { uint table_words[]; };
#include "clouds_picture.glsl"

uint detail_base;
uint volume_base;
uint light_base;
uint view_base;
uint cloud_detail_word(uint index) { return table_words[detail_base + index]; }
uint cloud_volume_word(uint index) { return table_words[volume_base + index]; }
uint cloud_light_word(uint index) { return table_words[light_base + index]; }
uint cloud_view_word(uint index) { return table_words[view_base + index]; }
#include "alpenglow/cloud.glsl"

layout(location = 0) out uvec4 target;

vec3 corner(uint base, uint word) {
    return vec3(uintBitsToFloat(table_words[base + word]), uintBitsToFloat(table_words[base + word + 1u]),
                uintBitsToFloat(table_words[base + word + 2u]));
}

// Distance at which the ray through `at` enters the box of a cloud's matter; negative: nowhere.
float entry(CloudPlace place, vec3 per_metre) {
    vec3 held = mix(per_metre, vec3(1e-12), lessThan(abs(per_metre), vec3(1e-12)));
    vec3 u = (corner(place.tables.x, 9u) - place.eye.xyz) / held;
    vec3 v = (corner(place.tables.x, 12u) - place.eye.xyz) / held;
    vec3 low = min(u, v);
    vec3 high = max(u, v);
    float enter = max(max(low.x, max(low.y, low.z)), 0.0);
    return enter < min(high.x, min(high.y, high.z)) ? enter : -1.0;
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float landscape = landscape_m[texel.y * size.x + texel.x];
    vec2 at = place_of(gl_FragCoord.xy);
    detail_base = counts.y;
    vec3 radiance = vec3(0.0);
    float transmittance = 1.0;
    float depth = 0.0;
    float weight = 0.0;
    // From near to far: each time the nearest box beyond the last. Boxes of a layer do not overlap.
    float last = -1.0;
    int last_cloud = -1;
    for (int turn = 0; turn < counts.x; ++turn) {
        float nearest = landscape;
        int chosen = -1;
        for (int i = 0; i < counts.x; ++i) {
            CloudPlace place = places[i];
            float enter = entry(place, normalize(place.forward.xyz + at.x * place.right.xyz + at.y * place.up.xyz) / place.voxel_m.xyz);
            if (enter >= 0.0 && enter < nearest && (enter > last || (enter == last && i > last_cloud))) {
                nearest = enter;
                chosen = i;
            }
        }
        if (chosen < 0) {
            break;
        }
        last = nearest;
        last_cloud = chosen;
        CloudPlace place = places[chosen];
        volume_base = place.tables.x;
        light_base = place.tables.y;
        view_base = place.tables.z;
        vec3 direction = normalize(place.forward.xyz + at.x * place.right.xyz + at.y * place.up.xyz);
        AlpenglowCloudRay ray = alpenglow_cloud_march(place.eye.xyz, direction, direction / place.voxel_m.xyz, landscape);
        float opacity = transmittance * (1.0 - ray.transmittance);
        radiance += transmittance * ray.radiance;
        depth += opacity * ray.depth;
        weight += opacity;
        transmittance *= ray.transmittance;
        if (transmittance <= 0.0) {
            break;
        }
    }
    target = uvec4(floatBitsToUint(radiance), pack_cloud(1.0 - transmittance, depth / max(weight, 1e-20)));
}
