#version 450
#extension GL_GOOGLE_include_directive : require
// A premultiplied colour.
#include "dither.glsl"

layout(location = 0) in vec4 color;
layout(location = 0) out vec4 target;

void main() { target = vec4(color.rgb + dither() * color.a, color.a); }
