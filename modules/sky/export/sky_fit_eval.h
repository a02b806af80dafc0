/* Evaluates a sky fit written by alpenglow-fit-sky: sun's zenith angle and other parameters -> spherical harmonics.
   out[3 * (l * (l + 1) + m) + channel], real orthonormal basis with Condon-Shortley phase, +Z the zenith; the azimuth is
   measured from +X towards +Y. Parameters are held at the ends of the domain. C99. */
#ifndef SKY_FIT_EVAL_H
#define SKY_FIT_EVAL_H
#include <math.h>
typedef struct { int map; float low, high, offset; } sky_fit_axis; /* 0: x, 1: tan(x / 2), 2: log(x - offset) */
typedef struct {
    sky_fit_axis axes[4];
    int axis_count, rows, log_terms;
    const unsigned char* degrees; const float* row; const unsigned char* log_degrees; const float* log_term;
} sky_fit_part;
typedef struct { int normaliser, bands, parts; const sky_fit_part* part; } sky_fit;

static float sky_fit_map(const sky_fit_axis* a, float x) {
    return a->map == 1 ? tanf(0.5f * x) : a->map == 2 ? logf(x - a->offset) : x;
}
static float sky_fit_clamp(float x, float low, float high) { return x > high ? high : x >= low ? x : low; }
static float sky_fit_product(const unsigned char* degrees, float t[4][64], int axes) {
    float w = 1;
    for (int a = 0; a < axes; ++a) w *= t[a][degrees[a]];
    return w;
}
static float sky_fit_preetham(float theta, float T) { /* close to Y_z / F(0, theta_s) */
    float z = cosf(theta), r = sinf(theta), v = (1 + z - r) / (1 + z + r), w = v * v;
    float h = v * (0.99997726f + w * (-0.33262347f + w * (0.19354346f + w * (-0.11643287f + w * (0.05265332f - w * 0.0117212f)))));
    float chi = 4 * (4.0f / 9 - T / 120) * h, x = chi * chi;
    float tangent = chi * (10395 + x * (-1260 + 21 * x)) / (10395 + x * (-4725 + x * (210 - x)));
    float y = -0.25f * (0.1206f * T - 2.5771f) * (1.57079633f - 2 * h), s = 1 + y * (1 + y * (0.5f + y / 6));
    return 1000 * ((4.0453f * T - 4.9710f) * tangent + 2.4192f - 0.2155f * T) /
           ((1 + (0.1787f * T - 1.4630f) * expf(0.4275f - 0.3554f * T)) *
            (1 + (5.3251f - 0.0227f * T) / (s * s * s * s) + (0.3703f - 0.0670f * T) * z * z));
}
static void sky_fit_evaluate(const sky_fit* fit, const float* parameters, float azimuth, int bands, float* out) {
    const sky_fit_part* p = fit->part;
    for (int i = 1; i < fit->parts; ++i) /* the last part that begins below the parameters */
        for (int a = 0, inside = 1; a < p->axis_count && inside; ++a) {
            inside = parameters[a] >= fit->part[i].axes[a].low || fit->part[i].axes[a].low <= p->axes[a].low;
            if (inside && a + 1 == p->axis_count) p = &fit->part[i];
        }
    int n = p->axis_count, stride = 3 * fit->bands * (fit->bands + 1) / 2;
    float t[4][64], held[4], k = 1;
    for (int a = 0; a < n; ++a) {
        held[a] = sky_fit_clamp(parameters[a], p->axes[a].low, p->axes[a].high);
        float low = sky_fit_map(&p->axes[a], p->axes[a].low), high = sky_fit_map(&p->axes[a], p->axes[a].high);
        t[a][0] = 1;
        t[a][1] = sky_fit_clamp((2 * sky_fit_map(&p->axes[a], held[a]) - low - high) / (high - low), -1, 1);
        for (int d = 2; d < 64; ++d) t[a][d] = 2 * t[a][1] * t[a][d - 1] - t[a][d - 2];
    }
    if (fit->normaliser == 1) k = sky_fit_preetham(held[0], held[1]);
    if (fit->normaliser == 2) {
        float e = 0;
        for (int i = 0; i < p->log_terms; ++i) e += p->log_term[i] * sky_fit_product(p->log_degrees + i * n, t, n);
        k = expf(e);
    }
    for (int i = 0; i < 3 * bands * bands; ++i) out[i] = 0;
    for (int r = 0; r < p->rows; ++r) {
        float w = k * sky_fit_product(p->degrees + r * n, t, n);
        for (int l = 0, f = 0; l < bands; ++l)
            for (int i = 0; i < 3 * (l + 1); ++i, ++f) out[3 * l * (l + 1) + i] += w * p->row[r * stride + f];
    }
    for (int l = 1; l < bands; ++l)
        for (int m = 1; m <= l; ++m)
            for (int q = 0; q < 3; ++q) {
                float* c = out + 3 * l * (l + 1) + q;
                c[-3 * m] = c[3 * m] * sinf(m * azimuth);
                c[3 * m] *= cosf(m * azimuth);
            }
}
#endif
