// Inputs: where and when the scene is.
#pragma once

#include <limits>

namespace alpenglow {

// A place on the Earth (WGS84).
struct Observer {
    double latitude_rad = 0.0;   // geodetic, north positive, -pi/2 .. pi/2
    double longitude_rad = 0.0;  // east positive
    double height_m = 0.0;       // above the ellipsoid
    double max_error_rad = 1e-5; // directions are recomputed before they could be off by more than this
};

// An instant of UTC, and how fast the game's time runs.
struct WorldClock {
    double utc_j2000_s = 0.0; // seconds since 2000-01-01T12:00:00 UTC, every day 86400 s long
    double rate = 1.0;        // game seconds per real second; whoever drives the clock applies it
    double delta_t_s = std::numeric_limits<double>::quiet_NaN(); // TT - UT; NaN: from the built-in model
};

} // namespace alpenglow
