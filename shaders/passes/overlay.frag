#version 450
// A picture over the frame, premultiplied, pixel by pixel.
layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 place; // 0 .. 1 from the upper left corner
layout(location = 0) out vec4 target;

void main() { target = texelFetch(picture, ivec2(place * vec2(textureSize(picture, 0))), 0); }
