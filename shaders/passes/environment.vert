#version 450
// A triangle over the whole picture, infinitely far, and the direction that each pixel looks in.
layout(push_constant) uniform Push {
    mat4 direction_from_clip;
    float scale;
    float azimuth_rad;
};
layout(location = 0) out vec3 direction;

void main() {
    vec2 corner = vec2(float((gl_VertexIndex << 1) & 2), float(gl_VertexIndex & 2)) * 2.0 - 1.0;
    gl_Position = vec4(corner, 0.0, 1.0);
    direction = mat3(direction_from_clip) * vec3(corner, 1.0);
}
