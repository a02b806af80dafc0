// The sky's clouds: modelled from the weather or read from files, lit by the systems, drifting with the wind, drawn by
// the CPU's march.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/clouds/bricks.hpp>
#include <alpenglow/components/cloud.hpp>

#include "sandbox/app/cloud_covers.hpp"
#include "sandbox/app/cloud_reference.hpp"
#include "sandbox/app/cloud_shadow_map.hpp"
#include "sandbox/app/cloud_view.hpp"
#include "sandbox/app/part.hpp"
#include "sandbox/scene/cloud_settings.hpp"
#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {

class CloudScene final : public Part {
public:
    // Makes the clouds. What cannot be read is left out, with a message to the stage.
    CloudScene(Stage& stage, const CloudSettings& settings);
    ~CloudScene() override;
    CloudScene(const CloudScene&) = delete;
    CloudScene& operator=(const CloudScene&) = delete;

    void relight(Stage& stage) override;
    void update(Stage& stage) override;
    void draw_panel(PanelWriter& panel) override;
    bool show_reference(bool reference) override; // every ray of the picture, where it has some of earlier ones
    void compared(double psnr_db) override { psnr_db_ = psnr_db; }

    [[nodiscard]] const CloudRenderData& render_data() const { return drawn_; }
    [[nodiscard]] std::size_t clouds() const { return entities_.size(); }
    // All clouds where they are drawn: those of layers several times, for layers repeat.
    [[nodiscard]] std::vector<clouds::LitCloud> lit_clouds(const glm::dvec3& around_m) const;

    // Against the stored reference, of the light as it is; none without one, or with the sun elsewhere.
    void measure_error();
    [[nodiscard]] const std::optional<clouds::ImageError>& error() const { return error_; }

    // The light that the clouds stand in, as of the last update.
    [[nodiscard]] const clouds::CloudSources& sources() const { return sources_; }

    CloudSettings settings;
    CloudView view;

private:
    using Entity = BasicRegistry::entity_type;
    struct Item {
        Entity entity;
        double repeat_m = 0.0; // of a layer; 0: stands alone
        glm::dvec3 home_m{0.0};
    };
    void add(std::shared_ptr<const clouds::BrickVolume> volume, const CloudMatter& matter, double repeat_m);
    void drift(double dt_s);
    void update_shadow(const Stage& stage);
    void shade(Stage& stage);
    void measure_sky(const Stage& stage);
    bool shade_layers(const Stage& stage);
    void cover_places(Stage& stage);
    void show(const clouds::Picture& picture, std::uint32_t revision);

    BasicRegistry& registry_;
    std::vector<Item> entities_;
    glm::dvec3 drifted_m_{0.0};
    double time_s_ = 0.0;    // that the scene's clock has run
    bool device_ = false;    // there is one that can march
    bool too_large_ = false; // for it
    bool first_frame_ = true;
    std::uint32_t light_revision_ = 0;
    std::vector<std::uint32_t> light_revisions_; // of each entity's CloudLight, as of the last look
    double model_s_ = 0.0;                       // CPU time of modelling and reading
    double march_ms_ = 0.0;                      // of the last picture
    double bake_ms_ = 0.0;                       // of update_clouds, the last frame that it worked
    float covered_ = 0.0F;                       // of the screen
    CloudRenderData drawn_;
    clouds::Picture reference_picture_;
    double psnr_db_ = 0.0;
    clouds::CloudSources sources_;
    std::optional<CloudReference> reference_;
    std::optional<clouds::ImageError> error_; // against it, of `error_light_`
    std::uint32_t error_light_ = 0;
    glm::vec3 layers_from_{0.0F}; // direction of the light that layers shade each other from
    CloudShadowMaker shadow_;
    CloudCovers covers_;
    glm::vec3 shadow_from_{0.0F};    // direction of the light that the shadow was made for
    std::uint32_t shadow_light_ = 0; // light_revision_ likewise
    // The light of the scene below the clouds.
    SceneLight clear_light_;        // without them
    std::uint32_t stage_light_ = 0; // Stage::light_revision as this part has left it
    glm::vec3 shaded_from_{0.0F};   // direction of the sun that it was made for
    bool shaded_ = false;
    std::array<glm::vec3, 16> below_{}; // radiance seen below the clouds, SH, with a clear sky of below_clear_ on Y_0^0
    glm::vec3 below_clear_{1.0F};
    glm::vec3 air_light_{1.0F};
};

} // namespace alpenglow::sandbox
