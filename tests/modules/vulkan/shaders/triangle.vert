#version 450
#extension GL_GOOGLE_include_directive : require
#include "corners.glsl"

void main() { gl_Position = vec4(corner(gl_VertexIndex), 0.5, 1.0); }
