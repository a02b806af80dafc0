// A right triangle over the upper left half of the target: (-1,-1), (1,-1), (-1,1) in clip space.
vec2 corner(int index) { return vec2(index == 1 ? 1.0 : -1.0, index == 2 ? 1.0 : -1.0); }
