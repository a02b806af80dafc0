#version 450
#extension GL_GOOGLE_include_directive : require
// The clouds' picture, premultiplied, at the depth of the nearest cloud around: what stands in front of all of it hides
// it. Clouds behind the landscape are not in the picture.
#include "clouds_unpack.glsl"

layout(set = 1, binding = 0) uniform sampler2D picture;
layout(set = 2, binding = 0) uniform usampler2D marched;

layout(push_constant) uniform Push {
    vec4 image;
    vec2 projection;  // reversed depth = projection.x / depth - projection.y
    vec2 half_angles; // of the picture, their tangents
};

layout(location = 0) in vec2 at;
layout(location = 0) out vec4 target;

void main() {
    target = texture(picture, at);
    ivec2 last = textureSize(marched, 0) - 1;
    ivec2 middle = ivec2(at * vec2(last + 1));
    float nearest = 1e30;
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            vec2 cloud = unpack_cloud(texelFetch(marched, clamp(middle + ivec2(x, y), ivec2(0), last), 0).w);
            nearest = cloud.x > 0.0 ? min(nearest, cloud.y) : nearest;
        }
    }
    vec2 place = (2.0 * at - 1.0) * half_angles;
    float depth = max(0.98 * nearest * inversesqrt(1.0 + dot(place, place)), 2.0);
    gl_FragDepth = clamp(projection.x / depth - projection.y, 0.0, 1.0);
    if (target.a <= 1.0 / 512.0 || nearest > 1e29) {
        discard;
    }
}
