#version 450
#extension GL_GOOGLE_include_directive : require
// A rectangle around the sun (instance 0) or the moon (instance 1), infinitely far: a strip of four corners.
#include "frame.glsl"

layout(location = 0) out vec2 place; // on the disc, in radii: x right, y up as seen with the zenith up
layout(location = 1) flat out float radius_px;
layout(location = 2) out float over_horizon_px;

layout(push_constant) uniform Push { uint body; };

void main() {
    vec4 towards = body == 0u ? frame.to_sun : frame.to_moon;
    float flattening = body == 0u ? frame.discs.x : frame.discs.y;
    float margin = 1.0 + 1.0 / (frame.camera_m.w * towards.w); // a pixel for the soft edge
    place = margin * vec2((gl_VertexIndex & 1) * 2 - 1, (gl_VertexIndex >> 1) * 2 - 1);
    vec3 aside = abs(towards.z) < 0.999 ? vec3(0.0, 0.0, 1.0) : vec3(0.0, 1.0, 0.0);
    vec3 right = normalize(cross(towards.xyz, aside));
    vec3 up = cross(right, towards.xyz);
    vec3 direction = towards.xyz + tan(towards.w) * (place.x * right + flattening * place.y * up);
    gl_Position = frame.clip_from_relative * vec4(direction, 0.0);
    gl_Position.z = 0.0;
    radius_px = frame.camera_m.w * towards.w;
    over_horizon_px = frame.camera_m.w * (atan(direction.z, length(direction.xy)) - frame.discs.z);
}
