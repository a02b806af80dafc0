#version 450
#extension GL_GOOGLE_include_directive : require
// An interpolated display colour, dithered.
#include "dither.glsl"

layout(location = 0) in vec3 color;
layout(location = 0) out vec4 target;

void main() { target = vec4(color + dither(), 1.0); }
