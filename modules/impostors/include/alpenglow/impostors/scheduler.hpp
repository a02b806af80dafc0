// Which pictures still hold, and which to draw again this frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/core/result.hpp>
#include <alpenglow/impostors/atlas.hpp>
#include <alpenglow/impostors/capture.hpp>
#include <alpenglow/impostors/geometry.hpp>

namespace alpenglow::impostors {

// Errors that may go unnoticed. 0, negative or NaN: none may, so that any change is captured as the budget allows.
struct Tolerance {
    double angle_rad = 0.0026179938779914945; // 0.15 degrees (003, section 3): plane and layers
    double pixels = 2.0;                      // the same shift on the view's screen, for zoomed views: plane and layers
    double image = 0.01;                      // relative RMSE as predicted_error has it, once a picture is measured
    double light = 0.02;                      // relative, see light_error
    double content = 0.02;                    // relative, see content_error
};

// An object that is drawn by impostor.
struct SceneObject {
    std::uint64_t id = 0; // unique, kept from frame to frame
    Sphere bounds;
    Tolerance tolerance;
    Representation representation = Representation::warped_layers;
    int layers = 8;
    double content = 0.0; // see content_error; rotation of the object counts here too
    double phase_g = 0.0; // of its shading: see light_error
    bool visible = true;
};

struct SceneView {
    std::uint32_t id = 0; // unique, kept from frame to frame
    Frustum frustum;
};

struct SchedulerSettings {
    int atlas_side = 2048; // texels, a power of two
    int device_limit = 16384;
    int least_tile = 16; // a power of two
    int most_tile = 512;
    double budget_texels = 262144.0; // captured a frame; 0: one smallest tile a frame, so that something shows
    double budget_ms = std::numeric_limits<double>::infinity(); // likewise, through the measured cost of a texel
    double fade_s = 0.25;   // a new picture takes over from the old within this time
    double ahead = 0.7;     // from this share of a tolerance a picture may be renewed ahead of need, in half the budget
    double headroom = 1.25; // texels taken over what is required, so that coming nearer does not renew at once
    double smallest_pixels = 0.5;  // objects of a smaller diameter are not drawn
    double inside_full = 1.1;      // nearer than this many radii: the screen-aligned impostor alone
    double inside_start = 1.4;     // it begins to come in
    double inside_downscale = 4.0; // until a capture was measured
    double inside_error = 0.01;    // relative RMSE of the downscale, from then on
    double margin_inside = 0.0;    // see screen_aligned
    int warp_cell = 0;             // see CaptureSettings
    // > 1: captures are carried out over several frames, and up to so many budgets of them may wait (set_backlog). A
    // picture that has been asked for counts as good, and its fade waits, until measured() or failed(). Where much is
    // missing all of it shares what is left, coarse at first. Screen-aligned pictures are the caller's to afford.
    double spread_frames = 1.0;
    // > 0: pictures of soft things may have fewer texels than pixels, down to a quarter across, as long as what
    // bilinear filtering is measured to lose (Sensitivity::resample) stays within this; 0: equation 11 as it stands.
    double detail_error = 0.0;
};

using SlotId = std::uint32_t;
inline constexpr SlotId no_slot = 0;

// A picture to draw now. Afterwards: Scheduler::measured, or failed.
struct CaptureJob {
    SlotId slot = no_slot;
    std::size_t object = 0; // index into the objects and views of this frame
    std::size_t view = 0;
    Frustum frustum;
    CaptureSettings settings;
    std::vector<AtlasTile> tiles; // one a layer; the picture's width x height from each one's upper left
    double urgency = 0.0;         // error over tolerance that the view had; infinite: it had nothing
    std::size_t texels = 0;
};

// A screen-aligned picture to draw now, for a viewer inside or next to the object.
struct InsideJob {
    std::size_t object = 0;
    std::size_t view = 0;
    Frustum frustum;
    double downscale = 4.0;
    std::size_t texels = 0;
};

// What to show of an object in a view: weight x `slot` + (1 - weight) x `before`, added (reproject.hpp), all of it
// times impostor_weight, plus the screen-aligned picture times the rest.
struct DrawItem {
    std::size_t object = 0;
    std::size_t view = 0;
    SlotId slot = no_slot; // no_slot: nothing but `stand_in`
    SlotId before = no_slot;
    float weight = 1.0F;
    float impostor_weight = 1.0F;
    glm::vec4 stand_in{0.0F}; // mean premultiplied colour over the square around the bounds, of the last picture
    double urgency = 0.0;     // error over tolerance of what is shown
    double distance_m = 0.0;  // from the eye to the centre
};

struct ScheduleReport {
    std::uint32_t considered = 0; // objects x views
    std::uint32_t seen = 0;       // of these in the view, and large enough
    std::uint32_t reused = 0;     // seen, and not captured this frame
    std::uint32_t captured = 0;
    std::uint32_t inside = 0;   // screen-aligned captures
    std::uint32_t deferred = 0; // past their tolerance, and left for want of budget
    std::uint32_t unserved = 0; // seen, and without a picture
    std::uint32_t evicted = 0;
    std::uint32_t rejected = 0; // objects with bounds or views that are not finite, or negative: not drawn
    std::uint32_t degraded = 0; // captured below the resolution that was required
    int degrade_level = 0;      // tiles are required_texels / 2^level wide, for want of atlas
    double texels = 0.0;        // captured this frame
    double worst_urgency = 0.0; // largest finite error over tolerance that is shown
};

struct Plan {
    std::vector<CaptureJob> captures; // in this order: worst error first
    std::vector<InsideJob> inside;
    std::vector<DrawItem> draws;  // by view, and within it from far to near
    std::vector<SlotId> released; // pictures that nobody will show any more: free them
    ScheduleReport report;
};

// Keeps account of pictures; holds none of them, so that they may live on a GPU. Deterministic: a plan depends on the
// calls before it alone, and with budget_ms infinite on nothing measured in time.
class Scheduler {
public:
    [[nodiscard]] static Result<Scheduler> create(const SchedulerSettings& settings = {});

    // Budget and fade may change between frames; the atlas may not.
    void set_budget(double texels, double ms = std::numeric_limits<double>::infinity());

    // Texels of captures that were planned before and are still to be carried out: see spread_frames.
    void set_backlog(double texels) { backlog_ = texels; }

    // What to do this frame. now_s: any clock that runs forward. The plan's indices mean these objects and views. An
    // object that is not among them gives up its pictures.
    void plan(std::span<const SceneObject> objects, std::span<const SceneView> views, const Lights& lights,
              double now_s, Plan& out);

    void measured(SlotId slot, const Sensitivity& sensitivity, const glm::vec4& mean);
    void measured_inside(std::uint64_t object, std::uint32_t view, const Sensitivity& sensitivity, double downscale);
    void failed(SlotId slot);                   // the capture did not come about: it will be tried again
    void captured_in(double texels, double ms); // time that captures took: the cost of a texel, smoothed

    [[nodiscard]] const SchedulerSettings& settings() const { return settings_; }
    [[nodiscard]] const Atlas& atlas() const { return atlas_; }
    [[nodiscard]] std::size_t pictures() const { return slots_.size(); }

private:
    struct Slot {
        std::uint64_t object = 0;
        glm::dvec3 eye_m{0.0}; // from the bounds' centre
        Frustum frustum;
        Representation representation = Representation::plane;
        int layers = 1;
        int texels = 0;        // a side
        double required = 1.0; // by equation 11 when it was taken
        double radius_m = 0.0;
        std::vector<AtlasTile> tiles;
        Lights lights;
        double content = 0.0;
        std::optional<Sensitivity> sensitivity;
        double importance = 0.0;     // pixels across, where last shown
        std::uint64_t last_used = 0; // frame
    };
    struct Shown { // in one view
        std::uint32_t view = 0;
        SlotId slot = no_slot;
        SlotId before = no_slot;
        double fade_start_s = 0.0;
        std::uint64_t last_seen = 0;
        std::optional<Frustum> inside; // of the last screen-aligned picture
        double inside_content = 0.0;
        Lights inside_lights;
        double downscale = 0.0; // 0: not measured
    };
    struct Record {
        std::vector<Shown> shown;
        std::vector<SlotId> slots;
        glm::vec4 mean{0.0F};
        double detail = 1.0; // texels over what equation 11 requires
        std::uint64_t last_presented = 0;
    };
    struct Candidate;

    Scheduler(const SchedulerSettings& settings, Atlas atlas) : settings_(settings), atlas_(std::move(atlas)) {}
    [[nodiscard]] double urgency(const Slot& slot, const SceneObject& object, const Frustum& view, const Lights& lights,
                                 int granted, double detail) const;
    [[nodiscard]] bool make_room(int texels, int layers, double importance, std::vector<AtlasTile>& tiles, Plan& out);
    void release(SlotId slot, Plan& out);
    void drop_unused(Record& record, Plan& out);

    SchedulerSettings settings_;
    Atlas atlas_;
    std::unordered_map<SlotId, Slot> slots_;
    std::unordered_map<std::uint64_t, Record> records_;
    std::vector<SlotId> failed_;
    SlotId next_slot_ = 1;
    std::uint64_t frame_ = 0;
    int degrade_level_ = 0;
    double ms_per_texel_ = 0.0; // 0: not known yet
    double backlog_ = 0.0;
};

} // namespace alpenglow::impostors
