#version 450
#extension GL_GOOGLE_include_directive : require
// Objects, all light per vertex, encoded for the display here: what is left per pixel is an interpolation.
#include "frame.glsl"
#include "light.glsl"
#include "surface.glsl"
#include "tone.glsl"

layout(constant_id = 1) const bool hdr = false;

layout(location = 0) out vec3 color;

void main() {
    Surface s = read_surface();
    gl_Position = frame.clip_from_relative * vec4(s.relative_m, 1.0);
    float sun = sun_visibility(s.horizon);
    float moon = moon_visibility(s.horizon);
    vec2 through = cloud_visibility(s.relative_m);
    vec3 light = direct_irradiance(s.normal, sun * through.x, moon * through.y) + s.ambient * sky_irradiance(s.normal);
    vec3 radiance = through_air(s.albedo * light, s.relative_m, sky_light_visibility(sun, moon));
    color = hdr ? radiance : display(radiance);
}
