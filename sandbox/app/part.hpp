// A part of the game: what one module adds to a scene. Parts know the stage, not each other; they meet in components.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/ecs/registry.hpp>
#include <alpenglow/systems/frame.hpp>

#include "sandbox/app/lighting.hpp"
#include "sandbox/world/camera.hpp"
#include "sandbox/world/quality.hpp"
#include "sandbox/world/render_data.hpp"
#include "sandbox/world/world.hpp"

namespace alpenglow::sandbox {

// Renders one face of a cube map around a point: probes::RenderFace, in the light of a frame.
using CaptureFace =
    std::function<void(const FrameData& frame, const glm::vec3& point_m, int face, std::span<glm::vec3> texels)>;

// What parts work on. All of it outlives them but for `frame`.
struct Stage {
    BasicRegistry& registry;
    BasicRegistry::entity_type sky; // carries WorldClock, Observer, CelestialState, Atmosphere, SkyState, SkyLightSh
    const World& world;
    Camera& camera;
    FrameData& drawn;                   // the sky's and the landscape's share is filled in before Part::update()
    std::vector<SystemReport>& reports; // append one a system
    SceneLight light;                   // of this frame
    std::uint32_t light_revision = 0;   // moves when `light` does
    Frame frame;                        // dt_s: real time
    double world_dt_s = 0.0;            // real time while the scene's clock runs, 0 while it stands: for what moves
    int width = 0, height = 0;          // of the picture, pixels
    Quality quality = Quality::lean;    // of the renderer
    std::uint64_t storage_bytes = 0;    // that a shader of its device reads from one storage buffer; 0: no device
    std::vector<Error> problems{};      // of a scene's files: it goes on without what they hold; told and emptied
    CaptureFace capture{};              // empty without a renderer
};

// Lines of the panel. Texts are shown as they were a few times a second, so that they can be read.
class PanelWriter {
public:
    virtual ~PanelWriter() = default;
    virtual void text(const std::string& line) = 0;
    // One of several names; true when the player has chosen another.
    virtual bool choice(const char* label, std::span<const char* const> names, int& chosen) = 0;
    virtual bool toggle(const char* label, bool& on) = 0;
    virtual bool slider(const char* label, float& value, float low, float high, bool logarithmic = false) = 0;
    virtual bool button(const char* label) = 0;
};

class Part {
public:
    virtual ~Part() = default;
    // Ahead of the sky's systems: move the camera, ask for sky light.
    virtual void begin(Stage& /*stage*/) {}
    // Once Stage::light is that of the sky, ahead of all that is made of it: puts other light in its place.
    virtual void relight(Stage& /*stage*/) {}
    // Runs the part's systems, appends their reports, points Stage::drawn at what is to be drawn.
    virtual void update(Stage& stage) = 0;
    virtual void draw_panel(PanelWriter& /*panel*/) {}
    // A key that nobody else took, by its ASCII capital; true where the part takes it.
    virtual bool press(int /*key*/) { return false; }
    // The frame that was just updated, as it would be drawn without the part's shortcuts, and back again; false where
    // there is no difference. Then compared() is told what the shortcuts cost in quality.
    virtual bool show_reference(bool /*reference*/) { return false; }
    virtual void compared(double /*psnr_db*/) {}
    // Waits for what goes on in the background, so that the frames to come do not depend on its pace: headless runs.
    virtual void wait() {}
};

} // namespace alpenglow::sandbox
