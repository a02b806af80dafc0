#version 450
// One triangle over the screen, and where it lies on the clouds' picture.

layout(push_constant) uniform Push {
    vec4 image; // image coordinates = image.xy * place + image.zw
    vec2 projection;
    vec2 half_angles;
};

layout(location = 0) out vec2 at;

void main() {
    vec2 place = vec2((gl_VertexIndex & 1) * 4 - 1, (gl_VertexIndex & 2) * 2 - 1);
    gl_Position = vec4(place, 0.0, 1.0);
    at = image.xy * place + image.zw;
}
