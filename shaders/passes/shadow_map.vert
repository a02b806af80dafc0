#version 450
#extension GL_GOOGLE_include_directive : require
// Depth of objects as the key light sees them.
#include "frame.glsl"

layout(location = 0) in vec3 position_m;
layout(location = 4) in vec4 world_row_x;
layout(location = 5) in vec4 world_row_y;
layout(location = 6) in vec4 world_row_z;

void main() {
    vec4 p = vec4(position_m, 1.0);
    vec3 relative = vec3(dot(world_row_x, p), dot(world_row_y, p), dot(world_row_z, p)) - frame.camera_m.xyz;
    gl_Position = frame.shadow_from_relative * vec4(relative, 1.0);
}
