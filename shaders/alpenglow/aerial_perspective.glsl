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
    float k = max(distance_m * rise / scale_m, -40.0F); // deeper down there is ground
    // (1 - exp(-k)) / k; the series where the quotient would cancel.
    float mean = abs(k) < 0.05F ? 1.0F - k * (0.5F - k * (1.0F / 6.0F - k * (1.0F / 24.0F)))
                                : (1.0F - exp(-min(k, 80.0F))) / k;
    return distance_m * mean * exp(clamp(-height_m / scale_m, -80.0F, 2.0F));
}

// 1 - exp(-x) for x >= 0 without cancellation.
vec3 alpenglow_one_minus_exp(vec3 x) {
    vec3 small = min(x, vec3(0.02F));
    vec3 series = small * (vec3(1.0F) - small * (vec3(0.5F) - small * (1.0F / 6.0F)));
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

// One stretch of a path; heights, rise and lengths as below. The aerosol's share of the scattering is taken as a parabola
// over the part of the optical depth that lies behind: its value and slope at the near end and its mean are those of the
// densities, the slope held where the parabola would leave 0 .. 1. Light then comes from the source at the mean depth,
// 1 / depth - 1 / (e^depth - 1) of the whole, here a quotient that has its value and slope at 0 and its limit.
AlpenglowAerial alpenglow_aerial_stretch(AlpenglowAir air, float height_m, float rise, float distance_m,
                                         vec3 rayleigh_source, vec3 mie_source) {
    vec3 rayleigh_here = air.rayleigh_per_m * exp(clamp(-height_m / air.rayleigh_height_m, -80.0F, 2.0F));
    vec3 mie_here = air.mie_per_m * exp(clamp(-height_m / air.mie_height_m, -80.0F, 2.0F));
    vec3 here = max(rayleigh_here + mie_here, vec3(1e-30F));
    vec3 mie =
        air.mie_per_m * alpenglow_optical_length(height_m, rise, distance_m, air.mie_height_m);
    vec3 depth =
        air.rayleigh_per_m * alpenglow_optical_length(height_m, rise, distance_m, air.rayleigh_height_m) + mie;
    vec3 share = mie_here / here;
    vec3 drift = mie / max(depth, vec3(1e-30F)) - share;
    vec3 slope = share * (vec3(1.0F) - share) *
                 (rise * (1.0F / air.rayleigh_height_m - 1.0F / air.mie_height_m)) * (depth / here);
    slope = clamp(slope, min(4.0F * drift, vec3(0.0F)), max(4.0F * drift, vec3(0.0F)));
    vec3 held = min(depth, vec3(1e6F));
    vec3 first = (vec3(3.0F) + held) / (vec3(6.0F) + held * (vec3(3.0F) + held));         // mean of the part behind
    vec3 second = first * first * (vec3(2.0F) - first * (4.0F / 3.0F));                   // and of its square, nearly
    vec3 seen = share + slope * first + (3.0F * drift - 1.5F * slope) * second;
    AlpenglowAerial result;
    result.transmittance = exp(-depth);
    result.in_scatter = alpenglow_one_minus_exp(depth) * (rayleigh_source + (mie_source - rayleigh_source) * seen);
    return result;
}

// Both factors for a viewer at height_m who looks along a unit direction (rise is its z) over distance_m.
// cos_sun: cosine between that direction and the light; sun_lux: its illuminance on a surface facing it, at the viewer;
// ambient: mean radiance of sky and ground around, scattered as if it came evenly from everywhere.
AlpenglowAerial alpenglow_aerial_perspective(AlpenglowAir air, float height_m, float rise, float distance_m,
                                             float cos_sun, vec3 sun_lux, vec3 ambient) {
    vec3 rayleigh_source = sun_lux * alpenglow_phase_rayleigh(cos_sun) + ambient;
    vec3 mie_source = sun_lux * alpenglow_phase_henyey_greenstein(cos_sun, air.mie_g) + ambient;
    // A path that climbs or falls far is cut two scale heights of the aerosol over its lower end.
    float climb_m = abs(rise * distance_m);
    float cut_m = 2.0F * air.mie_height_m;
    if (!(climb_m > cut_m)) {
        return alpenglow_aerial_stretch(air, height_m, rise, distance_m, rayleigh_source, mie_source);
    }
    float low_m = distance_m * (cut_m / climb_m);
    float near_m = rise > 0.0F ? low_m : distance_m - low_m;
    AlpenglowAerial result = alpenglow_aerial_stretch(air, height_m, rise, near_m, rayleigh_source, mie_source);
    AlpenglowAerial beyond = alpenglow_aerial_stretch(air, height_m + rise * near_m, rise, distance_m - near_m,
                                                      rayleigh_source, mie_source);
    result.in_scatter += result.transmittance * beyond.in_scatter;
    result.transmittance *= beyond.transmittance;
    return result;
}

#endif
