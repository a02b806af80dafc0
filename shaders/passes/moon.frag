#version 450
#extension GL_GOOGLE_include_directive : require
// The moon's disc: a Lambertian ball lit by the sun. It adds to the sky in front of it; its dark side is the sky.
#include "frame.glsl"
#include "tone.glsl"
#include "disc.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(location = 0) in vec2 place;
layout(location = 1) flat in float radius_px;
layout(location = 2) in float over_horizon_px;
layout(location = 0) out vec4 target;

void main() {
    vec3 towards = frame.to_moon.xyz;
    vec3 aside = abs(towards.z) < 0.999 ? vec3(0.0, 0.0, 1.0) : vec3(0.0, 1.0, 0.0);
    vec3 right = normalize(cross(towards, aside));
    vec3 up = cross(right, towards);
    float depth = sqrt(max(1.0 - dot(place, place), 0.0));
    vec3 normal = place.x * right + place.y * up - depth * towards;
    vec3 radiance = frame.moon_disc.rgb * max(dot(normal, frame.to_sun.xyz), 0.0) * disc_coverage(place, radius_px, over_horizon_px);
    target = vec4(hdr ? radiance : display(frame.moon_sky.rgb + radiance) - display(frame.moon_sky.rgb), 0.0);
}
