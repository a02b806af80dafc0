#version 450
#extension GL_GOOGLE_include_directive : require
// The air in front of the clouds, and exposure; premultiplied. As cloud_image.cpp on the CPU.
#include "frame.glsl"
#include "light.glsl"
#include "clouds_picture.glsl"
#include "clouds_unpack.glsl"

layout(set = 0, binding = 4) uniform usampler2D marched;

layout(location = 0) out vec4 target;

vec4 shown(ivec2 texel) {
    uvec4 words = texelFetch(marched, texel, 0);
    vec2 cloud = unpack_cloud(words.w); // alpha, distance
    if (cloud.x < 1.0 / 512.0) {
        return vec4(0.0);
    }
    vec2 at = place_of(vec2(texel) + 0.5);
    vec3 relative_m = normalize(forward.xyz + at.x * right.xyz + at.y * up.xyz) * cloud.y;
    vec3 through = air_transmittance(relative_m);
    vec3 radiance = uintBitsToFloat(words.rgb) * (frame.sun.w * through) + air_light(relative_m, through, 1.0) * cloud.x;
    return vec4(min(radiance, vec3(6e4)), cloud.x);
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    target = shown(texel);
    float ground = landscape_m[texel.y * size.x + texel.x];
    bool inner = all(greaterThan(texel, ivec2(0))) && all(lessThan(texel, size - 1));
    if (target.a > 0.0 || ground > 1e29 || !inner) {
        return;
    }
    // Behind the landscape's outline texels take what their neighbours show, so that the screen's finer one has no seam.
    vec4 sum = vec4(0.0);
    float count = 0.0;
    for (int y = texel.y - 1; y <= texel.y + 1; ++y) {
        for (int x = texel.x - 1; x <= texel.x + 1; ++x) {
            if (landscape_m[y * size.x + x] > 1.02 * ground) {
                sum += shown(ivec2(x, y));
                count += 1.0;
            }
        }
    }
    target = count > 0.0 ? sum / count : target;
}
