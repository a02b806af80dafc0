// The terrain's grid as an image, a texel a vertex of the finest terrain: rg: x and y of the normal as signed bytes
// plus 128; b: square
// root of the albedo's luminance; a: sky visibility. The triangles may be much coarser.
const vec3 luminance_weights = vec3(0.2126, 0.7152, 0.0722);

struct Ground {
    vec3 normal;
    float luminance; // of the albedo
    float ambient;
};

Ground ground_from_texel(vec4 texel) {
    Ground g;
    vec2 xy = (255.0 * texel.rg - 128.0) / 127.0;
    g.normal = vec3(xy, sqrt(max(1.0 - dot(xy, xy), 0.0)));
    g.luminance = texel.b * texel.b;
    g.ambient = texel.a;
    return g;
}

// An albedo's colour, of luminance 1.
vec3 chroma_of(vec3 albedo) { return albedo / max(dot(albedo, luminance_weights), 1e-3); }

// The colour of ground whose triangle has the colour `chroma`, of luminance 1, and the luminance `coarse`, where the finer
// image says `fine`: what is brighter than the triangle is rock, scree or snow that it does not know, and those are grey.
// Without this they would take the green of the meadows around them.
vec3 ground_tint(vec3 chroma, float coarse, float fine) {
    return mix(chroma, vec3(1.0), clamp(1.0 - coarse / max(fine, 1e-3), 0.0, 1.0));
}

// The ground's grain from a tile of noise: rg: slope, b: noise, both 0 .. 1 with mean 1/2. Steep ground is rocky: there the
// slopes count. The normal is not made unit again, so that the light's mean over the ground stays what it was.
Ground with_detail(Ground g, vec3 detail) {
    vec3 d = 2.0 * detail - 1.0;
    g.normal.xy -= clamp(3.88 - 4.0 * g.normal.z, 0.12, 1.0) * d.xy;
    g.luminance *= max(1.0 + 0.6 * d.z, 0.0);
    return g;
}
