#version 450
#extension GL_GOOGLE_include_directive : require
// Terrain and objects for light per pixel.
#include "frame.glsl"
#include "light.glsl"
#include "surface.glsl"

layout(push_constant) uniform Push {
    vec4 grid; // terrain: image coordinates = grid.x * position + grid.yz
};

layout(location = 0) out vec3 relative_m;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec4 albedo; // a: sky visibility
layout(location = 3) out vec4 place;  // xy: image coordinates; z, w: visibility of sun and moon over the terrain

void main() {
    Surface s = read_surface();
    gl_Position = frame.clip_from_relative * vec4(s.relative_m, 1.0);
    relative_m = s.relative_m;
    normal = s.normal;
    albedo = vec4(s.albedo, s.ambient);
    place = vec4(grid.x * position_m.xy + grid.yz, sun_visibility(s.horizon), moon_visibility(s.horizon));
}
