// The sky: what a designer sets, who reads what of it, and what update_sky and update_sky_light write.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>

#include <glm/vec3.hpp>

namespace alpenglow {

namespace sky {
class AerialTable;      // alpenglow/sky/aerial_table.hpp
class ScatteringTables; // alpenglow/sky/scattering_tables.hpp
class SkyView;          // alpenglow/sky/scattering_tables.hpp
} // namespace sky

// Which sky. docs/sky.md says what each is good for.
enum class SkyModel : std::uint8_t {
    preetham,     // clear sky from turbidity
    perez,        // all weathers, from clearness and brightness
    cie_clear,    // clear sky from turbidity
    cie_overcast, // closed cloud, the same from all sides
    asrc_cie,     // overcast to clear, blended by clearness
    cie_general,  // the fifteen standard skies, by cie_type
    scattering    // light scattered in a spherical shell of air: ground albedo, altitude, twilight, below the horizon
};

// Input. Air over the observer. An Observer on the same entity gives the altitude; without one it is 0.
struct Atmosphere {
    float turbidity = 2.5F;        // haze: 1 clean air, 2 clear, 6 hazy; 1.7 .. 10
    float ozone_atm_cm = 0.35F;    // column of ozone, 0 .. 2
    glm::vec3 ground_albedo{0.2F}; // linear Rec.709, 0 .. 1, for the light that the ground sends back up
    float max_error = 0.005F;      // relative error of sky and sunlight that may go unnoticed, >= 0
    SkyModel model = SkyModel::preetham;
    float clearness = 6.0F;    // perez, asrc_cie: Perez' epsilon, 1 overcast .. 12 clear
    float brightness = 0.2F;   // perez: Perez' delta, 0.01 .. 0.6
    int cie_type = 12;         // cie_general: 1 .. 15
    float zenith_cd_m2 = 0.0F; // luminance of the zenith where it is known (not preetham, scattering); 0: the
                               // model's own
};

// Output of update_sky: the state of the sky model and the lights behind the air. Light is photometric linear Rec.709
// (see docs/architecture.md). sky::sky_radiance() evaluates it.
struct SkyState {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};
    Atmosphere air{};                     // that it was made for
    float height_m = 0.0F;                // likewise
    float fade = 1.0F;                    // factor on the sky of the sun; 0: dark
    float moon_fade = 0.0F;               // factor on the sky that the sun would make where the moon stands; 0: none
    glm::vec3 night_radiance_cd_m2{0.0F}; // a dim, uniform floor: airglow and starlight
    glm::vec3 sun_illuminance_lux{0.0F};  // on a surface facing the sun, at the observer, through the air
    glm::vec3 moon_illuminance_lux{0.0F}; // likewise for the moon at its phase
    float turbidity = 2.5F;               // air.turbidity
    // The inputs that this was made from, beside to_sun and air.
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    float moon_phase_angle_rad = 0.0F;
    std::uint32_t celestial_revision = 0;
    std::uint32_t revision = 0; // counts recomputations; 0: never made
};

// Input, on every entity that reads tables of the scattering sky: the renderer of the dome, of the air in front of
// things, of things at other heights. No visible reader, no table. (The SH of the sky builds what it needs by itself.)
struct SkyTableReader {
    bool sky_view = true;            // radiance of the sky towards any direction, also below the horizon
    bool aerial_perspective = false; // light that the air adds in front of things, and what it takes away
    bool transmittance = false;      // light of the sun at other heights
    bool visible = true;
};

// Output of update_sky for SkyModel::scattering. Tables are shared and never change once made: a renderer that holds
// one may read it while the next is built, and uploads it when its revision has changed.
struct SkyTables {
    std::shared_ptr<const sky::ScatteringTables> atmosphere; // sun's light at every height, multiple scattering
    std::shared_ptr<const sky::SkyView> sun_view, moon_view; // the sky that sun and moon make; null: none needed
    std::shared_ptr<const sky::AerialTable> sun_aerial, moon_aerial;
    std::uint32_t atmosphere_revision = 0, view_revision = 0, aerial_revision = 0; // count rebuilds
    // What they were made from.
    Atmosphere air{};
    double sun_altitude_rad = std::numeric_limits<double>::quiet_NaN(), moon_altitude_rad = sun_altitude_rad;
    double aerial_sun_altitude_rad = sun_altitude_rad, aerial_moon_altitude_rad = sun_altitude_rad;
    float view_height_m = 0.0F, aerial_height_m = 0.0F;
};

// Input, on every entity lit by the sky's SH: how many bands it reads. No such entity (or none visible), no sky SH.
struct SkyLightReceiver {
    int bands = 3; // 1 .. 7
    bool visible = true;
};

// Output of update_sky_light: sky radiance projected on SH, cd/m^2, in the local frame (zonal axis = zenith).
struct SkyLightSh {
    static constexpr int max_bands = 7;
    std::array<glm::vec3, 49> coefficients{};
    int bands = 0; // valid bands; 0 until somebody asks
    glm::vec3 made_from_to_sun{0.0F};
    std::uint32_t sky_revision = 0;
    std::uint32_t revision = 0;
};

} // namespace alpenglow
