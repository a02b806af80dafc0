#version 450
#extension GL_GOOGLE_include_directive : require
// The clouds' picture, premultiplied, over what lies behind.
#include "dither.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(set = 1, binding = 0) uniform sampler2D picture;

layout(location = 0) in vec2 at;
layout(location = 0) out vec4 target;

void main() {
    vec4 cloud = texture(picture, at);
    target = hdr ? cloud : vec4(cloud.rgb + cloud.a * dither(), cloud.a);
}
