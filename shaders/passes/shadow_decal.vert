#version 450
#extension GL_GOOGLE_include_directive : require
// Shadows of objects, draped over the ground and multiplied into what is drawn already. The factor is the loss of
// sunlight on level ground, as the display would show it.
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"

layout(location = 0) in vec3 position_m;
layout(location = 1) in float shade; // fraction of the stronger light's disc that is hidden
layout(location = 2) in uvec4 horizon; // of the terrain there: in its shadow there is nothing left to lose
layout(location = 0) out vec3 color;

void main() {
    vec3 relative = position_m - frame.camera_m.xyz;
    // A little towards the camera, so that a coarser triangulation under it does not swallow it.
    gl_Position = frame.clip_from_relative * vec4(relative * 0.995, 1.0);
    const vec3 up = vec3(0.0, 0.0, 1.0);
    const vec3 ground = vec3(0.15); // a middling albedo: the factor depends on it weakly, through the tone curve
    vec3 sky = sky_irradiance(up);
    float sun = sun_visibility(horizon);
    float moon = moon_visibility(horizon);
    float through = 1.0 - shade;
    bool by_moon = frame.key.w > 0.5;
    vec3 lit = ground * (direct_irradiance(up, sun, moon) + sky);
    vec3 shaded = ground * (direct_irradiance(up, by_moon ? sun : sun * through, by_moon ? moon * through : moon) + sky);
    float in_light = sky_light_visibility(sun, moon);
    color = (display(through_air(shaded, relative, in_light)) + 1e-3) / (display(through_air(lit, relative, in_light)) + 1e-3);
}
