#version 450
#extension GL_GOOGLE_include_directive : require
// A picture of a cloud on its bent mesh, seen through the air in front of it.
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"

layout(constant_id = 0) const bool hdr = false;
layout(constant_id = 2) const float atlas_width = 1.0;
layout(constant_id = 3) const float atlas_height = 1.0;

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 texels; // of the picture, and of the one that goes
layout(location = 2) in vec3 weights; // of the two, and the share of the optical depth
layout(location = 0) out vec4 places;
layout(location = 1) out vec3 shares;
layout(location = 2) out vec3 clear;
layout(location = 3) out vec3 air;

void main() {
    vec3 relative_m = position_m - frame.camera_m.xyz;
    gl_Position = frame.clip_from_relative * vec4(relative_m, 1.0);
    places = texels / vec4(atlas_width, atlas_height, atlas_width, atlas_height);
    shares = weights;
    vec3 transmittance = air_transmittance(relative_m);
    vec3 light = air_light(relative_m, transmittance, 1.0);
    if (hdr) {
        clear = transmittance;
        air = light;
    } else {
        // Display colours mix as the light does for a cloud of middling brightness: the share of the light that the air
        // adds is taken at white.
        vec3 through = display(transmittance + light);
        air = display(light) * (1.0 - transmittance);
        clear = clamp((through - air) / display(vec3(1.0)), 0.0, 1.0);
    }
}
