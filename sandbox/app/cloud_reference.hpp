// How far a scene's clouds are from the path tracer's, seen from where the scene begins: against a stored picture of
// it.
#pragma once

#include <optional>
#include <string>

#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/reference.hpp>
#include <alpenglow/clouds/update.hpp>

#include "sandbox/scene/cloud_settings.hpp"
#include "sandbox/world/camera.hpp"

namespace alpenglow::sandbox {

// The grid that a layer is drawn from; the wind leans its towers.
[[nodiscard]] clouds::SparseGrid layer_grid(const CloudSettings& settings, const CloudLayerSettings& layer);

// The camera of a reference.
[[nodiscard]] clouds::Camera reference_camera(const Camera& scene_camera);

// One layer, once, without wind, landscape, air and detail, in the light that update_clouds gives it.
[[nodiscard]] clouds::ReferenceScene reference_scene(const clouds::SparseGrid& grid, const CloudMatter& matter,
                                                     const clouds::CloudSources& sources);

class CloudReference {
public:
    // The picture stored for the scene; none where there is none, or where the scene is not of one layer.
    static std::optional<CloudReference> load(const CloudSettings& settings, const Camera& scene_camera);

    // Whether the sun stands where it stood: within half a degree.
    [[nodiscard]] bool holds(const clouds::CloudSources& sources) const;
    [[nodiscard]] clouds::ImageError error(const clouds::BrickVolume& volume, const clouds::CloudLighting& lighting,
                                           const clouds::SkySh& sky) const;

private:
    clouds::ReferenceFile file_;
    clouds::Camera camera_;
    glm::vec3 to_light_{0.0F};
};

// "x y z" of the light: a reference's note.
[[nodiscard]] std::string reference_note(const clouds::CloudSources& sources);

} // namespace alpenglow::sandbox
