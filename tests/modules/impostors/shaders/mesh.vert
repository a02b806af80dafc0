#version 450
// A mesh for a picture: positions relative to the eye.

layout(push_constant) uniform Draw {
    mat4 clip_from_eye;
    vec4 eye;
    vec4 to_key;
};
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 at;
layout(location = 1) out vec3 across;

void main() {
    at = position;
    across = normal;
    gl_Position = clip_from_eye * vec4(position - eye.xyz, 1.0);
}
