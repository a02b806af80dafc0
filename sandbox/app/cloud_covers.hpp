// The light that the scene's clouds leave at the places that ask for it.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/components/cloud_cover.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/ecs/registry.hpp>

#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {

// What there is to see.
struct CloudsAround {
    std::function<std::vector<clouds::LitCloud>(const glm::dvec3& around_m)> clouds;
    CloudShadowMap shadow;     // of the key light
    bool by_moon = false;      // the key light
    glm::vec3 to_light{0.0F};  // the key light
    glm::dvec3 drifted_m{0.0}; // by the wind
    float base_m = 0.0F;       // of the lowest clouds
};

// Writes a CloudCoverLight to every entity with a CloudCover. The sky is looked at again where the key light has turned
// by a degree, or clouds have drifted by a twentieth of their height above the place (50 m at least); the key light's
// transmittance comes from the shadow map in each frame and is written where it has changed by a fiftieth.
class CloudCovers {
public:
    SystemReport update(BasicRegistry& registry, const SkyLightSh& clear, const CloudsAround& around);

private:
    struct Made {
        BasicRegistry::entity_type entity;
        glm::vec3 position_m, to_light;
        glm::dvec3 drifted_m;
        bool used = true;
    };
    std::vector<Made> made_;
};

} // namespace alpenglow::sandbox
