// What every pass of a frame reads: one uniform block, read by GLSL and by C++ alike, so made of vec4, uvec4 and mat4
// alone (std140 then has no padding). All light is multiplied by the frame's exposure beforehand.
struct FrameBlock {
    mat4 clip_from_relative;  // from world directions relative to the camera; reversed depth: 1 near, 0 far
    mat4 shadow_from_relative; // to the shadow map's clip space, reversed depth; full quality alone
    mat4 irradiance[3];       // n^T M n for R, G, B with n = (x, y, z, 1): light of sky and ground, over pi
    vec4 camera_m;            // xyz: the camera in the world; w: pixels per radian
    vec4 to_sun;              // xyz; w: angular radius of the disc
    vec4 to_moon;             // likewise
    vec4 sun;                 // rgb: illuminance over pi on a surface that faces the sun; w: exposure
    vec4 moon;                // rgb: likewise
    vec4 key;                 // xyz: direction of the stronger of the two, which throws the shadows; w: 1 for the moon
    vec4 sun_disc;            // rgb: radiance of the disc
    vec4 moon_disc;           // rgb: radiance of the moon where the sun stands overhead
    vec4 moon_sky;            // rgb: radiance of the sky in front of the moon
    vec4 rayleigh;            // rgb: extinction at sea level, per metre; w: 1 / scale height
    vec4 mie;                 // likewise
    vec4 haze;                // x: fraction of the disc of the light that makes the sky that the terrain leaves visible at
                              // the camera; yz: that light's azimuth, a unit vector; w: 1 where it is the moon
    vec4 discs;               // x, y: height over width of sun and moon; z: elevation of the horizon
    vec4 sector;              // weights of the second azimuth for sun and moon, elevations of sun and moon
    uvec4 sun_sector;         // where the horizon towards the sun stands: word and shift of the two nearest azimuths
    uvec4 moon_sector;        // likewise
    vec4 near_light[33];      // rgb: colour of light that a thin layer of air scatters, at the brightness of horizon_light
    vec4 horizon_light[33];   // rgb: radiance of the sky at the horizon, entry i at sin(azimuth / 2) = i / 16 - 1, the
                              // azimuth that from the light of `haze`, clockwise
    vec4 cloud_map;           // the map of the clouds' shadow. x: 1 / its side; y: its height; z, w: bottom and top of the
                              // clouds, -1e30 where no map is
    vec4 cloud_key;           // xy: way east and north a metre up towards the light; zw: the map's corner, in sides
    uvec4 cloud_shadow[784];  // 112 x 112 bytes: transmittance of the key light
};
