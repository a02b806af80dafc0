#version 450
// The HUD's picture, premultiplied, pixel by pixel.
layout(set = 0, binding = 0) uniform sampler2D hud;
layout(location = 0) out vec4 target;

void main() { target = texelFetch(hud, ivec2(gl_FragCoord.xy), 0); }
