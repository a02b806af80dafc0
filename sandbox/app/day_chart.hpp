// Illuminance against time: sun, sky and moon over one day.
#pragma once

#include <vector>

#include <alpenglow/components/observer.hpp>
#include <alpenglow/components/sky.hpp>

#include "sandbox/app/canvas.hpp"

namespace alpenglow::sandbox {

struct DaySample {
    double utc_j2000_s = 0.0;
    float sun_lux = 0.0F, sky_lux = 0.0F, moon_lux = 0.0F; // on level ground
    float sun_altitude_rad = 0.0F;                         // geometric
};

// From one midnight of local mean time to the next around that moment, evenly; `count` at least 2. The sky's share of
// SkyModel::scattering is that at sea level with 0.35 atm cm of ozone, for which no table is built: 10 % less light at
// 700 m is a tenth of a line's width in the plot. Empty where date or place are out of the ephemeris' range. A build
// without the module ephemeris has none.
[[nodiscard]] std::vector<DaySample> day_light(const Observer& observer, const Atmosphere& atmosphere,
                                               double utc_j2000_s, int count);

// Where a sample stands in the picture that paint_day_chart() makes.
struct DayAxes {
    int left = 46, right = 0, top = 22, bottom = 0;
    static constexpr float lowest_log = -4.0F, highest_log = 5.5F;
    explicit DayAxes(int width_px, int height_px) : right(width_px - 12), bottom(height_px - 20) {}
    [[nodiscard]] float x(double part_of_day) const;
    [[nodiscard]] float y(float lux) const; // held within the axes
};

// The plot with the time `utc_j2000_s` marked. Colours behind it: day, civil, nautical, astronomical twilight, night.
[[nodiscard]] Canvas paint_day_chart(const std::vector<DaySample>& day, double utc_j2000_s, int width_px,
                                     int height_px);

} // namespace alpenglow::sandbox
