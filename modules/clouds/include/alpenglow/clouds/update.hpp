// What update_clouds decides and does for one cloud: no registry here.
#pragma once

#include <alpenglow/components/cloud.hpp>
#include <alpenglow/components/sky.hpp>

#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/core/result.hpp>

namespace alpenglow::clouds {

// The scene's light as clouds see it.
struct CloudSources {
    DirectionalLight lights[2];
    std::uint8_t kind[2] = {0, 0}; // 1 sun, 2 moon
    int count = 0;
    SkySh sky;
};

// Sun and moon that are up and bright enough to matter (a thousandth of the brighter one), and the sky up to band 3.
// Below the horizon stands what level ground of that albedo sends up: sun, moon and the sky's irradiance (its first
// three bands: Ramamoorthi and Hanrahan 2001) over pi, a Lambertian plane, the same in every direction.
[[nodiscard]] CloudSources cloud_sources(const SkyState& state, const SkyLightSh* sky,
                                         const glm::vec3& ground_albedo = glm::vec3(0.0F));

// Values that update_clouds refuses: extinction, albedo, anisotropy or max_error out of range or NaN.
[[nodiscard]] Status check(const CloudVolume& cloud);

// Bounds on the relative change of the cloud's picture (norm of the difference over norm) since its light was made:
// direction, by the angle that a light has turned; sky, by the largest change of radiance over the mean; infinite where
// the light has to be made anew. Colours of sun and moon cost nothing and are not in it.
struct CloudStaleness {
    bool anew = false; // volume, medium or method changed, or lights rose or set
    float direction[2] = {0.0F, 0.0F};
    float sky = 0.0F;
    [[nodiscard]] float bound() const;
};
[[nodiscard]] CloudStaleness staleness(const CloudVolume& cloud, const CloudLight& light, const CloudSources& sources);

// Bound on the picture's relative change by a light that has turned: 3 (1 - |g|)^(-2/3) times the angle. Against the
// light the beam's own width decides; measured on the benchmarks' clouds are 2.4, 6.1 and 18 times the angle at g = 0,
// 0.85 and 0.95, and less than 1 from the side and front.
[[nodiscard]] float turning_error(float angle_rad, float anisotropy);

// Starts what is stale beyond `cloud.max_error`, at most `depths` optical depths of lights (lowered by what was used).
// Returns whether anything was started.
bool refresh(const CloudVolume& cloud, CloudLight& light, const CloudSources& sources, const CloudStaleness& stale,
             int& depths);

} // namespace alpenglow::clouds
