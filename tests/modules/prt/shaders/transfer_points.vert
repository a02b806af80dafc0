// Draws every point of a table as one pixel, its radiance as colour.
#version 450
#extension GL_GOOGLE_include_directive : require

layout(constant_id = 0) const uint side = 16;

layout(set = 0, binding = 0, std430) readonly buffer Words { uint words[]; };
layout(set = 0, binding = 1, std430) readonly buffer Light { vec4 light[]; };
layout(location = 0) out vec3 radiance;

uint transfer_word(uint index) { return words[index]; }
vec3 transfer_light(uint i) { return light[i].rgb; }

#define ALPENGLOW_TRANSFER_ENCODING 1
#include "alpenglow/transfer.glsl"

void main() {
    uint point = uint(gl_VertexIndex);
    radiance = alpenglow_transfer(point, 3u, 25u, 25u);
    vec2 pixel = vec2(float(point % side), float(point / side)) + 0.5;
    gl_Position = vec4(2.0 * pixel / float(side) - 1.0, 0.5, 1.0);
    gl_PointSize = 1.0;
}
