#version 450
// A painted, matt surface under one light: premultiplied radiance and alpha.

layout(push_constant) uniform Draw {
    mat4 clip_from_eye;
    vec4 eye;
    vec4 to_key;
};
layout(location = 0) in vec3 at;
layout(location = 1) in vec3 across;
layout(location = 0) out vec4 target;

void main() {
    vec3 paint = 0.5 + 0.4 * sin(vec3(17.0, 13.0, 11.0) * at.yzx);
    target = vec4(paint * (0.15 + max(0.0, dot(normalize(across), to_key.xyz))), 1.0);
}
