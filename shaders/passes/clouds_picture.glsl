// What the passes that make the clouds' picture on the device share.

struct CloudPlace {
    vec4 eye;     // voxels from the volume's corner
    vec4 forward; // of the camera, the grid's frame
    vec4 right;
    vec4 up;
    vec4 voxel_m;
    uvec4 tables; // first words of volume, light and view
};

layout(set = 0, binding = 2, std430) readonly buffer Picture {
    ivec4 counts;     // clouds, first word of the detail
    ivec2 size;       // of the picture, texels
    vec2 half_angles; // their tangents
    vec4 forward;     // the camera in the world
    vec4 right;
    vec4 up;
    CloudPlace places[];
};
layout(set = 0, binding = 3) readonly buffer Landscape { float landscape_m[]; }; // distances; 1e30: none

// Of a point of the picture, on the plane at unit distance.
vec2 place_of(vec2 texel) { return (2.0 * texel / vec2(size) - 1.0) * half_angles * vec2(1.0, -1.0); }

const float farthest_m = 160000.0;
uint pack_cloud(float alpha, float distance_m) {
    return packUnorm2x16(vec2(alpha, sqrt(min(distance_m / farthest_m, 1.0))));
}
