// Clouds in a shader, from the same tables that the CPU marches (alpenglow/clouds/shader_tables.hpp): the same steps, the
// same light, the same picture to rounding. This file is GLSL and C++ at once: tests compile it as both.
//
// Before including, define
//   uint cloud_volume_word(uint index)   32-bit word of clouds::pack_volume: bricks, uploaded once
//   uint cloud_light_word(uint index)    32-bit word of clouds::pack_light: what was baked, and this eye's fields
#ifndef ALPENGLOW_CLOUD_GLSL
#define ALPENGLOW_CLOUD_GLSL

struct AlpenglowCloudRay {
    vec3 radiance;       // scattered towards the eye, without what lies behind
    float transmittance; // of what lies behind
    float depth;         // mean distance of what is seen, metres; 0: nothing
};

float alpenglow_cloud_light_float(uint index) {
    return uintBitsToFloat(cloud_light_word(index));
}

// Number of the brick at (bx, by, bz), -1: none, -2: nothing in the whole node of 8^3 bricks.
int alpenglow_cloud_brick(int bx, int by, int bz) {
    int nodes_x = int(cloud_volume_word(4u));
    int nodes_y = int(cloud_volume_word(5u));
    int node_at = ((bz >> 3) * nodes_y + (by >> 3)) * nodes_x + (bx >> 3);
    int node = int(cloud_volume_word(cloud_volume_word(0u) + uint(node_at)));
    if (node < 0) {
        return -2;
    }
    int place = ((bz & 7) << 6) + ((by & 7) << 3) + (bx & 7);
    return int(cloud_volume_word(cloud_volume_word(1u) + uint(node + place)));
}

float alpenglow_cloud_byte(uint base, uint at) {
    return float((cloud_volume_word(base + (at >> 2)) >> ((at & 3u) << 3)) & 255u);
}

// Trilinear density inside brick `brick` at p, in voxels from the volume's corner.
float alpenglow_cloud_density(int brick, vec3 p) {
    int ix = int(p.x);
    int iy = int(p.y);
    int iz = int(p.z);
    vec3 t = p - vec3(float(ix), float(iy), float(iz));
    uint base = cloud_volume_word(3u) + uint(brick) * 184u;
    uint at = uint((iz & 7) * 81 + (iy & 7) * 9 + (ix & 7));
    float a = mix(alpenglow_cloud_byte(base, at), alpenglow_cloud_byte(base, at + 1u), t.x);
    float b = mix(alpenglow_cloud_byte(base, at + 9u), alpenglow_cloud_byte(base, at + 10u), t.x);
    float c = mix(alpenglow_cloud_byte(base, at + 81u), alpenglow_cloud_byte(base, at + 82u), t.x);
    float d = mix(alpenglow_cloud_byte(base, at + 90u), alpenglow_cloud_byte(base, at + 91u), t.x);
    uint pair = cloud_volume_word(2u) + 2u * uint(brick);
    return mix(mix(a, b, t.y), mix(c, d, t.y), t.z) * uintBitsToFloat(cloud_volume_word(pair)) +
           uintBitsToFloat(cloud_volume_word(pair + 1u));
}

float alpenglow_cloud_half_word(uint base, int at) {
    return float((cloud_light_word(base + uint(at >> 1)) >> uint((at & 1) << 4)) & 65535u);
}

// Trilinear value of the field described at word `about`, at p in voxels from the volume's corner.
float alpenglow_cloud_field(uint about, vec3 p) {
    uint base = cloud_light_word(about);
    int nx = int(cloud_light_word(about + 1u));
    int ny = int(cloud_light_word(about + 2u));
    int nz = int(cloud_light_word(about + 3u));
    vec3 first = vec3(alpenglow_cloud_light_float(about + 4u), alpenglow_cloud_light_float(about + 5u),
                      alpenglow_cloud_light_float(about + 6u));
    vec3 q = (p - first) * alpenglow_cloud_light_float(about + 7u);
    q = clamp(q, vec3(0.0F), vec3(float(nx - 1), float(ny - 1), float(nz - 1)));
    int ix = min(int(q.x), nx - 2);
    int iy = min(int(q.y), ny - 2);
    int iz = min(int(q.z), nz - 2);
    vec3 t = q - vec3(float(ix), float(iy), float(iz));
    int at = (iz * ny + iy) * nx + ix;
    int sz = nx * ny;
    float a = mix(alpenglow_cloud_half_word(base, at), alpenglow_cloud_half_word(base, at + 1), t.x);
    float b = mix(alpenglow_cloud_half_word(base, at + nx), alpenglow_cloud_half_word(base, at + nx + 1), t.x);
    float c = mix(alpenglow_cloud_half_word(base, at + sz), alpenglow_cloud_half_word(base, at + sz + 1), t.x);
    float d = mix(alpenglow_cloud_half_word(base, at + sz + nx), alpenglow_cloud_half_word(base, at + sz + nx + 1), t.x);
    return mix(mix(a, b, t.y), mix(c, d, t.y), t.z) * alpenglow_cloud_light_float(about + 9u) +
           alpenglow_cloud_light_float(about + 8u);
}

// clouds::BeamTable: light towards the eye for a unit of irradiance, by optical depth and table coordinate of the angle.
float alpenglow_cloud_beam(float optical, float angle) {
    uint table = cloud_light_word(2u);
    float u = min(sqrt(max(optical * alpenglow_cloud_light_float(4u), 0.0F)), 1.0F) * 127.0F;
    int iu = min(int(u), 126);
    int ia = min(int(angle), 126);
    float tu = u - float(iu);
    float ta = angle - float(ia);
    uint at = table + uint(ia * 128 + iu);
    float near = mix(alpenglow_cloud_light_float(at), alpenglow_cloud_light_float(at + 1u), tu);
    float far = mix(alpenglow_cloud_light_float(at + 128u), alpenglow_cloud_light_float(at + 129u), tu);
    return mix(near, far, ta) * exp(max(-alpenglow_cloud_light_float(3u) * optical, -87.0F));
}

float alpenglow_cloud_asinh(float x) {
    return log(x + sqrt(x * x + 1.0F));
}

// Coordinate of the angle between ray and light; `difference` is to_light - direction, both unit.
float alpenglow_cloud_angle(vec3 difference) {
    float narrow = alpenglow_cloud_light_float(5u);
    float sine = sqrt(clamp(0.25F * dot(difference, difference), 0.0F, 1.0F));
    float angle = 2.0F * asin(sine);
    return clamp(alpenglow_cloud_asinh(angle / narrow) * 127.0F / alpenglow_cloud_asinh(3.14159265F / narrow), 0.0F, 127.0F);
}

// Front to back from `eye` (voxels from the volume's corner) along `direction` (unit, the grid's frame), `per_metre` the
// direction in voxels a metre, to t_end metres (opaque geometry). Word 12 on: descriptors of 16 words, lights first.
AlpenglowCloudRay alpenglow_cloud_march(vec3 eye, vec3 direction, vec3 per_metre, float t_end) {
    AlpenglowCloudRay ray;
    ray.radiance = vec3(0.0F);
    ray.transmittance = 1.0F;
    ray.depth = 0.0F;
    int lights = int(cloud_light_word(0u));
    int fields = int(cloud_light_word(1u));
    float extinction = alpenglow_cloud_light_float(6u);
    float step = alpenglow_cloud_light_float(8u);
    float stop = alpenglow_cloud_light_float(9u);
    bool riemann = cloud_light_word(10u) != 0u;
    vec3 low = vec3(uintBitsToFloat(cloud_volume_word(9u)), uintBitsToFloat(cloud_volume_word(10u)),
                    uintBitsToFloat(cloud_volume_word(11u)));
    vec3 high = vec3(uintBitsToFloat(cloud_volume_word(12u)), uintBitsToFloat(cloud_volume_word(13u)),
                     uintBitsToFloat(cloud_volume_word(14u)));
    vec3 size = vec3(float(cloud_volume_word(6u)), float(cloud_volume_word(7u)), float(cloud_volume_word(8u))) - vec3(1e-3F);
    vec3 held = vec3(abs(per_metre.x) < 1e-12F ? 1e-12F : per_metre.x, abs(per_metre.y) < 1e-12F ? 1e-12F : per_metre.y,
                     abs(per_metre.z) < 1e-12F ? 1e-12F : per_metre.z);
    vec3 inverse = vec3(1.0F) / held;
    vec3 u = (low - eye) * inverse;
    vec3 v = (high - eye) * inverse;
    vec3 enter = min(u, v);
    vec3 leave = max(u, v);
    float t0 = max(max(enter.x, max(enter.y, enter.z)), 0.0F);
    float t1 = min(min(leave.x, min(leave.y, leave.z)), t_end);
    float weight = 0.0F;
    if (!(t0 < t1)) {
        return ray;
    }
    // Steps are counted from the eye, distances from the step that enters the box.
    float base = floor(t0 / step) * step;
    eye += per_metre * base;
    t0 -= base;
    t1 -= base;
    float k = 0.0F;
    for (int guard = 0; guard < 65536; ++guard) {
        float from = max(k * step, t0);
        float to = min((k + 1.0F) * step, t1);
        if (!(from < t1) || ray.transmittance <= stop) {
            break;
        }
        float t = 0.5F * (from + to);
        vec3 p = clamp(eye + per_metre * t, vec3(0.0F), size);
        int brick = alpenglow_cloud_brick(int(p.x) >> 3, int(p.y) >> 3, int(p.z) >> 3);
        if (brick < 0) {
            // Leave the empty brick, or node, at once.
            float extent = brick == -2 ? 64.0F : 8.0F;
            vec3 corner = floor(p / extent) * extent;
            vec3 far = (corner + vec3(per_metre.x > 0.0F ? extent : 0.0F, per_metre.y > 0.0F ? extent : 0.0F,
                                      per_metre.z > 0.0F ? extent : 0.0F) -
                        eye) *
                       inverse;
            k = max(k + 1.0F, ceil(min(far.x, min(far.y, far.z)) / step - 0.5F));
            continue;
        }
        k += 1.0F;
        float tau = extinction * alpenglow_cloud_density(brick, p) * max(to - from, 0.0F);
        if (tau <= 0.0F) {
            continue;
        }
        float e = exp(-min(tau, 87.0F));
        float opacity = tau < 1e-2F ? tau * (1.0F + tau * (tau / 6.0F - 0.5F)) : 1.0F - e;
        vec3 source = vec3(0.0F);
        for (int i = 0; i < lights; ++i) {
            uint about = 12u + 16u * uint(i);
            vec3 to_light = vec3(alpenglow_cloud_light_float(about + 10u), alpenglow_cloud_light_float(about + 11u),
                                 alpenglow_cloud_light_float(about + 12u));
            vec3 irradiance = vec3(alpenglow_cloud_light_float(about + 13u), alpenglow_cloud_light_float(about + 14u),
                                   alpenglow_cloud_light_float(about + 15u));
            source += irradiance * (alpenglow_cloud_light_float(7u) * alpenglow_cloud_beam(alpenglow_cloud_field(about, p),
                                                                                          alpenglow_cloud_angle(to_light - direction)));
        }
        for (int i = 0; i < fields; ++i) {
            uint about = 12u + 16u * uint(lights + i);
            vec3 colour = vec3(alpenglow_cloud_light_float(about + 13u), alpenglow_cloud_light_float(about + 14u),
                               alpenglow_cloud_light_float(about + 15u));
            source += colour * alpenglow_cloud_field(about, p);
        }
        ray.radiance += source * (ray.transmittance * (riemann ? tau : opacity));
        ray.depth += ray.transmittance * opacity * t;
        weight += ray.transmittance * opacity;
        ray.transmittance *= e;
    }
    if (ray.transmittance <= stop) {
        ray.radiance /= 1.0F - ray.transmittance;
        ray.transmittance = 0.0F;
    }
    ray.radiance = max(ray.radiance, vec3(0.0F));
    ray.depth = weight > 0.0F ? base + ray.depth / weight : 0.0F;
    return ray;
}

#endif
