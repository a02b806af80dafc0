// Surroundings from a picture: the light of the scene, its background, and the light of its probes.
#pragma once

#include <array>
#include <vector>

#include <glm/mat4x4.hpp>

#include <alpenglow/components/environment_map.hpp>

#include "sandbox/app/part.hpp"
#include "sandbox/world/environment_render_data.hpp"

namespace alpenglow::sandbox {

class EnvironmentPart final : public Part {
public:
    // `map` has passed probes::check().
    EnvironmentPart(BasicRegistry& registry, EnvironmentMap map);
    ~EnvironmentPart() override;
    EnvironmentPart(const EnvironmentPart&) = delete;
    EnvironmentPart& operator=(const EnvironmentPart&) = delete;

    // Puts the picture's light in the place of sky, sun and moon: the picture shows its own.
    void relight(Stage& stage) override;
    void update(Stage& stage) override;
    void draw_panel(PanelWriter& panel) override;

private:
    void take_light();

    BasicRegistry& registry_;
    BasicRegistry::entity_type entity_;
    std::array<glm::mat4, 3> irradiance_matrix_{};
    glm::vec3 horizon_radiance_{0.0F};
    float average_luminance_ = 0.0F;
    std::vector<SkyVertex> dome_; // for the air and for captures
    std::uint32_t dome_revision_ = 0;
    EnvironmentRenderData drawn_;
    std::uint32_t made_revision_ = 0; // of the map
};

} // namespace alpenglow::sandbox
