// Pictures in memory: what carries out a plan on the CPU.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include <glm/vec4.hpp>

#include <alpenglow/core/result.hpp>
#include <alpenglow/impostors/capture.hpp>
#include <alpenglow/impostors/reproject.hpp>
#include <alpenglow/impostors/scheduler.hpp>

namespace alpenglow::impostors {

class CaptureStore {
public:
    // Draws what the plan asks for and tells the scheduler what it measured; frees what was released. `drawable` gives
    // the Drawable of a SceneObject's id, or nullptr. Goes on past a failed capture (the scheduler will try again) and
    // returns the last error.
    Status carry_out(const Plan& plan, std::span<const SceneObject> objects, std::span<const SceneView> views,
                     const Lights& lights, Scheduler& scheduler,
                     const std::function<const Drawable*(std::uint64_t)>& drawable);

    // All draws of one view, from far to near, over the transparent: premultiplied. `settings.gain` and `weight` are
    // ignored: the plan and the lights give them.
    void draw_view(const Plan& plan, std::size_t view_index, std::span<const SceneObject> objects,
                   std::span<const SceneView> views, const Lights& lights, const DrawSettings& settings,
                   std::span<glm::vec4> image) const;

    // One draw: both pictures of a fade, the screen-aligned one, or the stand-in; added to `image`, which starts at
    // zero.
    void draw_item(const DrawItem& item, std::span<const SceneObject> objects, std::span<const SceneView> views,
                   const Lights& lights, const DrawSettings& settings, std::span<glm::vec4> image) const;

    [[nodiscard]] const Capture* find(SlotId slot) const;
    // The screen-aligned picture of an object in a view; null where there is none.
    [[nodiscard]] const Capture* find_inside(std::uint64_t object, std::uint32_t view) const;
    [[nodiscard]] std::size_t size() const { return captures_.size(); }

private:
    std::unordered_map<SlotId, Capture> captures_;
    std::unordered_map<std::uint64_t, std::unordered_map<std::uint32_t, Capture>> inside_; // by object and view
};

} // namespace alpenglow::impostors
