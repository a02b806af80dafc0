#version 450
// A picture of a cloud: one fetch, two where it takes over from another. Premultiplied.
layout(constant_id = 1) const int kind = 0; // as ImpostorRun::Kind

layout(set = 1, binding = 0) uniform sampler2D atlas;
layout(location = 0) in vec4 places;
layout(location = 1) in vec3 shares;
layout(location = 2) in vec3 clear;
layout(location = 3) in vec3 air;
layout(location = 0) out vec4 target;

void main() {
    vec4 c = textureLod(atlas, places.xy, 0.0);
    if (kind == 1) {
        c = shares.x * c + shares.y * textureLod(atlas, places.zw, 0.0);
    }
    if (kind == 2) { // 1 - (1 - alpha)^share, and light in proportion
        float left = 1.0 - pow(max(1.0 - c.a, 1e-4), shares.z);
        c *= shares.x * left / max(c.a, 1e-4);
    }
    target = vec4(c.rgb * clear + c.a * air, c.a);
}
