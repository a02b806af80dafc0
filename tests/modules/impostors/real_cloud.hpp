// A cloud of the clouds module, lit by all of its methods' best, as impostors' subject.
#pragma once

#include <cstdint>

#include <alpenglow/clouds/library.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/systems/cloud_impostors.hpp>

#include "blob_cloud.hpp"

namespace alpenglow::test {

struct RealCloud {
    clouds::BrickVolume volume;
    clouds::CloudLighting lighting;
    impostors::Sphere bounds;
    float step_voxels = 0.5F; // fine enough that pictures differ by their place alone

    // A noise cloud of `voxels` a side, or the billowed cumulus of the benchmarks at half resolution for 0.
    explicit RealCloud(std::uint32_t seed, int voxels = 32, float g = 0.85F, float extinction_per_m = 0.5F)
        : volume(voxels > 0 ? clouds::noise_cloud(seed, voxels) : clouds::coarsen(clouds::cumulus_of_study(seed), 1)) {
        clouds::Medium medium{extinction_per_m, 0.99F, {}};
        medium.phase.g = g;
        lighting.reset(volume, medium, {});
        lighting.bake_light(0, {glm::vec3(0.3F, 0.4F, 0.866025F), glm::vec3(4.0F, 3.8F, 3.4F), 0.0F});
        lighting.bake_sky(clouds::SkySh::uniform(glm::vec3(0.3F, 0.4F, 0.6F)));
        bounds = cloud_bounds(volume);
    }

    // Fields for all eyes near `eye`: null contracts them for each.
    [[nodiscard]] impostors::Drawable drawable(const clouds::CloudLighting::ViewFields* fields = nullptr) const {
        CloudSubject subject{&volume, &lighting, {}, {}, 1.0F};
        subject.march.fields = fields;
        subject.march.step_voxels = step_voxels;
        return cloud_drawable(subject);
    }

    [[nodiscard]] std::vector<glm::vec4> directly(const impostors::Frustum& view,
                                                  const clouds::CloudLighting::ViewFields* fields = nullptr,
                                                  unsigned threads = 0) const {
        clouds::MarchSettings settings;
        settings.fields = fields;
        settings.step_voxels = step_voxels;
        settings.threads = threads;
        const clouds::Picture picture = clouds::march(volume, lighting, cloud_camera(view), settings);
        std::vector<glm::vec4> image(picture.radiance.size());
        for (std::size_t i = 0; i < image.size(); ++i) {
            image[i] = glm::vec4(picture.radiance[i], 1.0F - picture.transmittance[i]);
        }
        return image;
    }
};

} // namespace alpenglow::test
