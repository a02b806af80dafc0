// Aerial perspective in closed form (Preetham and Hoffman, "Modeling Skylight and Aerial Perspective", SIGGRAPH course
// 2003): L_s = f L_0 + L_in, with molecules and aerosols in densities that fall exponentially with height. This file is
// GLSL and C++ at once: modules/sky compiles it too, so that both say the same. Metres, lux, cd/m^2.
#ifndef ALPENGLOW_AERIAL_PERSPECTIVE_GLSL
#define ALPENGLOW_AERIAL_PERSPECTIVE_GLSL

struct AlpenglowAir {
    vec3 rayleigh_per_m;     // scattering of molecules at sea level, for R, G, B
    vec3 mie_per_m;          // scattering of aerosol at sea level
    float rayleigh_height_m; // scale heights
    float mie_height_m;
    float mie_g;             // mean cosine of the aerosol's Henyey-Greenstein phase function
};

struct AlpenglowAerial {
    vec3 transmittance; // f
    vec3 in_scatter;    // L_in
};

// Integral of exp(-h / scale) along a straight path over a flat Earth: from height_m on, climbing `rise` metres a metre.
float alpenglow_optical_length(float height_m, float rise, float distance_m, float scale_m) {
    float k = clamp(distance_m * rise / scale_m, -80.0F, 80.0F);
    // (1 - exp(-k)) / k; the series where the quotient would cancel.
    float mean = abs(k) < 0.05F ? 1.0F - k * (0.5F - k * (1.0F / 6.0F - k * (1.0F / 24.0F))) : (1.0F - exp(-k)) / k;
    return distance_m * mean * exp(clamp(-height_m / scale_m, -80.0F, 2.0F));
}

// 1 - exp(-x) for x >= 0 without cancellation.
vec3 alpenglow_one_minus_exp(vec3 x) {
    vec3 series = x * (vec3(1.0F) - x * (vec3(0.5F) - x * (1.0F / 6.0F)));
    vec3 direct = vec3(1.0F) - exp(-x);
    return mix(series, direct, step(vec3(0.02F), x));
}

float alpenglow_phase_rayleigh(float cos_angle) {
    return 0.0596831037F * (1.0F + cos_angle * cos_angle); // 3 / (16 pi)
}

float alpenglow_phase_henyey_greenstein(float cos_angle, float g) {
    float d = (1.0F - g) * (1.0F - g) + 2.0F * g * (1.0F - cos_angle);
    return 0.0795774715F * (1.0F - g * g) / max(d * sqrt(d), 1e-12F); // 1 / (4 pi)
}

// Both factors for a viewer at height_m who looks along a unit direction (rise is its z) over distance_m.
// cos_sun: cosine between that direction and the light; sun_lux: its illuminance on a surface facing it, at the viewer;
// ambient: mean radiance of sky and ground around, scattered as if it came evenly from everywhere.
AlpenglowAerial alpenglow_aerial_perspective(AlpenglowAir air, float height_m, float rise, float distance_m,
                                             float cos_sun, vec3 sun_lux, vec3 ambient) {
    vec3 rayleigh_source = sun_lux * alpenglow_phase_rayleigh(cos_sun) + ambient;
    vec3 mie_source = sun_lux * alpenglow_phase_henyey_greenstein(cos_sun, air.mie_g) + ambient;
    // The closed form is exact where both densities keep their ratio: two parts, the nearer the shorter, hold the
    // ratio's drift down (docs/sky.md).
    float near_m = distance_m * 0.4F;
    AlpenglowAerial result;
    result.transmittance = vec3(1.0F);
    result.in_scatter = vec3(0.0F);
    float from_m = 0.0F;
    for (int part = 0; part < 2; ++part) {
        float length_m = part == 0 ? near_m : distance_m - near_m;
        float at_m = height_m + rise * from_m;
        vec3 rayleigh =
            air.rayleigh_per_m * alpenglow_optical_length(at_m, rise, length_m, air.rayleigh_height_m);
        vec3 mie = air.mie_per_m * alpenglow_optical_length(at_m, rise, length_m, air.mie_height_m);
        vec3 depth = rayleigh + mie;
        vec3 source = (rayleigh * rayleigh_source + mie * mie_source) / max(depth, vec3(1e-20F));
        result.in_scatter += result.transmittance * source * alpenglow_one_minus_exp(depth);
        result.transmittance *= exp(-depth);
        from_m += length_m;
    }
    return result;
}

#endif
