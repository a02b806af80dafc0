/* Constants of the spherical harmonics up to order 5, read by C++ and GLSL alike: plain macros, single precision in GLSL.
   Real orthonormal basis with the signs of basis.hpp. A test holds them to the tables that the library computes. */
#ifndef ALPENGLOW_SH_CONSTANTS_H
#define ALPENGLOW_SH_CONSTANTS_H

/* Band 0, band 1 (times -y, z, -x). */
#define ALPENGLOW_SH_K0 0.282094791773878143
#define ALPENGLOW_SH_K1 0.488602511902919922
/* Band 2: xy, -yz, 3 z^2 - 1, -xz, x^2 - y^2. */
#define ALPENGLOW_SH_K2_2 1.09254843059207907
#define ALPENGLOW_SH_K2_1 1.09254843059207907
#define ALPENGLOW_SH_K2_0 0.315391565252520006
#define ALPENGLOW_SH_K2_2C 0.546274215296039535
/* Band 3, m = 0 .. 3: z (5 z^2 - 3), (5 z^2 - 1) {x, y}, z {x^2 - y^2, 2 xy}, {x (x^2 - 3 y^2), y (3 x^2 - y^2)}. */
#define ALPENGLOW_SH_K3_0 0.373176332590115391
#define ALPENGLOW_SH_K3_1 0.457045799464465737
#define ALPENGLOW_SH_K3_2 1.44530572132027702
#define ALPENGLOW_SH_K3_3 0.590043589926643511
/* Band 4, m = 0 .. 4: 35 z^4 - 30 z^2 + 3, z (7 z^2 - 3), 7 z^2 - 1, z, 1, times the same azimuthal parts. */
#define ALPENGLOW_SH_K4_0 0.105785546915204304
#define ALPENGLOW_SH_K4_1 0.669046543557289165
#define ALPENGLOW_SH_K4_2 0.473087347878780003
#define ALPENGLOW_SH_K4_3 1.77013076977993053
#define ALPENGLOW_SH_K4_4 0.625835735449176135

/* Clamped cosine: the factor of each band in irradiance, Ramamoorthi and Hanrahan 2001, eq. 8. */
#define ALPENGLOW_SH_A0 3.14159265358979324
#define ALPENGLOW_SH_A1 2.09439510239319549
#define ALPENGLOW_SH_A2 0.785398163397448310
#define ALPENGLOW_SH_A3 0.0
#define ALPENGLOW_SH_A4 -0.130899693899574718

/* Table 1 of Sloan 2017: columns of the bands 1, 2, 3, and zero after the last. */
#define ALPENGLOW_SH_WINDOW_COLUMNS 8
#define ALPENGLOW_SH_WINDOW_BAND1 1.0, 0.9941, 0.9872, 0.9634, 0.9602, 0.9184, 0.8915, 0.0
#define ALPENGLOW_SH_WINDOW_BAND2 1.0, 0.9766, 0.9493, 0.9355, 0.9207, 0.8710, 0.8030, 0.0
#define ALPENGLOW_SH_WINDOW_BAND3 1.0, 0.9478, 0.8880, 0.8584, 0.8270, 0.7241, 0.5904, 0.0

#endif
