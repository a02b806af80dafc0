// What transfer_lit.vert reads of a body beside its tables: one storage block, read by GLSL and by C++ alike, so made of
// vec4 and uvec4 alone.
struct TransferBlock {
    uvec4 diffuse;          // rows (0: no table), channels, coefficients, how many of them the light has
    uvec4 glossy;           // likewise
    uvec4 words;            // x: first word of the glossy blocks; y: vertices with gloss, from the first
    vec4 specular;          // rgb: reflectance of the lobe
    vec4 kernel[2];         // of the lobe, by band
    vec4 diffuse_light[36]; // rgb: cd/m^2
    vec4 glossy_light[36];
};
