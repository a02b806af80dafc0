#version 450
#extension GL_GOOGLE_include_directive : require
// Bodies whose transfer the shader evaluates, from the tables that the CPU would read: diffuse vectors, glossy matrices
// at the reflected view direction. Must agree with TransferScene::shade_on_cpu.
#include "alpenglow/sh.glsl"
#include "frame.glsl"
#include "light.glsl"
#include "tone.glsl"
#include "transfer_block.h"
#include "transfer_place.glsl"

layout(constant_id = 0) const bool hdr = false;

layout(set = 1, binding = 0, std430) readonly buffer Words { uint words[]; };
layout(set = 1, binding = 1, std430) readonly buffer Body { TransferBlock body; };

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 albedo;
layout(location = 3) in vec3 left; // part of the light that other things leave
layout(location = 0) out vec3 color;

// Which of the two tables is read.
bool reads_glossy = false;
#define ALPENGLOW_TRANSFER_ENCODING 1
uint transfer_word(uint index) { return words[reads_glossy ? body.words.x + index : index]; }
vec3 transfer_light(uint i) { return (reads_glossy ? body.glossy_light[i] : body.diffuse_light[i]).rgb; }
#include "alpenglow/transfer.glsl"

vec3 gloss(uint point) {
    vec4 back = vec4(-place.turn.xyz, place.turn.w);
    vec3 eye = turned(back, frame.camera_m.xyz - place.position.xyz);
    vec3 view = normalize(eye - position_m);
    float cosine = dot(normal, view);
    float y[25];
    alpenglow_sh_basis5(2.0 * cosine * normal - view, y);
    float weights[36];
    for (int l = 0; l < 5; ++l) {
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            weights[i] = body.kernel[l >> 2][l & 3] * y[i];
        }
    }
    reads_glossy = true;
    vec3 arrives = alpenglow_transfer_glossy(point, body.glossy.x, body.glossy.y, body.glossy.z, body.glossy.w, weights);
    float away = 1.0 - clamp(cosine, 0.0, 1.0); // Schlick
    float grazing = away * away * away * away * away;
    return (body.specular.rgb + (1.0 - body.specular.rgb) * grazing) * max(arrives, 0.0);
}

void main() {
    vec3 relative_m = relative_to_camera(position_m);
    gl_Position = frame.clip_from_relative * vec4(relative_m, 1.0);
    uint point = uint(gl_VertexIndex);
    vec3 light = vec3(0.0);
    if (body.diffuse.x != 0u) {
        light = albedo * left * max(alpenglow_transfer(point, body.diffuse.y, body.diffuse.z, body.diffuse.w), 0.0);
    }
    if (body.glossy.x != 0u && point < body.words.y) {
        light += gloss(point);
    }
    vec3 radiance = through_air(light * frame.sun.w, relative_m, 1.0);
    color = hdr ? radiance : display(radiance);
}
