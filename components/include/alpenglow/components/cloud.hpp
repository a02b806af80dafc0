// Clouds: what a designer sets, and what update_clouds writes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include <glm/vec3.hpp>

namespace alpenglow {

namespace clouds {
class BrickVolume;   // alpenglow/clouds/bricks.hpp
class CloudLighting; // alpenglow/clouds/lighting.hpp
} // namespace clouds

// How light finds its way through a cloud.
enum class CloudMethod : std::uint8_t { single_scattering, harris, octaves, transport };

// Input. A cloud somewhere in the scene. Its shape is shared: many entities may show one volume.
struct CloudVolume {
    std::shared_ptr<const clouds::BrickVolume> volume; // none (a file that could not be read): nothing to light or draw
    glm::dvec3 offset_m{0.0};       // moves the volume in the scene; wind adds to it, and no light changes by that
    float extinction_per_m = 0.04F; // at density 1, > 0
    float albedo = 0.999F;          // single-scattering albedo, 0 .. 1
    float anisotropy = 0.85F;       // g of the Henyey-Greenstein phase function, -1 < g < 1
    CloudMethod method = CloudMethod::transport;
    float max_error = 0.02F; // relative change of the picture that may go unnoticed, >= 0
    bool visible = true;     // the game's culling: what is not seen is not lit
    float size_px = 1e9F;    // on screen; below a pixel nothing is lit
    bool skylit = true;      // lit by the sky, not by sun and moon alone
    // Shares of the direct light that other clouds let through to this one, 0 .. 1: a clouds::CloudShadow knows them.
    float sun_share = 1.0F;
    float moon_share = 1.0F;
};

// Output of update_clouds, and its memory of what the light was made from.
struct CloudLight {
    std::shared_ptr<clouds::CloudLighting> lighting; // what clouds::march draws with
    std::shared_ptr<const clouds::BrickVolume> made_from_volume;
    float made_from_extinction_per_m = 0.0F, made_from_albedo = -1.0F, made_from_anisotropy = 0.0F;
    CloudMethod made_from_method = CloudMethod::transport;
    // Lights in the order of the lighting's: sun and moon, those that are up.
    std::array<glm::vec3, 2> made_from_to_light{};
    std::array<std::uint8_t, 2> kind{}; // 1 sun, 2 moon, 0 none
    int lights = 0;
    std::array<glm::vec3, 16> made_from_sky{}; // radiance, SH up to band 3
    bool has_sky = false;
    float error_bound = 0.0F;          // as of the last look
    std::uint32_t revision = 0;        // counts changes of what is drawn with; the volume's own are counted below
    std::uint32_t volume_revision = 0; // counts changes of volume: upload the bricks again when it moves
};

// Input, in the registry's context: work a frame.
struct CloudBudget {
    int slices_per_frame = 10; // bounded slices of multiple scattering (a slice: 1 to 6 ms for a cloud of 130^3 voxels)
    int depths_per_frame = 1;  // optical depths of a light that has turned (10 to 25 ms for such a cloud)
};

} // namespace alpenglow
