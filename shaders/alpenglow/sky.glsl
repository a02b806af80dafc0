// What a game's shaders take from the sky module.
#ifndef ALPENGLOW_SKY_GLSL
#define ALPENGLOW_SKY_GLSL

#include "aerial_perspective.glsl"
#include "sky_view.glsl"

#endif
