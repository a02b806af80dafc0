// The game: one registry, the systems in order, and the frame that comes out.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <string>
#include <utility>
#include <vector>

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/observer.hpp>
#include <alpenglow/components/sky.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/ecs/registry.hpp>
#include <alpenglow/systems/frame.hpp>

#include "sandbox/app/part.hpp"
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

    // How light probes get pictures of the scene; without one they are assembled.
    void capture_with(CaptureFace capture) { stage_.capture = std::move(capture); }

    // What went wrong with a scene's files since the last call.
    [[nodiscard]] std::vector<Error> take_problems() { return std::exchange(stage_.problems, {}); }

    // Advances the world by dt_s of real time and prepares the frame for an image of that size.
    void update(double dt_s, int width, int height);

    [[nodiscard]] const World& world() const { return *world_; }
    [[nodiscard]] const FrameData& frame() const { return frame_; }
    // What each system did in the last update, in order.
    [[nodiscard]] std::span<const SystemReport> reports() const { return reports_; }

    // Waits for what goes on in the background, see Part::wait().
    void wait();

    Quality quality = Quality::lean; // of the renderer
    std::uint64_t storage_bytes = 0; // see Stage
    // What the player may turn.
    Camera camera;
    float exposure_bias_ev = 0.0F;
    [[nodiscard]] WorldClock& clock() { return registry_.get<WorldClock>(sky_); }
    [[nodiscard]] Observer& observer() { return registry_.get<Observer>(sky_); }
    [[nodiscard]] Atmosphere& atmosphere() { return registry_.get<Atmosphere>(sky_); }
    [[nodiscard]] std::span<const std::unique_ptr<Part>> parts() const { return parts_; }
    // The scene's part of that type; null where it has none.
    template <class P>
    [[nodiscard]] P* part() const {
        for (const std::unique_ptr<Part>& part : parts_) {
            if (P* found = dynamic_cast<P*>(part.get())) {
                return found;
            }
        }
        return nullptr;
    }
    [[nodiscard]] const CelestialState& celestial() const { return registry_.get<CelestialState>(sky_); }
    [[nodiscard]] const SkyState& sky() const { return registry_.get<SkyState>(sky_); }
    [[nodiscard]] const SkyLightSh& sky_light() const { return registry_.get<SkyLightSh>(sky_); }

private:
    SystemReport update_dome();
    void set_air();
    SystemReport update_terrain(int height);
    SystemReport update_shadows();
    void update_frame(double dt_s);

    std::unique_ptr<World> world_;
    BasicRegistry registry_;
    BasicRegistry::entity_type sky_;
    // What light and dome were made from: SkyState, bands, SkyTables, the camera's height over the ground.
    using DomeKey = std::tuple<std::uint32_t, int, std::uint32_t, int>;
    std::optional<DomeKey> dome_key_;
    double place_height_m_ = 0.0; // of the landscape's zero over the ellipsoid
    std::vector<SkyVertex> dome_;
    std::uint32_t dome_revision_ = 0;
    FrameData frame_;
    std::vector<SystemReport> reports_;
    std::uint64_t frame_index_ = 0;
    bool exposed_ = false; // the first frame takes its exposure at once
    Stage stage_;
    std::vector<std::unique_ptr<Part>> parts_; // last: they leave before what they stand on
};

} // namespace alpenglow::sandbox
