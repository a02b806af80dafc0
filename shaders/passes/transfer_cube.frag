#version 450
layout(location = 0) flat in float triangle;
layout(location = 0) out float target;

void main() { target = triangle; }
