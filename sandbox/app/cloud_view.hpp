// The clouds' picture for one camera: kept while nothing that it shows has changed, made anew piece by piece where only
// the wind has moved them, and at once, more coarsely, where the camera moves.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <alpenglow/clouds/march.hpp>

#include "sandbox/app/cloud_tables.hpp"
#include "sandbox/world/camera.hpp"
#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

// What is in the picture.
struct CloudsInView {
    std::vector<clouds::LitCloud> clouds;
    std::uint32_t light_revision = 0; // moves when the clouds' light or shape does, not with the wind
    double time_s = 0.0;              // by which their detail drifts
    std::span<const Vertex> terrain_vertices;
    std::span<const std::uint32_t> terrain_indices;
};

struct CloudViewSettings {
    int still_divisor = 2;      // pixels of the screen a pixel, each way, while the camera stands
    int moving_divisor = 4;     // while it moves
    int moving_lattice = 3;     // and one ray of its square is marched; the rest comes from the last picture. 1 to 3
    int spread_frames = 12;     // over which a picture is made where only the wind has moved
    float eye_turn_rad = 0.03F; // that light's directions may be off by, seen from where the eye has moved to
    float drift_pixels = 0.35F; // of the picture, that clouds may drift before it is made anew
    float step_voxels = 1.0F;
    float optical_step = 0.25F;
    float detail_strength = 2.2F; // 0: none
    float detail_cells = 2.0F;    // of its texture a voxel
    float reshape_s = 0.0F;       // in which detail has become another, see clouds::detail_drift(); 0: it stands still
    bool on_device = false;       // the device marches: tables() in place of picture(), always at still_divisor
};

class CloudView {
public:
    CloudViewSettings settings;

    // Brings the picture up to date; returns the rays marched. `width`, `height`: of the screen.
    std::size_t update(const CloudsInView& view, const Camera& camera, int width, int height);

    [[nodiscard]] const clouds::Picture& picture() const { return picture_; } // empty where the device marches
    [[nodiscard]] const CloudTables& tables() const { return tables_; }
    // Whether the picture has rays of earlier ones, and the picture of the same view that has not.
    [[nodiscard]] bool reprojected() const { return reprojected_; }
    [[nodiscard]] clouds::Picture full_picture() const;
    [[nodiscard]] const clouds::Camera& camera() const { return shown_camera_; } // of the picture
    [[nodiscard]] const std::vector<float>& landscape_m() const { return shown_landscape_m_; }
    [[nodiscard]] float scale() const { return static_cast<float>(shown_divisor_); }
    [[nodiscard]] std::uint32_t revision() const { return revision_; } // next_revision() of the last picture

private:
    // A picture in the making.
    struct Job {
        std::vector<clouds::LitCloud> clouds;
        std::vector<const clouds::CloudLighting::ViewFields*> fields; // of `eyes_`
        std::vector<std::uint32_t> fields_revisions;
        double time_s = 0.0;
        std::uint32_t light_revision = 0;
        bool newest = false; // the fields are those of that light
        clouds::Picture picture;
        int rows_done = 0;
        bool reprojected = false;
        bool running = false;
    };
    // The fields for the clouds in view, of the light as it is where that needs no waiting; whether all are.
    bool look(const CloudsInView& view);
    void start(const CloudsInView& view);
    // Rows up to `until`; returns the rays marched.
    std::size_t march_rows(int until);
    void finish();
    std::size_t march_some();
    void hand_over();                                             // to the device, in place of march_rows()
    [[nodiscard]] clouds::MarchSettings march_settings() const;   // of the job
    [[nodiscard]] double drift_m(const CloudsInView& view) const; // of what is shown

    // Fields contracted for an eye, kept while the eye has moved little against its distance.
    struct Eye {
        const clouds::CloudLighting* lighting = nullptr;
        std::uint32_t light_revision = 0;
        glm::dvec3 at_m{0.0}; // relative to the cloud's offset
        std::unique_ptr<const clouds::CloudLighting::ViewFields> fields;
        std::uint32_t revision = 0;
        bool used = false;
    };
    const Eye& eye_for(const clouds::LitCloud& cloud, std::uint32_t light_revision);

    std::vector<Eye> eyes_;
    bool contracted_ = false; // in this frame
    clouds::Camera camera_;   // of the job, and of the picture once it is done
    int divisor_ = 0;
    std::vector<float> landscape_m_, some_landscape_m_;
    clouds::Picture picture_;
    std::vector<clouds::LitCloud> shown_; // in the picture
    double shown_time_s_ = 0.0;
    std::vector<const clouds::CloudLighting::ViewFields*> shown_fields_; // of `eyes_`
    bool shown_on_device_ = false;
    bool reprojected_ = false;
    int turn_ = 0;                         // of lattice_of()
    clouds::Camera shown_camera_;          // of picture_
    int shown_divisor_ = 1;                // likewise
    std::vector<float> shown_landscape_m_; // likewise
    CloudTables tables_;
    float nearest_m_ = 1e30F;
    std::uint32_t light_revision_ = 0; // of the picture; 0: some of it is older
    std::uint32_t revision_ = 0;
    Job job_;
    Camera last_camera_;
    bool has_last_camera_ = false;
};

// The camera of a picture of the screen at 1 / divisor of its resolution, rounded up and centred.
[[nodiscard]] clouds::Camera cloud_camera(const Camera& camera, int width, int height, int divisor);

} // namespace alpenglow::sandbox
