// The part of a scene whose clouds are drawn by impostors (docs/impostors.md): a field of clouds and aircraft among
// them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <alpenglow/clouds/bricks.hpp>
#include <alpenglow/clouds/detail.hpp>
#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/view.hpp>
#include <alpenglow/components/cloud.hpp>
#include <alpenglow/systems/impostors.hpp>

#include "sandbox/app/impostor_inside.hpp"
#include "sandbox/app/impostor_mesh.hpp"
#include "sandbox/app/impostor_work.hpp"
#include "sandbox/app/part.hpp"
#include "sandbox/app/squadron.hpp"
#include "sandbox/scene/impostor_settings.hpp"
#include "sandbox/world/impostor_render_data.hpp"

namespace alpenglow::sandbox {

class ImpostorScene final : public Part {
public:
    ImpostorScene(Stage& stage, const ImpostorSettings& settings);
    ~ImpostorScene() override;
    ImpostorScene(const ImpostorScene&) = delete;
    ImpostorScene& operator=(const ImpostorScene&) = delete;

    void begin(Stage& stage) override;
    void update(Stage& stage) override;
    void draw_panel(PanelWriter& panel) override;
    bool press(int key) override;

    // Every cloud marched from the camera instead.
    bool show_reference(bool reference) override;
    void compared(double psnr_db) override { psnr_db_ = psnr_db; }

    [[nodiscard]] const impostors::ScheduleReport& schedule() const { return schedule_; }
    [[nodiscard]] double capture_ms() const { return capture_ms_; }
    // Work on pictures in this frame, in units of a texel (impostor_work.hpp), and how many were completed.
    [[nodiscard]] double capture_units() const { return units_; }
    [[nodiscard]] std::uint32_t taken() const { return taken_; }

private:
    using Entity = BasicRegistry::entity_type;
    // A shape, lit once for all clouds that have it.
    struct Kind {
        Entity entity{};
        std::shared_ptr<const clouds::BrickVolume> volume;
        std::uint32_t light_revision = 0;
        double content = 0.0;
    };
    struct Cloud {
        std::size_t kind = 0;
        Entity entity{};
        glm::dvec3 offset_m{0.0};
        glm::dvec3 centre_m{0.0};
        double radius_m = 0.0;
        bool touched = false; // something flies in it
    };
    struct Picture { // of a slot
        std::vector<impostors::AtlasTile> tiles;
        std::vector<PictureMesh> layers;
        float encoded_gain = 0.0F;
        double since_s = 0.0;
    };
    void show_direct(Stage& stage);
    [[nodiscard]] clouds::MarchSettings march_settings() const;
    void add_clouds(BasicRegistry& registry);
    void update_kinds(Stage& stage);
    void update_craft(Stage& stage);
    void capture(Stage& stage);
    void capture_inside(Stage& stage, std::vector<std::uint64_t>& taken);
    void add_key(const InsidePictures::Key& key);
    void encode_again(float exposure);
    [[nodiscard]] std::optional<CloudSubject> subject_of(std::uint64_t object) const;
    [[nodiscard]] impostors::Frustum camera_view() const;
    void build(const Stage& stage);
    void build_outlines();
    void add_item(const impostors::DrawItem& item, const impostors::SceneView& view);
    [[nodiscard]] float gain_now(const impostors::Capture& picture, float exposure) const;
    void add_tile(const impostors::Capture& picture, std::size_t layer, const glm::ivec2& at);
    [[nodiscard]] std::vector<std::size_t> visible_clouds() const;

    Stage& stage_;
    ImpostorSettings settings_;
    double voxel_m_ = 8.0;
    clouds::DetailTexture detail_;
    BasicRegistry& registry_;
    std::vector<Kind> kinds_;
    std::vector<Cloud> clouds_;
    Entity view_{}, light_{};
    std::unordered_map<std::uint64_t, std::size_t> cloud_of_id_;
    FlightPath path_;
    std::vector<Craft> craft_;
    double time_s_ = 9.0; // along the path: they are about to enter a cloud
    bool lit_ = false;    // the first light is baked at once

    CaptureQueue queue_;
    InsidePictures inside_;
    double inside_units_ = 0.0, units_ = 0.0; // of work, this frame
    std::uint32_t taken_ = 0;                 // pictures that were completed
    std::vector<impostors::CaptureJob> done_;
    std::unordered_map<impostors::SlotId, Picture> pictures_;
    impostors::ScheduleReport schedule_;
    double capture_ms_ = 0.0;
    glm::dvec3 eye_before_m_{0.0};
    double motion_m_ = 0.0; // of the eye, a frame
    int frames_ = 0;
    double reuse_ = 1.0;   // smoothed
    double psnr_db_ = 0.0; // of the last comparison

    ImpostorRenderData data_, direct_data_;
    std::vector<ImpostorTile> tiles_, direct_tiles_;
    MeshBuilder builder_, direct_builder_;
    std::vector<ColorVertex> craft_triangles_, outline_vertices_;
    std::array<std::vector<glm::vec4>, 2> direct_texels_;
    std::uint64_t drawn_state_ = 0;
};

} // namespace alpenglow::sandbox
