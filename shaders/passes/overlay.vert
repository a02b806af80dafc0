#version 450
// A rectangle of the frame: a strip of four corners.
layout(push_constant) uniform Push {
    vec4 rectangle; // left, top, right, bottom in clip space
};
layout(location = 0) out vec2 place;

void main() {
    place = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(mix(rectangle.xy, rectangle.zw, place), 0.0, 1.0);
}
