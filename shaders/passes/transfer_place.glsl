// Where a body stands. Needs frame.glsl.
layout(push_constant) uniform Place {
    vec4 turn;     // quaternion, xyz and w: world from body
    vec4 position; // xyz, in the world
} place;

vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }

vec3 relative_to_camera(vec3 position_m) {
    return turned(place.turn, position_m) + (place.position.xyz - frame.camera_m.xyz);
}
