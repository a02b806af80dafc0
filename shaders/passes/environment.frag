#version 450
#extension GL_GOOGLE_include_directive : require
// An equirectangular picture by direction; see EnvironmentMap for which way it looks.
#include "tone.glsl"
#include "dither.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(set = 1, binding = 0) uniform sampler2D picture;
layout(push_constant) uniform Push {
    mat4 direction_from_clip;
    float scale; // from texels to exposed radiance
    float azimuth_rad;
};
layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 target;

const float pi = 3.14159265358979;

void main() {
    vec3 d = normalize(direction);
    vec2 at = vec2(0.5 + (atan(d.x, d.y) - azimuth_rad) / (2.0 * pi), acos(clamp(d.z, -1.0, 1.0)) / pi);
    float half_row = 0.5 / float(textureSize(picture, 0).y); // columns repeat, rows end at the poles
    vec3 radiance = textureLod(picture, vec2(at.x, clamp(at.y, half_row, 1.0 - half_row)), 0.0).rgb * scale;
    target = vec4(hdr ? radiance : display(radiance) + dither(), 1.0);
}
