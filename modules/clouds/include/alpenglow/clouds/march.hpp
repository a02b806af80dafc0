// Pictures of a lit cloud.
#pragma once

#include <optional>
#include <span>

#include <alpenglow/clouds/detail.hpp>
#include <alpenglow/clouds/lighting.hpp>

namespace alpenglow::clouds {

// Columns x0 .. x1 - 1 and rows y0 .. y1 - 1 of a picture.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
};

struct MarchSettings {
    float step_voxels = 1.0F; // of the smallest voxel side, where there is matter
    float optical_step =
        0.0F; // > 0: deep inside, steps grow until they span this optical depth at the transmittance left
    float stop_transmittance = 1e-3F;          // rays end here; what is left of them counts as opaque
    std::span<const float> scene_depth_m = {}; // distance to opaque geometry for each pixel; empty: none
    std::span<const float> from_m = {};        // distance at which each pixel's ray starts; empty: at the eye
    const DetailTexture* detail = nullptr; // structure finer than voxels; the light is that of the density without it
    float detail_strength = 0.8F;          // see detailed_density()
    float detail_cells = 3.0F;             // of the texture a voxel
    std::optional<DetailOffsets> detail_offsets = {}; // detail_drift() of now; none: detail stands still
    PixelRect rect = {};                              // pixels to march; empty: all
    // This eye's fields, contracted by the caller; null: march() contracts them. For pictures made piece by piece.
    const CloudLighting::ViewFields* fields = nullptr;
    unsigned threads = 0;
};

// Front to back through the bricks, vectorised over pixels. Each step is integrated analytically with its midpoint's
// source (Harris: eq. 9, a Riemann sum, as it stands). The light of each directional source is looked up by optical
// depth and angle, everything else in the fields contracted for this eye.
[[nodiscard]] Picture march(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                            const MarchSettings& settings = {});

// A lit cloud where it stands in the scene: offset_m moves the volume and its light.
struct LitCloud {
    const BrickVolume* volume = nullptr;
    const CloudLighting* lighting = nullptr;
    glm::dvec3 offset_m{0.0};
};

// The pixels that the cloud's matter may fall on, at most those in `within` (empty: the whole picture).
[[nodiscard]] PixelRect bounds_on_screen(const LitCloud& cloud, const Camera& camera, const PixelRect& within = {});

// All clouds from one camera in one picture, each marched within its bounds alone. Where several lie behind a pixel,
// they are taken from near to far by their mean depths. `fields`: one a cloud, as MarchSettings::fields; empty: made
// here.
[[nodiscard]] Picture march(std::span<const LitCloud> clouds, const Camera& camera, const MarchSettings& settings = {},
                            std::span<const CloudLighting::ViewFields* const> fields = {});

// The same, pixel by pixel and in plain code: what tests hold march() to. step_voxels alone matters.
[[nodiscard]] Picture march_scalar(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
                                   const MarchSettings& settings = {});

// One ray of march_scalar(), with fields contracted by the caller. eye: index coordinates; world: unit.
struct RayLight {
    glm::vec3 radiance{0.0F};
    float transmittance = 1.0F;
    float depth_m = 0.0F;
    float spread_m = 0.0F;
};
[[nodiscard]] RayLight march_ray(const BrickVolume& volume, const CloudLighting& lighting,
                                 const CloudLighting::ViewFields& fields, const glm::dvec3& eye, const glm::vec3& world,
                                 const MarchSettings& settings, float t_end, float t_start = 0.0F);

} // namespace alpenglow::clouds
