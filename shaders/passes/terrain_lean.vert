#version 450
#extension GL_GOOGLE_include_directive : require
// Terrain: what of the light changes slowly is found per vertex; the fragment shader adds the ground's relief.
#include "frame.glsl"
#include "light.glsl"
#include "surface.glsl"
#include "terrain_grid.glsl"

layout(push_constant) uniform Push {
    vec4 grid;  // image coordinates = grid.x * position + grid.yz
    vec2 tiles; // sides of the two sizes of the detail's tile, metres, the finer first
};

layout(location = 0) out vec2 place;
layout(location = 1) out vec3 key_light; // radiance that comes back from ground of albedo luminance 1 facing the key light
layout(location = 2) out vec3 sky_light; // likewise from the rest of the light, without occlusion
layout(location = 3) out vec3 air;
layout(location = 4) out vec4 detail_place; // for the coarser and the finer tile

void main() {
    Surface s = read_surface();
    gl_Position = frame.clip_from_relative * vec4(s.relative_m, 1.0);
    place = grid.x * position_m.xy + grid.yz;
    detail_place = vec4(position_m.xy / tiles.y, position_m.xy / tiles.x);
    float sun_visible = sun_visibility(s.horizon);
    vec3 sun = frame.sun.rgb * sun_visible;
    vec3 moon = frame.moon.rgb * moon_visibility(s.horizon);
    bool by_moon = frame.key.w > 0.5;
    vec3 other = by_moon ? sun * max(dot(s.normal, frame.to_sun.xyz), 0.0)
                         : moon * max(dot(s.normal, frame.to_moon.xyz), 0.0);
    vec3 transmittance = air_transmittance(s.relative_m);
    vec3 reflectance = chroma_of(s.albedo) * transmittance;
    key_light = reflectance * (by_moon ? moon : sun);
    sky_light = reflectance * (sky_irradiance(s.normal) + other);
    air = air_light(s.relative_m, transmittance, sun_visible);
}
