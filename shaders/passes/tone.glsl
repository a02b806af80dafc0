// From exposed radiance to what a display takes. C++ reads this file too (sandbox/app/tone.hpp).

// Tone curve and sRGB encoding for grey in one rational function (the idea of Hejl and Burgess-Dawson 2010). It follows
// Narkowicz's fit of the ACES reference rendering (2015, at 0.8 of its input) with IEC 61966-2-1's encoding within
// 1.8 / 255 everywhere.
float tone_curve(float x) { return min(x * (x + 0.26093F) / (x * (0.99189F * x + 0.37611F) + 0.061396F), 1.0F); }

// The curve bends the largest channel alone and the others keep their ratios to it, so that a low sun stays orange where
// a curve per channel would turn it lemon; the very bright fades towards white. Ratios are encoded by the power 1 / 2.2,
// sqrt(r) (1 + 0.14 (1 - r)^2) within 2 % for r above 0.05.
vec3 display(vec3 radiance) {
    float brightest = clamp(max(max(radiance.r, radiance.g), radiance.b), 1e-6F, 1e4F);
    vec3 r = min(radiance / brightest, 1.0F);
    r += 0.8F * brightest / (brightest + 8.0F) * (1.0F - r);
    vec3 rest = 1.0F - r;
    return tone_curve(brightest) * sqrt(max(r, 0.0F)) * (1.0F + 0.14F * rest * rest);
}
