// Spherical harmonics for shaders, orders 2 to 5 (4 to 25 coefficients); conventions of docs/sh.md, zonal axis +Z. For
// each order N with C = N * N coefficients:
//
//   void  alpenglow_sh_basisN(vec3 d, out float y[C])               basis in a unit direction
//   vec3  alpenglow_sh_evaluateN(vec3 c[C], vec3 d)                 value of RGB coefficients, such as radiance
//   vec3  alpenglow_sh_irradianceN(vec3 c[C], vec3 normal)          irradiance of radiance coefficients, not below 0
//   void  alpenglow_sh_rotate_zN(float angle, inout vec3 c[C])      about +Z, from +X towards +Y
//   float alpenglow_sh_dotN(vec4 a[P], vec4 b[P])                   dot of packed coefficients, P = (C + 3) / 4
//
// Packed: four coefficients a vec4, zeros behind the last. An array of RGB coefficients as probes are stored in C++
// (ProbeLine: coefficient i, channel c is float 3 i + c) unpacks with ALPENGLOW_SH_RGB(lines, i), lines being vec4s.
// Error of the basis against double: 1e-6 absolute.
#ifndef ALPENGLOW_SH_GLSL
#define ALPENGLOW_SH_GLSL

#include "sh_tables.h"

#define ALPENGLOW_SH_RGB(lines, i)                                                                                     \
    vec3(lines[(3 * (i)) / 4][(3 * (i)) % 4], lines[(3 * (i) + 1) / 4][(3 * (i) + 1) % 4],                             \
         lines[(3 * (i) + 2) / 4][(3 * (i) + 2) % 4])

// One band each, into y[l * l ..]. c and s are real and imaginary parts of (-(x + iy))^m.
#define ALPENGLOW_SH_BANDS_01(y, d)                                                                                    \
    y[0] = ALPENGLOW_SH_P_0_0_0;                                                                                       \
    y[1] = -ALPENGLOW_SH_P_1_1_0 * d.y;                                                                                \
    y[2] = ALPENGLOW_SH_P_1_0_0 * d.z;                                                                                 \
    y[3] = -ALPENGLOW_SH_P_1_1_0 * d.x;

#define ALPENGLOW_SH_BAND_2(y, d)                                                                                      \
    float z2 = d.z * d.z;                                                                                              \
    float c2 = d.x * d.x - d.y * d.y;                                                                                  \
    float s2 = 2.0 * d.x * d.y;                                                                                        \
    float q21 = -ALPENGLOW_SH_P_2_1_0 * d.z;                                                                           \
    y[4] = ALPENGLOW_SH_P_2_2_0 * s2;                                                                                  \
    y[5] = q21 * d.y;                                                                                                  \
    y[6] = ALPENGLOW_SH_P_2_0_1 * z2 + ALPENGLOW_SH_P_2_0_0;                                                           \
    y[7] = q21 * d.x;                                                                                                  \
    y[8] = ALPENGLOW_SH_P_2_2_0 * c2;

#define ALPENGLOW_SH_BAND_3(y, d)                                                                                      \
    float c3 = -(d.x * c2 - d.y * s2);                                                                                 \
    float s3 = -(d.x * s2 + d.y * c2);                                                                                 \
    float q31 = -(ALPENGLOW_SH_P_3_1_1 * z2 + ALPENGLOW_SH_P_3_1_0);                                                   \
    float q32 = ALPENGLOW_SH_P_3_2_0 * d.z;                                                                            \
    y[9] = ALPENGLOW_SH_P_3_3_0 * s3;                                                                                  \
    y[10] = q32 * s2;                                                                                                  \
    y[11] = q31 * d.y;                                                                                                 \
    y[12] = (ALPENGLOW_SH_P_3_0_1 * z2 + ALPENGLOW_SH_P_3_0_0) * d.z;                                                  \
    y[13] = q31 * d.x;                                                                                                 \
    y[14] = q32 * c2;                                                                                                  \
    y[15] = ALPENGLOW_SH_P_3_3_0 * c3;

#define ALPENGLOW_SH_BAND_4(y, d)                                                                                      \
    float c4 = c2 * c2 - s2 * s2;                                                                                      \
    float s4 = 2.0 * c2 * s2;                                                                                          \
    float q41 = -(ALPENGLOW_SH_P_4_1_1 * z2 + ALPENGLOW_SH_P_4_1_0) * d.z;                                             \
    float q42 = ALPENGLOW_SH_P_4_2_1 * z2 + ALPENGLOW_SH_P_4_2_0;                                                      \
    float q43 = ALPENGLOW_SH_P_4_3_0 * d.z;                                                                            \
    y[16] = ALPENGLOW_SH_P_4_4_0 * s4;                                                                                 \
    y[17] = q43 * s3;                                                                                                  \
    y[18] = q42 * s2;                                                                                                  \
    y[19] = q41 * d.y;                                                                                                 \
    y[20] = (ALPENGLOW_SH_P_4_0_2 * z2 + ALPENGLOW_SH_P_4_0_1) * z2 + ALPENGLOW_SH_P_4_0_0;                            \
    y[21] = q41 * d.x;                                                                                                 \
    y[22] = q42 * c2;                                                                                                  \
    y[23] = q43 * c3;                                                                                                  \
    y[24] = ALPENGLOW_SH_P_4_4_0 * c4;

void alpenglow_sh_basis2(vec3 d, out float y[4]) {
    ALPENGLOW_SH_BANDS_01(y, d)
}
void alpenglow_sh_basis3(vec3 d, out float y[9]) {
    ALPENGLOW_SH_BANDS_01(y, d)
    ALPENGLOW_SH_BAND_2(y, d)
}
void alpenglow_sh_basis4(vec3 d, out float y[16]) {
    ALPENGLOW_SH_BANDS_01(y, d)
    ALPENGLOW_SH_BAND_2(y, d)
    ALPENGLOW_SH_BAND_3(y, d)
}
void alpenglow_sh_basis5(vec3 d, out float y[25]) {
    ALPENGLOW_SH_BANDS_01(y, d)
    ALPENGLOW_SH_BAND_2(y, d)
    ALPENGLOW_SH_BAND_3(y, d)
    ALPENGLOW_SH_BAND_4(y, d)
}

float alpenglow_sh_cosine_factor(int l) {
    return l == 0 ? ALPENGLOW_SH_A_0
                  : l == 1 ? ALPENGLOW_SH_A_1
                           : l == 2 ? ALPENGLOW_SH_A_2 : l == 3 ? ALPENGLOW_SH_A_3 : ALPENGLOW_SH_A_4;
}

// Rotation about +Z mixes the pairs m, -m only (Habel et al. 2008, eq. 4).
#define ALPENGLOW_SH_DEFINE(ORDER, COUNT, PACKED)                                                                      \
    vec3 alpenglow_sh_evaluate##ORDER(vec3 c[COUNT], vec3 d) {                                                         \
        float y[COUNT];                                                                                                \
        alpenglow_sh_basis##ORDER(d, y);                                                                               \
        vec3 sum = c[0] * y[0];                                                                                        \
        for (int i = 1; i < COUNT; ++i) {                                                                              \
            sum += c[i] * y[i];                                                                                        \
        }                                                                                                              \
        return sum;                                                                                                    \
    }                                                                                                                  \
    vec3 alpenglow_sh_irradiance##ORDER(vec3 c[COUNT], vec3 normal) {                                                  \
        float y[COUNT];                                                                                                \
        alpenglow_sh_basis##ORDER(normal, y);                                                                          \
        vec3 sum = vec3(0.0);                                                                                          \
        for (int l = 0; l < ORDER; ++l) {                                                                              \
            vec3 band = vec3(0.0);                                                                                     \
            for (int i = l * l; i < (l + 1) * (l + 1); ++i) {                                                          \
                band += c[i] * y[i];                                                                                   \
            }                                                                                                          \
            sum += alpenglow_sh_cosine_factor(l) * band;                                                               \
        }                                                                                                              \
        return max(sum, vec3(0.0));                                                                                    \
    }                                                                                                                  \
    void alpenglow_sh_rotate_z##ORDER(float angle, inout vec3 c[COUNT]) {                                              \
        for (int m = 1; m < ORDER; ++m) {                                                                              \
            float co = cos(float(m) * angle);                                                                          \
            float si = sin(float(m) * angle);                                                                          \
            for (int l = m; l < ORDER; ++l) {                                                                          \
                int at = l * (l + 1);                                                                                  \
                vec3 plus = c[at + m];                                                                                 \
                vec3 minus = c[at - m];                                                                                \
                c[at + m] = co * plus - si * minus;                                                                    \
                c[at - m] = co * minus + si * plus;                                                                    \
            }                                                                                                          \
        }                                                                                                              \
    }                                                                                                                  \
    float alpenglow_sh_dot##ORDER(vec4 a[PACKED], vec4 b[PACKED]) {                                                    \
        float sum = dot(a[0], b[0]);                                                                                   \
        for (int i = 1; i < PACKED; ++i) {                                                                             \
            sum += dot(a[i], b[i]);                                                                                    \
        }                                                                                                              \
        return sum;                                                                                                    \
    }

ALPENGLOW_SH_DEFINE(2, 4, 1)
ALPENGLOW_SH_DEFINE(3, 9, 3)
ALPENGLOW_SH_DEFINE(4, 16, 4)
ALPENGLOW_SH_DEFINE(5, 25, 7)

#endif
