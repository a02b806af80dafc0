// Half a step of 8 bits to either side, against banding, from the pixel alone (Jimenez 2014, interleaved gradient noise).
float dither() {
    return (fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5) / 255.0;
}
