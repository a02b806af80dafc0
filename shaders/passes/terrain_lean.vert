#version 450
#extension GL_GOOGLE_include_directive : require
// Terrain: what of the light changes slowly is found per vertex; the fragment shader adds the ground's relief.
#include "frame.glsl"
#include "light.glsl"
#include "surface.glsl"
#include "terrain_grid.glsl"

layout(location = 0) out vec2 ground_m; // place on the map
layout(location = 1) out vec3 key_light; // radiance that comes back from white ground facing the key light
layout(location = 2) out vec3 sky_light; // likewise from the rest of the light, without occlusion
layout(location = 3) out vec3 air;
layout(location = 4) out vec4 albedo;    // rgb: its colour, of luminance 1; a: its luminance

void main() {
    Surface s = read_surface();
    gl_Position = frame.clip_from_relative * vec4(s.relative_m, 1.0);
    ground_m = position_m.xy;
    float sun_visible = sun_visibility(s.horizon);
    float moon_visible = moon_visibility(s.horizon);
    vec2 through = cloud_visibility(s.relative_m);
    vec3 sun = frame.sun.rgb * (sun_visible * through.x);
    vec3 moon = frame.moon.rgb * (moon_visible * through.y);
    bool by_moon = frame.key.w > 0.5;
    vec3 other = by_moon ? sun * max(dot(s.normal, frame.to_sun.xyz), 0.0)
                         : moon * max(dot(s.normal, frame.to_moon.xyz), 0.0);
    vec3 transmittance = air_transmittance(s.relative_m);
    albedo = vec4(chroma_of(s.albedo), dot(s.albedo, luminance_weights));
    key_light = transmittance * (by_moon ? moon : sun);
    sky_light = transmittance * (sky_irradiance(s.normal) + other);
    air = air_light(s.relative_m, transmittance, sky_light_visibility(sun_visible, moon_visible));
}
