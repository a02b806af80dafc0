#version 450
// One rectangle of the HUD's picture, at the same place in the frame: a strip of four corners.
layout(push_constant) uniform Push {
    vec4 rectangle; // left, top, right, bottom in clip space
};

void main() {
    gl_Position = vec4((gl_VertexIndex & 1) == 0 ? rectangle.x : rectangle.z,
                       (gl_VertexIndex & 2) == 0 ? rectangle.y : rectangle.w, 0.0, 1.0);
}
