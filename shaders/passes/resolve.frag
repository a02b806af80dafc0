#version 450
#extension GL_GOOGLE_include_directive : require
// The half-float frame to 8 bits.
#include "tone.glsl"
#include "dither.glsl"

layout(set = 0, binding = 0) uniform sampler2D scene;
layout(location = 0) out vec4 target;

void main() { target = vec4(display(texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb) + dither(), 1.0); }
