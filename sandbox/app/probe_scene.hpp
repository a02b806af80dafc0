// A courtyard with a probe grid, and balls that glide through it, each lit by the probes around it.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/components/cloud_cover.hpp>
#include <alpenglow/components/probe_grid.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/ecs/registry.hpp>

#include "sandbox/app/part.hpp"
#include "sandbox/app/yard.hpp"
#include "sandbox/scene/scene.hpp"
#include "sandbox/world/probe_render_data.hpp"

namespace alpenglow::sandbox {

// What deringing does to the grid, over the probes that were made.
struct ProbeNumbers {
    std::uint32_t probes = 0;
    float direct_window = 1.0F;    // factor of band 1 in the light of sun and moon
    float least_window = 1.0F;     // likewise in the light of sky and ground, of the probe that keeps least
    float least_irradiance = 0.0F; // over the mean of its probe and channel: the lowest of all
    float contrast = 1.0F;         // kept, relative to no window: mean and least of the probes. Contrast is the L2 norm
    float least_contrast = 1.0F;   // of the irradiance without its mean, all channels together
};

class ProbeScene final : public Part {
public:
    // Makes its entities in the registry, which outlives it.
    ProbeScene(BasicRegistry& registry, const World& world, const ProbeSettings& settings);
    ~ProbeScene() override;
    ProbeScene(const ProbeScene&) = delete;
    ProbeScene& operator=(const ProbeScene&) = delete;

    // What the player may turn.
    ProbeSettings settings;

    void update(Stage& stage) override;
    void draw_panel(PanelWriter& panel) override;

    // Null where the yard is out of view.
    [[nodiscard]] const ProbeRenderData* render_data() const { return visible_ ? &drawn_ : nullptr; }
    [[nodiscard]] const ProbeNumbers& numbers() const { return numbers_; }
    [[nodiscard]] const ProbeGrid& grid() const { return registry_.get<ProbeGrid>(grid_); }
    // What clouds leave of the light there; null without clouds.
    [[nodiscard]] const CloudCoverLight* cover() const { return registry_.try_get<CloudCoverLight>(grid_); }
    [[nodiscard]] const ProbeGridSh& grid_light() const { return registry_.get<ProbeGridSh>(grid_); }

private:
    using Entity = BasicRegistry::entity_type;
    // Ahead of update_probes(): moves the balls by dt_s, follows sun and moon, and says what is in view.
    void prepare(double dt_s, const YardLight& light, const glm::mat4& clip_from_world);
    // After update_probe_receivers(): what is drawn, and the numbers. Items of the report: the yard, what shows probes,
    // and the balls.
    SystemReport finish(bool yard_drawn);
    void place_grid();
    void trace_lights(const YardLight& light);
    void move_balls();
    void measure();
    bool draw_yard(const YardLight& light, std::uint32_t light_revision, std::uint32_t cover_revision);
    bool draw_display();
    bool draw_balls();

    BasicRegistry& registry_;
    Yard yard_;
    Entity grid_;
    std::vector<Entity> balls_;
    std::vector<Entity> shown_; // receivers at probes of the grid: the display is a consumer like any other
    double moved_s_ = 0.0;
    bool visible_ = true;
    glm::vec3 traced_to_sun_{0.0F}, traced_to_moon_{0.0F};

    ProbeNumbers numbers_;
    std::uint32_t measured_revision_ = 0; // of ProbeGridSh
    std::vector<ColorVertex> yard_vertices_, display_vertices_;
    std::vector<std::uint32_t> yard_indices_, display_indices_;
    std::vector<LitSphere> spheres_;
    ProbeRenderData drawn_;
    // What was drawn last.
    std::uint32_t yard_light_revision_ = 0, yard_cover_revision_ = 0;
    std::uint32_t display_probe_revision_ = 0;
    bool display_shows_probes_ = false;
};

} // namespace alpenglow::sandbox
