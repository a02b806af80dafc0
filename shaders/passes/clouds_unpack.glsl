// Of a texel of clouds_march.frag: what it hides and its mean distance, metres.
vec2 unpack_cloud(uint word) {
    vec2 packed_values = unpackUnorm2x16(word);
    return vec2(packed_values.x, packed_values.y * packed_values.y * 160000.0);
}
