// The sky beside what spherical harmonics make of it: four fisheye discs.
#pragma once

#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/components/sky.hpp>

#include "sandbox/app/canvas.hpp"
#include "sandbox/scene/chart_settings.hpp"

namespace alpenglow::sandbox {

// Zenith angle at the rim of a disc: 20 degrees below the horizon, where a sky on SH rings.
inline constexpr float chart_rim_rad = 1.9198622F;

// Direction at a place on a disc, in radii from its middle, x right and y up: the zenith in the middle, north up and
// east left, as one sees the sky lying on the back; zenith angles grow evenly towards the rim.
[[nodiscard]] glm::vec3 chart_direction(glm::vec2 place);
[[nodiscard]] glm::vec2 chart_place(glm::vec3 direction); // and back; the zenith for +z

// How far a sky on SH is from the sky itself, by luminance: root mean square over the hemisphere, relative to that of
// the sky above the horizon.
struct ShQuality {
    float blur = 0.0F;    // difference above the horizon
    float ringing = 0.0F; // light below the horizon, where the sky's SH have none
};
[[nodiscard]] ShQuality sh_quality(const SkyState& sky, const SkyTables* tables, int bands,
                                   std::span<const glm::vec3> coefficients);

// Dome, SH, filtered SH, and the luminance of the third less that of the first, relative to the root mean square of the
// sky above the horizon, in colours. All tone mapped with the same exposure. `light` has at least `bands` bands.
// `width_px`: of the picture, at least 320.
[[nodiscard]] Canvas paint_sky_chart(const SkyState& sky, const SkyTables* tables, const SkyLightSh& light, int bands,
                                     ChartFilter filter, float exposure, int width_px);

// Blue for -1, grey for 0, red for 1, bounded there.
[[nodiscard]] glm::vec3 signed_colour(float value);

} // namespace alpenglow::sandbox
