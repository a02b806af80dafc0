// Clouds in a shader, from the same tables that the CPU marches (alpenglow/clouds/shader_tables.hpp): the same steps, the
// same light, the same picture to rounding. This file is GLSL and C++ at once: tests compile it as both.
//
// Before including, define
//   uint cloud_volume_word(uint index)   32-bit word of clouds::pack_volume: bricks, uploaded once
//   uint cloud_light_word(uint index)    32-bit word of clouds::pack_light: what was baked
//   uint cloud_view_word(uint index)     32-bit word of clouds::pack_view: this eye's fields, and how to march
//   uint cloud_detail_word(uint index)   32-bit word of clouds::pack_detail; not asked for where pack_view had no detail
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

float alpenglow_cloud_view_float(uint index) {
    return uintBitsToFloat(cloud_view_word(index));
}

// Fields are described and stored among the words of the light or of the view.
uint alpenglow_cloud_field_word(bool of_view, uint index) {
    if (of_view) {
        return cloud_view_word(index);
    }
    return cloud_light_word(index);
}

float alpenglow_cloud_half_word(bool of_view, uint base, int at) {
    return float((alpenglow_cloud_field_word(of_view, base + uint(at >> 1)) >> uint((at & 1) << 4)) & 65535u);
}

vec3 alpenglow_cloud_field_vector(bool of_view, uint index) {
    return vec3(uintBitsToFloat(alpenglow_cloud_field_word(of_view, index)),
                uintBitsToFloat(alpenglow_cloud_field_word(of_view, index + 1u)),
                uintBitsToFloat(alpenglow_cloud_field_word(of_view, index + 2u)));
}

// Trilinear value of the field described at word `about`, at p in voxels from the volume's corner.
float alpenglow_cloud_field(bool of_view, uint about, vec3 p) {
    uint base = alpenglow_cloud_field_word(of_view, about);
    int nx = int(alpenglow_cloud_field_word(of_view, about + 1u));
    int ny = int(alpenglow_cloud_field_word(of_view, about + 2u));
    int nz = int(alpenglow_cloud_field_word(of_view, about + 3u));
    vec3 scale = alpenglow_cloud_field_vector(of_view, about + 7u); // cells a voxel, value of 0, value of a step
    vec3 q = (p - alpenglow_cloud_field_vector(of_view, about + 4u)) * scale.x;
    q = clamp(q, vec3(0.0F), vec3(float(nx - 1), float(ny - 1), float(nz - 1)));
    int ix = min(int(q.x), nx - 2);
    int iy = min(int(q.y), ny - 2);
    int iz = min(int(q.z), nz - 2);
    vec3 t = q - vec3(float(ix), float(iy), float(iz));
    int at = (iz * ny + iy) * nx + ix;
    float a = mix(alpenglow_cloud_half_word(of_view, base, at), alpenglow_cloud_half_word(of_view, base, at + 1), t.x);
    float b = mix(alpenglow_cloud_half_word(of_view, base, at + nx),
                  alpenglow_cloud_half_word(of_view, base, at + nx + 1), t.x);
    at += nx * ny;
    float c = mix(alpenglow_cloud_half_word(of_view, base, at), alpenglow_cloud_half_word(of_view, base, at + 1), t.x);
    float d = mix(alpenglow_cloud_half_word(of_view, base, at + nx),
                  alpenglow_cloud_half_word(of_view, base, at + nx + 1), t.x);
    return mix(mix(a, b, t.y), mix(c, d, t.y), t.z) * scale.z + scale.y;
}

float alpenglow_cloud_detail_byte(int at) {
    return float((cloud_detail_word(uint(at >> 2)) >> uint((at & 3) << 3)) & 255u);
}

// clouds::DetailTexture::sample(), one copy: -1 .. 1 at cells >= 0.
float alpenglow_cloud_detail_copy(vec3 cell) {
    int ix = int(cell.x);
    int iy = int(cell.y);
    int iz = int(cell.z);
    vec3 t = cell - vec3(float(ix), float(iy), float(iz));
    int at = ((iz & 63) * 65 + (iy & 63)) * 65 + (ix & 63);
    float a = mix(alpenglow_cloud_detail_byte(at), alpenglow_cloud_detail_byte(at + 1), t.x);
    float b = mix(alpenglow_cloud_detail_byte(at + 65), alpenglow_cloud_detail_byte(at + 66), t.x);
    at += 65 * 65;
    float c = mix(alpenglow_cloud_detail_byte(at), alpenglow_cloud_detail_byte(at + 1), t.x);
    float d = mix(alpenglow_cloud_detail_byte(at + 65), alpenglow_cloud_detail_byte(at + 66), t.x);
    return mix(mix(a, b, t.y), mix(c, d, t.y), t.z) * (2.0F / 255.0F) - 1.0F;
}

// What detail makes of a density at p, in voxels from the volume's corner: clouds::detailed_density().
float alpenglow_cloud_detailed(float density, float strength, vec3 p) {
    vec3 cell = p * alpenglow_cloud_view_float(6u);
    float noise = alpenglow_cloud_detail_copy(cell + vec3(alpenglow_cloud_view_float(9u), alpenglow_cloud_view_float(10u),
                                                          alpenglow_cloud_view_float(11u)));
    if (cloud_view_word(8u) != 0u) { // drifting: two copies pass through each other
        vec3 turned = vec3(cell.y, cell.z, cell.x) + vec3(alpenglow_cloud_view_float(12u), alpenglow_cloud_view_float(13u),
                                                          alpenglow_cloud_view_float(14u));
        noise = (noise + alpenglow_cloud_detail_copy(turned)) * 0.70710678F;
    }
    return density * max(1.0F + strength * (1.0F - density * alpenglow_cloud_view_float(7u)) * noise, 0.0F);
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
// direction in voxels a metre, to t_end metres (opaque geometry). Descriptors of 16 words: of the light's depths from its
// word 12 on, of the view's fields from its word 16 on.
AlpenglowCloudRay alpenglow_cloud_march(vec3 eye, vec3 direction, vec3 per_metre, float t_end) {
    AlpenglowCloudRay ray;
    ray.radiance = vec3(0.0F);
    ray.transmittance = 1.0F;
    ray.depth = 0.0F;
    int lights = int(cloud_light_word(0u));
    int fields = int(cloud_view_word(0u));
    float extinction = alpenglow_cloud_light_float(6u);
    float step = alpenglow_cloud_view_float(1u);
    float stop = alpenglow_cloud_view_float(2u);
    bool riemann = cloud_view_word(3u) != 0u;
    float optical_step = alpenglow_cloud_view_float(4u);
    float detail = alpenglow_cloud_view_float(5u);
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
    float width = 1.0F; // steps this sample stands for
    for (int guard = 0; guard < 65536; ++guard) {
        float from = max(k * step, t0);
        float to = min((k + width) * step, t1);
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
            k = max(k + width, ceil(min(far.x, min(far.y, far.z)) / step - 0.5F));
            width = 1.0F;
            continue;
        }
        k += width;
        width = 1.0F;
        float density = alpenglow_cloud_density(brick, p);
        if (detail > 0.0F && density > 0.0F) {
            density = alpenglow_cloud_detailed(density, detail, p);
        }
        float tau = extinction * density * max(to - from, 0.0F);
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
            source += irradiance * (alpenglow_cloud_light_float(7u) *
                                    alpenglow_cloud_beam(alpenglow_cloud_field(false, about, p),
                                                         alpenglow_cloud_angle(to_light - direction)));
        }
        for (int i = 0; i < fields; ++i) {
            uint about = 16u + 16u * uint(i);
            source += alpenglow_cloud_field_vector(true, about + 13u) * alpenglow_cloud_field(true, about, p);
        }
        ray.radiance += source * (ray.transmittance * (riemann ? tau : opacity));
        ray.depth += ray.transmittance * opacity * t;
        weight += ray.transmittance * opacity;
        ray.transmittance *= e;
        if (optical_step > 0.0F) {
            // The less is still seen, the more optical depth a step may span.
            float allowed = optical_step * (1.0F - ray.transmittance) / max(ray.transmittance, 1e-3F);
            width = clamp(floor(allowed / max(extinction * density * step, 0.05F)), 1.0F, 4.0F);
        }
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
