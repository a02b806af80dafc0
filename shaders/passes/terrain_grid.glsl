// The terrain's grid as an image, a texel a vertex of the finest terrain: rg: x and y of the normal, (n + 1) / 2; b: square
// root of the albedo's luminance; a: sky visibility. The triangles may be much coarser.
const vec3 luminance_weights = vec3(0.2126, 0.7152, 0.0722);

struct Ground {
    vec3 normal;
    float luminance; // of the albedo
    float ambient;
};

Ground ground_from_texel(vec4 texel) {
    Ground g;
    vec2 xy = 2.0 * texel.rg - 1.0;
    g.normal = vec3(xy, sqrt(max(1.0 - dot(xy, xy), 0.0)));
    g.luminance = texel.b * texel.b;
    g.ambient = texel.a;
    return g;
}

// An albedo's colour, of luminance 1.
vec3 chroma_of(vec3 albedo) { return albedo / max(dot(albedo, luminance_weights), 1e-3); }
