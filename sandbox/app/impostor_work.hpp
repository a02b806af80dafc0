// Pictures in the making: marched some rows a frame, so that no frame pays for all of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include <alpenglow/impostors/scheduler.hpp>
#include <alpenglow/systems/cloud_impostors.hpp>

namespace alpenglow::sandbox {

// What work costs, in units of a texel that shows a cloud (about half a microsecond): fixed, measured once
// (docs/impostors.md), so that what a frame does hangs on the budget and not on the machine's pace.
struct WorkCost {
    static constexpr double seen_texel = 1.0;
    static constexpr double empty_texel = 0.15;
    static constexpr double kept_texel = 0.02;        // depth map, sensitivity, mesh
    static constexpr double picture = 3000.0;         // fields contracted for its eye
    static constexpr double inside_seen_texel = 0.33; // longer steps
    static constexpr double inside_empty_texel = 0.17;
};

// Carries out the captures of plans, in their order.
class CaptureQueue {
public:
    using Subject = std::function<std::optional<CloudSubject>(std::uint64_t object)>;

    void add(const impostors::CaptureJob& job, std::uint64_t object, const impostors::Sphere& bounds);
    void drop(impostors::SlotId slot);
    // Works for about `units`, at least one step; returns what was spent. Pictures that are complete appear in
    // `done`, and the scheduler has been told.
    double work(double units, const Subject& subject, impostors::Scheduler& scheduler,
                std::vector<impostors::CaptureJob>& done);
    [[nodiscard]] double left() const; // units, about

    [[nodiscard]] const impostors::Capture* find(impostors::SlotId slot) const;

private:
    struct Work {
        impostors::CaptureJob job;
        std::uint64_t object = 0;
        impostors::Sphere bounds;
        std::optional<CloudCapture> march;
    };
    std::deque<Work> works_;
    std::unordered_map<impostors::SlotId, impostors::Capture> captures_;
};

} // namespace alpenglow::sandbox
