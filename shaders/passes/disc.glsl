// How much of the pixel a disc covers, from the distance to its centre in radii and the height over the horizon.
float disc_coverage(vec2 place, float radius_px, float over_horizon_px) {
    return clamp((1.0 - length(place)) * radius_px + 0.5, 0.0, 1.0) * clamp(over_horizon_px + 0.5, 0.0, 1.0);
}
