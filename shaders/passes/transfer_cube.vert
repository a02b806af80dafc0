#version 450
// Triangles around an eye, on one face of a cube map. Three vertices a triangle, none shared.
layout(push_constant) uniform Eye {
    vec4 position; // xyz, metres; w: near plane, metres
    ivec4 face;    // x: axis; y: 1 or -1
} eye;

layout(location = 0) in vec3 position_m;
layout(location = 0) flat out float triangle; // number + 1: whole numbers up to 2^24 are exact

void main() {
    vec3 relative = position_m - eye.position.xyz;
    int axis = eye.face.x;
    float away = relative[axis] * float(eye.face.y);
    // Reversed depth: near / away, 1 at the near plane, 0 far away.
    gl_Position = vec4(relative[(axis + 1) % 3], relative[(axis + 2) % 3], eye.position.w, away);
    triangle = float(gl_VertexIndex / 3 + 1);
}
