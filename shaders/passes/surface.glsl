// Vertex inputs of terrain and objects. Needs frame.glsl.

layout(constant_id = 0) const bool instanced = false; // objects; the terrain is one piece, in world coordinates

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 vertex_normal;
layout(location = 2) in vec4 vertex_albedo; // rgb: square roots of reflectance; a: sky visibility
layout(location = 3) in uvec4 vertex_horizon;
layout(location = 4) in vec4 world_row_x; // rows of world_from_object
layout(location = 5) in vec4 world_row_y;
layout(location = 6) in vec4 world_row_z;
layout(location = 7) in uvec4 instance_horizon;

struct Surface {
    vec3 relative_m; // to the camera
    vec3 normal;
    vec3 albedo;
    float ambient;
    uvec4 horizon;
};

Surface read_surface() {
    Surface s;
    if (instanced) {
        vec4 p = vec4(position_m, 1.0);
        s.relative_m = vec3(dot(world_row_x, p), dot(world_row_y, p), dot(world_row_z, p)) - frame.camera_m.xyz;
        vec3 n = vertex_normal.xyz;
        s.normal = normalize(vec3(dot(world_row_x.xyz, n), dot(world_row_y.xyz, n), dot(world_row_z.xyz, n)));
        s.horizon = instance_horizon;
    } else {
        s.relative_m = position_m - frame.camera_m.xyz;
        s.normal = normalize(vertex_normal.xyz);
        s.horizon = vertex_horizon;
    }
    s.albedo = vertex_albedo.rgb * vertex_albedo.rgb;
    s.ambient = vertex_albedo.a;
    return s;
}
