// From exposed radiance to the bytes of a display.

// A curve with a toe and a shoulder (Narkowicz 2015, a fit of the ACES reference rendering), per channel, so that
// what is very bright turns white.
vec3 tone_curve(vec3 x) {
    x *= 0.8;
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// IEC 61966-2-1.
vec3 encode_srgb(vec3 linear) {
    return mix(1.055 * pow(max(linear, 0.0031308), vec3(1.0 / 2.4)) - 0.055, 12.92 * linear,
               lessThan(linear, vec3(0.0031308)));
}

vec3 display(vec3 radiance) { return encode_srgb(tone_curve(radiance)); }
