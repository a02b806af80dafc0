// The game: one registry, the systems in order, and the frame that comes out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/observer.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/ecs/registry.hpp>
#include <alpenglow/systems/frame.hpp>

#include "sandbox/app/lighting.hpp"
#include "sandbox/app/probe_scene.hpp"
#include "sandbox/scene/scene.hpp"
#include "sandbox/world/camera.hpp"
#include "sandbox/world/render_data.hpp"
#include "sandbox/world/world.hpp"

namespace alpenglow::sandbox {

class Game {
public:
    Game(const Scene& scene, std::unique_ptr<World> world);

    // Puts the clock, the place, the air and the camera where the scene has them; the landscape stays.
    void enter(const Scene& scene);

    // Advances the world by dt_s of real time and prepares the frame for an image of that size.
    void update(double dt_s, int width, int height);

    [[nodiscard]] const World& world() const { return *world_; }
    [[nodiscard]] const FrameData& frame() const { return frame_; }
    // Of a scene with probes, while they are in view; else null.
    [[nodiscard]] const ProbeRenderData* probe_data() const { return probes_ ? probes_->render_data() : nullptr; }
    // What each system did in the last update, in order.
    [[nodiscard]] std::span<const SystemReport> reports() const { return reports_; }

    // What the player may turn.
    Camera camera;
    float exposure_bias_ev = 0.0F;
    [[nodiscard]] WorldClock& clock() { return registry_.get<WorldClock>(sky_); }
    [[nodiscard]] Observer& observer() { return registry_.get<Observer>(sky_); }
    [[nodiscard]] Atmosphere& atmosphere() { return registry_.get<Atmosphere>(sky_); }
    [[nodiscard]] ProbeScene* probes() { return probes_.get(); } // null in scenes without
    [[nodiscard]] const CelestialState& celestial() const { return registry_.get<CelestialState>(sky_); }
    [[nodiscard]] const SkyState& sky() const { return registry_.get<SkyState>(sky_); }

private:
    SystemReport update_dome();
    SystemReport update_terrain(int height);
    SystemReport update_shadows();
    void update_probe_scene(const Frame& frame);
    void update_frame(double dt_s);

    std::unique_ptr<World> world_;
    BasicRegistry registry_;
    BasicRegistry::entity_type sky_;
    SceneLight light_;
    std::uint32_t light_revision_ = 0; // of SkyLightSh
    std::unique_ptr<ProbeScene> probes_;
    std::uint32_t probe_revision_ = 0; // where the next scene's probes go on, for whoever draws them
    std::vector<SkyVertex> dome_;
    FrameData frame_;
    std::vector<SystemReport> reports_;
    std::uint64_t frame_index_ = 0;
    bool exposed_ = false; // the first frame takes its exposure at once
};

} // namespace alpenglow::sandbox
