#version 450
#extension GL_GOOGLE_include_directive : require
// One cloud through a pinhole: premultiplied radiance and alpha, or the mean distance of what is seen.

layout(constant_id = 0) const bool show_distance = false;
layout(set = 0, binding = 0) readonly buffer Volume { uint volume_words[]; };
layout(set = 0, binding = 1) readonly buffer Light { uint light_words[]; };
layout(set = 0, binding = 2) readonly buffer Camera {
    vec4 eye;     // voxels from the volume's corner; w: pixels per unit of tangent
    vec4 forward; // the grid's frame
    vec4 right;
    vec4 up;
    vec4 voxel_m;
    vec4 size; // pixels
};
layout(set = 0, binding = 3) readonly buffer View { uint view_words[]; };
layout(set = 0, binding = 4) readonly buffer Detail { uint detail_words[]; };

uint cloud_volume_word(uint index) { return volume_words[index]; }
uint cloud_light_word(uint index) { return light_words[index]; }
uint cloud_view_word(uint index) { return view_words[index]; }
uint cloud_detail_word(uint index) { return detail_words[index]; }
#include "alpenglow/cloud.glsl"

layout(location = 0) out vec4 target;

void main() {
    vec2 at = (gl_FragCoord.xy - 0.5 * size.xy) / eye.w;
    vec3 direction = normalize(forward.xyz + at.x * right.xyz - at.y * up.xyz);
    AlpenglowCloudRay ray = alpenglow_cloud_march(eye.xyz, direction, direction / voxel_m.xyz, 1e30);
    target = show_distance ? vec4(ray.depth) : vec4(ray.radiance, 1.0 - ray.transmittance);
}
