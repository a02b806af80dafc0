// Calls every function of sh.glsl for each item; one invocation an item, the order by specialization.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "alpenglow/sh.glsl"

layout(constant_id = 0) const int order = 3;
layout(local_size_x = 64) in;

struct Item {
    vec4 direction; // w: angle of rotation
    vec4 lines[19]; // RGB coefficients as probes are stored: 75 floats
    vec4 packed_a[7];
    vec4 packed_b[7];
};
struct Answer {
    vec4 radiance;   // w: the dot product
    vec4 irradiance;
    vec4 turned;     // radiance after rotation about z
    vec4 basis[7];
};
layout(std430, set = 0, binding = 0) readonly buffer Items { Item items[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Answers { Answer answers[]; };

#define RUN(ORDER, COUNT, PACKED)                                                                                      \
    void run##ORDER(uint k) {                                                                                          \
        vec3 d = items[k].direction.xyz;                                                                               \
        vec3 c[COUNT];                                                                                                 \
        for (int i = 0; i < COUNT; ++i) {                                                                              \
            c[i] = ALPENGLOW_SH_RGB(items[k].lines, i);                                                                \
        }                                                                                                              \
        vec4 a[PACKED];                                                                                                \
        vec4 b[PACKED];                                                                                                \
        for (int i = 0; i < PACKED; ++i) {                                                                             \
            a[i] = items[k].packed_a[i];                                                                               \
            b[i] = items[k].packed_b[i];                                                                               \
        }                                                                                                              \
        float y[COUNT];                                                                                                \
        alpenglow_sh_basis##ORDER(d, y);                                                                               \
        for (int i = 0; i < 28; ++i) {                                                                                 \
            answers[k].basis[i / 4][i % 4] = i < COUNT ? y[min(i, COUNT - 1)] : 0.0;                                   \
        }                                                                                                              \
        answers[k].radiance = vec4(alpenglow_sh_evaluate##ORDER(c, d), alpenglow_sh_dot##ORDER(a, b));                 \
        answers[k].irradiance = vec4(alpenglow_sh_irradiance##ORDER(c, d), 0.0);                                       \
        alpenglow_sh_rotate_z##ORDER(items[k].direction.w, c);                                                         \
        answers[k].turned = vec4(alpenglow_sh_evaluate##ORDER(c, d), 0.0);                                             \
    }
RUN(2, 4, 1)
RUN(3, 9, 3)
RUN(4, 16, 4)
RUN(5, 25, 7)

void main() {
    uint k = gl_GlobalInvocationID.x;
    if (k >= items.length()) {
        return;
    }
    if (order == 2) {
        run2(k);
    } else if (order == 3) {
        run3(k);
    } else if (order == 4) {
        run4(k);
    } else {
        run5(k);
    }
}
