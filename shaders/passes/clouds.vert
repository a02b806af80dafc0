#version 450
// Tiles of the clouds' picture, where they stand on the screen.

layout(location = 0) in vec3 place; // clip space, w = 1; z: reversed depth of the tile's nearest cloud

layout(push_constant) uniform Push {
    vec4 image; // image coordinates = image.xy * place + image.zw
};

layout(location = 0) out vec2 at;

void main() {
    gl_Position = vec4(place, 1.0);
    at = image.xy * place.xy + image.zw;
}
