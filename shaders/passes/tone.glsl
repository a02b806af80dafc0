// From exposed radiance to what a display takes.

// Tone curve and sRGB encoding in one rational function, a division a channel (the idea of Hejl and Burgess-Dawson 2010).
// It follows Narkowicz's fit of the ACES reference rendering (2015, at 0.8 of its input) with IEC 61966-2-1's encoding
// within 1.8 / 255 everywhere. Per channel, so that what is very bright turns white.
vec3 display(vec3 radiance) {
    vec3 x = min(radiance, 1e4);
    return min(x * (x + 0.26093) / (x * (0.99189 * x + 0.37611) + 0.061396), 1.0);
}
