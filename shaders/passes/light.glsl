// Light on surfaces out of doors, and the air in front of them. Needs frame.glsl.

// Fraction of a disc of angular radius `radius` that stands over a straight horizon, its centre `height` above it.
float disc_over_horizon(float height, float radius) {
    float x = clamp(height / radius, -1.0, 1.0);
    return 0.5 + (x * sqrt(max(1.0 - x * x, 0.0)) + asin(x)) / pi;
}

// Elevation of the terrain's horizon towards a light, between the two azimuths around it (horizon mapping, Max 1988).
float horizon_elevation(uvec4 horizon, uvec4 sector, float weight) {
    uvec2 code = (uvec2(horizon[sector.x], horizon[sector.z]) >> sector.yw) & 255u;
    vec2 root = vec2(code) / 255.0;
    vec2 elevation = 0.5 * pi * root * root;
    return mix(elevation.x, elevation.y, weight);
}

float sun_visibility(uvec4 horizon) {
    return disc_over_horizon(frame.sector.z - horizon_elevation(horizon, frame.sun_sector, frame.sector.x),
                             frame.to_sun.w);
}

float moon_visibility(uvec4 horizon) {
    return disc_over_horizon(frame.sector.w - horizon_elevation(horizon, frame.moon_sector, frame.sector.y),
                             frame.to_moon.w);
}

float cloud_texel(int x, int y) {
    int at = (y % 112) * 112 + x % 112;
    return float((frame.cloud_shadow[at >> 4][(at >> 2) & 3] >> ((at & 3) << 3)) & 255u) / 255.0;
}

// Fractions of the light of sun and moon that clouds let through to a point given relative to the camera: of the
// stronger of the two alone. Mountains that stand in the clouds come out of their shadow with height.
vec2 cloud_visibility(vec3 relative_m) {
    vec3 at_m = relative_m + frame.camera_m.xyz;
    // Lavapipe compiles a shader anew each frame where a branch hangs on uniforms alone: this one asks for the point too.
    if (at_m.z >= frame.cloud_map.w) {
        return vec2(1.0);
    }
    vec2 texel = 112.0 * fract((at_m.xy + frame.cloud_key.xy * (frame.cloud_map.y - at_m.z)) * frame.cloud_map.x - frame.cloud_key.zw) + 111.5;
    ivec2 first = ivec2(texel);
    vec2 part = texel - vec2(first);
    float through = mix(mix(cloud_texel(first.x, first.y), cloud_texel(first.x + 1, first.y), part.x),
                        mix(cloud_texel(first.x, first.y + 1), cloud_texel(first.x + 1, first.y + 1), part.x), part.y);
    through = mix(through, 1.0, smoothstep(frame.cloud_map.z, frame.cloud_map.w, at_m.z));
    return frame.key.w > 0.5 ? vec2(1.0, through) : vec2(through, 1.0);
}

// Irradiance of sky and ground over pi (Ramamoorthi and Hanrahan 2001, eq. 11). The cut at order 3 can ring below zero.
vec3 sky_irradiance(vec3 normal) {
    vec4 n = vec4(normal, 1.0);
    return max(vec3(dot(n, frame.irradiance[0] * n), dot(n, frame.irradiance[1] * n), dot(n, frame.irradiance[2] * n)),
               0.0);
}

// Irradiance over pi of sun and moon, of which fractions are visible.
vec3 direct_irradiance(vec3 normal, float sun, float moon) {
    return frame.sun.rgb * (sun * max(dot(normal, frame.to_sun.xyz), 0.0)) +
           frame.moon.rgb * (moon * max(dot(normal, frame.to_moon.xyz), 0.0));
}

// (1 - e^-x) / x, by its series where the quotient would cancel.
float mean_falloff(float x) { return abs(x) < 1e-3 ? 1.0 - 0.5 * x : (1.0 - exp(-x)) / x; }

// Mean density of an exponential atmosphere between two heights, relative to sea level.
float mean_density(float from_m, float to_m, float per_m) {
    return exp(-from_m * per_m) * mean_falloff((to_m - from_m) * per_m);
}

// Transmittance of the air between the camera and a point of the world, given relative to the camera.
vec3 air_transmittance(vec3 relative_m) {
    float from_m = frame.camera_m.z;
    float to_m = from_m + relative_m.z;
    vec3 extinction = frame.rayleigh.rgb * mean_density(from_m, to_m, frame.rayleigh.w) +
                      frame.mie.rgb * mean_density(from_m, to_m, frame.mie.w);
    return exp(-extinction * length(relative_m));
}

// Of the visible fractions of sun and moon that of the light that makes the sky.
float sky_light_visibility(float sun, float moon) { return frame.haze.w > 0.5 ? moon : sun; }

// Radiance of air without end, of which the fraction `sunlit` stands in the light that makes the sky: the horizon's in
// that azimuth, so that far mountains fade into the sky behind them; air in the shadow of mountains lacks what the
// light's side of the sky has more than the side opposite. Air that still lets `clear` through has scattered light once: its colour is that of the
// light that enters it, redder at sunset than the horizon behind all air.
vec3 horizon_light(vec3 relative_m, float sunlit, float clear) {
    vec2 along = relative_m.xy * inversesqrt(max(dot(relative_m.xy, relative_m.xy), 1e-6));
    vec2 light = frame.haze.yz;
    float half_sine = sqrt(clamp(0.5 - 0.5 * dot(along, light), 0.0, 1.0));
    float at = 16.0 + 16.0 * (along.x * light.y < along.y * light.x ? -half_sine : half_sine);
    int first = min(int(at), 31);
    float part = at - float(first);
    vec3 far = mix(frame.horizon_light[first].rgb, frame.horizon_light[first + 1].rgb, part);
    vec3 near = mix(frame.near_light[first].rgb, frame.near_light[first + 1].rgb, part);
    vec3 lit = mix(far, near, clear);
    return mix(min(lit, frame.horizon_light[0].rgb), lit, sunlit);
}

// Light that the air between camera and surface adds, where it lets `transmittance` through. The air stands in the light
// as much as its two ends do.
vec3 air_light(vec3 relative_m, vec3 transmittance, float sun_at_surface) {
    return horizon_light(relative_m, 0.5 * (frame.haze.x + sun_at_surface), transmittance.g) * (1.0 - transmittance);
}

vec3 through_air(vec3 radiance, vec3 relative_m, float sun_at_surface) {
    vec3 transmittance = air_transmittance(relative_m);
    return radiance * transmittance + air_light(relative_m, transmittance, sun_at_surface);
}
