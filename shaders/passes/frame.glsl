// The frame's uniform block.
#include "frame_block.h"

layout(set = 0, binding = 0, std140) uniform Frame { FrameBlock frame; };

const float pi = 3.14159265358979;
