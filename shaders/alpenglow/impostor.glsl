// Drawing impostors: what modules/impostors/src/reproject.cpp does, for one layer and one pixel. Include it in a fragment
// shader; docs/impostors.md has the equations. All light is premultiplied.

// A capture and a view as one: filled by the CPU for each draw.
struct ImpostorView {
    vec3 eye;        // of the view, in the capture's axes (right, up, forward), metres from its eye
    vec2 tan_least;  // tan_left, tan_top of the capture's window
    vec2 texels;     // texels a tangent: x, and -y
    vec2 size;       // of the picture, texels
    float depth_origin; // metres: s = (axis depth - origin) / scale
    float depth_scale;
};

// Where the ray `v` (in the capture's axes, any length) sees what the capture has at inverse axis depth w, in texels from the
// upper left. `epipole` is how far that moves for a unit of w: linear.
vec2 impostor_texel(ImpostorView i, vec3 v, float w, out vec2 epipole) {
    vec2 a = v.xy / v.z;
    epipole = (i.eye.xy - i.eye.z * a) * i.texels;
    return (a - i.tan_least) * i.texels + epipole * w;
}

// True where axis depth 1 / w lies in front of the view's eye along v.
bool impostor_ahead(ImpostorView i, vec3 v, float w) { return (1.0 / w - i.eye.z) * v.z > 0.0; }

// Warped kinds: the inverse depth of the surface where the ray is at inverse depth w. `warp` holds s in x, continued past
// the rim; origin: of the tile in the atlas, texels.
float impostor_surface(ImpostorView i, sampler2D warp, vec2 origin, vec2 atlas_texel, vec3 v, float w, float near_m, float far_m) {
    vec2 epipole;
    vec2 t = clamp(impostor_texel(i, v, w, epipole), vec2(0.5), i.size - 0.5);
    float s = textureLod(warp, (origin + t) * atlas_texel, 0.0).x;
    return 1.0 / clamp(i.depth_origin + i.depth_scale * s, near_m, far_m);
}

// The inverse depth of the texel that its own depth puts on this ray, by fixed point from w: where the warp moves texels
// by less than two.
float impostor_warp(ImpostorView i, sampler2D warp, vec2 origin, vec2 atlas_texel, vec3 v, float w, float near_m, float far_m) {
    for (int step = 0; step < 3; ++step) {
        w = impostor_surface(i, warp, origin, atlas_texel, v, w, near_m, far_m);
    }
    return w;
}

// The same where it moves them further: the first crossing of ray and surface, in steps from the front of the slab to its
// back (one for every 3.5 texels, at most eight), then two of regula falsi.
float impostor_search(ImpostorView i, sampler2D warp, vec2 origin, vec2 atlas_texel, vec3 v, int steps, float near_m, float far_m) {
    float front = 1.0 / near_m;
    float back = 1.0 / far_m;
    vec2 last = vec2(front, impostor_surface(i, warp, origin, atlas_texel, v, front, near_m, far_m) - front);
    vec2 next = last; // inverse depth, and how much nearer the surface is
    for (int k = 1; k <= steps && next.y < 0.0; ++k) {
        last = next;
        float w = mix(front, back, float(k) / float(steps));
        next = vec2(w, impostor_surface(i, warp, origin, atlas_texel, v, w, near_m, far_m) - w);
    }
    float w = next.y > last.y ? mix(last.x, next.x, last.y / (last.y - next.y)) : next.x;
    vec2 between = vec2(w, impostor_surface(i, warp, origin, atlas_texel, v, w, near_m, far_m) - w);
    if (between.y < 0.0) {
        last = between;
    } else {
        next = between;
    }
    return next.y > last.y ? mix(last.x, next.x, last.y / (last.y - next.y)) : next.x;
}

// One texel of a layer, lit: key and fill radiance with the factors that make good a change of their colours since capture.
vec4 impostor_fetch(sampler2D key, sampler2D fill, vec2 size, vec2 origin, vec2 atlas_texel, vec2 t, vec3 key_gain, vec3 fill_gain) {
    if (any(lessThan(t, vec2(0.0))) || any(greaterThan(t, size))) {
        return vec4(0.0);
    }
    vec2 uv = (origin + clamp(t, vec2(0.5), size - 0.5)) * atlas_texel;
    vec4 c = texture(key, uv);
    return vec4(c.rgb * key_gain + texture(fill, uv).rgb * fill_gain, c.a);
}

// The share of a texel's optical depth in front of s: alpha times the mean of s and of s^2 are `moments`.
float impostor_share_in_front(float alpha, vec2 moments, float s) {
    if (alpha <= 1e-6) {
        return moments.x <= s * alpha ? 1.0 : 0.0;
    }
    float mean = moments.x / alpha;
    float half_width = sqrt(3.0 * max(0.0, moments.y / alpha - mean * mean));
    return half_width < 1e-6 ? (mean <= s ? 1.0 : 0.0) : clamp(0.5 + 0.5 * (s - mean) / half_width, 0.0, 1.0);
}

// The part of a texel's light that `share` of its optical depth leaves: soft intersections and slices.
vec4 impostor_part(vec4 c, float share) {
    if (c.a <= 0.0 || share >= 1.0) {
        return c;
    }
    float left = c.a < 1.0 ? 1.0 - pow(1.0 - c.a, share) : (share > 0.0 ? 1.0 : 0.0);
    return c * (left / c.a);
}

// Front to back: sum + what the sum lets through of `behind`.
vec4 impostor_under(vec4 sum, vec4 behind) { return sum + (1.0 - sum.a) * behind; }
