// Scene `transfer`: things on a meadow whose light is baked, under the sky's light of the moment.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/components/transfer.hpp>
#include <alpenglow/core/system_report.hpp>
#include <alpenglow/ecs/registry.hpp>

#include "sandbox/app/part.hpp"
#include "sandbox/app/transfer_bakes.hpp"
#include "sandbox/app/transfer_light.hpp"
#include "sandbox/app/transfer_objects.hpp"
#include "sandbox/scene/transfer_settings.hpp"
#include "sandbox/world/transfer_render_data.hpp"

namespace alpenglow::sandbox {

class TransferScene final : public Part {
public:
    // Makes its entities in the stage's registry and starts to bake. `cache`: see TransferBakes.
    TransferScene(Stage& stage, const TransferSettings& settings, std::filesystem::path cache = cache_folder());
    ~TransferScene() override;
    TransferScene(const TransferScene&) = delete;
    TransferScene& operator=(const TransferScene&) = delete;

    // What the player may turn.
    TransferSettings settings;

    void begin(Stage& stage) override;
    void update(Stage& stage) override;
    void draw_panel(PanelWriter& panel) override;
    bool press(int key) override; // T: the next level
    void wait() override { bakes_->wait(); }

    // Null where nothing of it is in view.
    [[nodiscard]] const TransferRenderData* render_data() const { return visible_ ? &drawn_ : nullptr; }
    [[nodiscard]] TransferBakes::State bakes() const { return bakes_->state(); }
    [[nodiscard]] const TransferLight& light() const { return light_; }
    [[nodiscard]] std::size_t mound() const { return objects_.mound; }
    [[nodiscard]] std::size_t glider() const { return objects_.glider; }

private:
    using Entity = BasicRegistry::entity_type;
    static constexpr std::size_t no_job = std::numeric_limits<std::size_t>::max();
    // An entity that carries a table, and the tables that it may carry.
    struct Baked {
        Entity entity{};
        std::size_t job = no_job;
        bool taken = false;
        TransferTables tables;
        std::shared_ptr<const prt::TransferTable> meanwhile; // until the bake is done
    };
    struct Body {
        std::optional<Baked> diffuse, glossy;
        std::vector<BodyVertex> vertices;
        std::vector<std::uint32_t> indices;
        glm::quat turn{1.0F, 0.0F, 0.0F, 0.0F};
        glm::vec3 position_m{0.0F};
        std::array<float, 6> kernel{};
        std::vector<glm::vec3> light;                       // [vertex], as TransferBody::light
        std::vector<glm::vec3> diffuse_light, glossy_light; // for shaders
        // What `light` was made from.
        std::shared_ptr<const prt::TransferTable> diffuse_table, glossy_table;
        std::uint32_t diffuse_revision = 0, glossy_revision = 0, shade_revision = 0;
        glm::vec3 seen_from_m{std::numeric_limits<float>::quiet_NaN()};
        bool by_shader = false;
    };
    void add_body(TransferObject& object, std::vector<BakeJob>& jobs);
    template <class F>
    void each_baked(F&& f);
    void take_tables(bool by_shader);
    void light_all(const Stage& stage);
    void move_glider(double dt_s);
    bool shade_ground();
    bool shade(std::size_t body, const glm::vec3& camera_m, bool by_shader);
    void shade_on_cpu(Body& body, const TransferObject& object, const glm::vec3& camera_m);
    bool shade_smoke(const glm::vec3& camera_m);

    BasicRegistry& registry_;
    TransferObjects objects_;
    std::vector<Body> bodies_;
    std::optional<Baked> around_glider_, smoke_;
    Entity receiver_; // asks for the sky's bands
    std::unique_ptr<TransferBakes> bakes_;
    HorizonBytes horizon_{};
    bool visible_ = true;
    double moved_s_ = 0.0;
    bool glider_moved_ = true;

    TransferLight light_;
    std::uint32_t lit_by_ = 0;    // revision of the stage's light
    std::uint32_t lit_below_ = 0; // and of what clouds leave of it
    TransferWindow lit_through_ = TransferWindow::none;
    // Part of its light that the glider leaves to each vertex of the ground.
    std::vector<glm::vec3> left_;
    std::uint32_t left_revision_ = 0, left_from_ = 0;
    std::shared_ptr<const prt::TransferTable> left_table_;

    std::vector<SmokeVertex> smoke_vertices_;
    std::vector<std::uint32_t> smoke_indices_;
    std::uint32_t smoke_from_ = 0;
    glm::vec3 smoke_seen_from_m_{std::numeric_limits<float>::quiet_NaN()};
    std::vector<TransferBody> drawn_bodies_;
    TransferRenderData drawn_;
};

} // namespace alpenglow::sandbox
