// From exposed radiance to what a display takes.

// Tone curve and sRGB encoding for grey in one rational function (the idea of Hejl and Burgess-Dawson 2010). It follows
// Narkowicz's fit of the ACES reference rendering (2015, at 0.8 of its input) with IEC 61966-2-1's encoding within
// 1.8 / 255 everywhere.
float tone_curve(float x) { return min(x * (x + 0.26093) / (x * (0.99189 * x + 0.37611) + 0.061396), 1.0); }

// The curve bends the largest channel alone and the others keep their ratios to it, so that a low sun stays orange where
// a curve per channel would turn it lemon; the very bright fades towards white. Ratios are encoded by the power 1 / 2.2,
// sqrt(r) (1 + 0.14 (1 - r)^2) within 2 % for r above 0.05.
vec3 display(vec3 radiance) {
    float brightest = clamp(max(max(radiance.r, radiance.g), radiance.b), 1e-6, 1e4);
    vec3 r = min(radiance / brightest, 1.0);
    r += 0.8 * brightest / (brightest + 8.0) * (1.0 - r);
    vec3 rest = 1.0 - r;
    return tone_curve(brightest) * sqrt(max(r, 0.0)) * (1.0 + 0.14 * rest * rest);
}
