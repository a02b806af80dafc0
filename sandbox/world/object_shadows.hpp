// Shadows that objects throw on the ground, without shadow maps: the fraction of the sun's disc that an object hides,
// found analytically at the vertices of small grids draped over the terrain.
#pragma once

#include "object_meshes.hpp"
#include "render_data.hpp"
#include "terrain_lod.hpp"

#include <alpenglow/core/system_report.hpp>

#include <span>
#include <vector>

namespace alpenglow::sandbox {

// Fraction of a uniform disc that a half-plane hides; x is the distance of the disc's centre from the edge in radii,
// negative behind it: 1 at -1, 1/2 at 0, 0 at 1.
[[nodiscard]] float hidden_disc_fraction(float x) noexcept;

struct ShadowInput {
    glm::vec3 to_light{0.0F, 0.0F, 1.0F}; // sun or moon, whichever is the stronger
    float angular_radius_rad = 4.65e-3F;
    glm::vec3 camera_m{0.0F};
};

struct ShadowSettings {
    float light_move_rad = 1.7e-3F; // rebuilt when the light has moved farther (0.1 degrees: 24 s of the sun's path)
    float camera_move_m = 150.0F;   // or the camera
    float reach_m = 1400.0F;        // objects farther from the camera get none
    float cell_m = 0.7F;            // grid cells, growing with distance and with the length of the shadow
    float max_length_m = 160.0F;    // at a low sun
};

class ObjectShadows {
public:
    // Objects that stand closer together than 25 m share a grid. The references stay with the caller.
    ObjectShadows(const std::vector<ObjectMesh>& meshes, const std::vector<ObjectInstance>& objects);

    // Rebuilds the grids if light or camera have moved enough; lays them on the terrain again if its triangulation has
    // changed. `updated` counts grids rebuilt or laid.
    SystemReport update(const ShadowInput& input, const TerrainLod& lod, const ShadowSettings& settings = {});

    [[nodiscard]] std::span<const ShadowVertex> vertices() const { return vertices_; }
    [[nodiscard]] std::span<const std::uint32_t> indices() const { return indices_; }
    [[nodiscard]] std::uint32_t revision() const { return revision_; }

    // The fraction of the light's disc that objects hide from a point.
    [[nodiscard]] float shade(glm::vec3 position_m, const ShadowInput& input) const;

private:
    struct Group {
        std::vector<std::uint32_t> objects;
        glm::vec3 centre_m{0.0F};
        float radius_m = 0.0F;
        float height_m = 0.0F;
    };
    // A convex solid seen from the light: its outline in the plane across the light, and how far along the light each
    // corner stands.
    struct Outline {
        std::vector<glm::vec3> corners; // (across, up, along), counter-clockwise
        glm::vec2 low{0.0F};
        glm::vec2 high{0.0F};
        float area_m2 = 0.0F;
    };
    struct LightFrame {
        glm::vec3 across, up, along;
    };
    [[nodiscard]] static LightFrame light_frame(glm::vec3 to_light);
    [[nodiscard]] std::vector<Outline> outlines(const Group& group, const LightFrame& frame) const;
    [[nodiscard]] static float shade(const std::vector<Outline>& outlines, glm::vec3 seen, float tangent, float blur_m);
    void build(const ShadowInput& input, const TerrainLod& lod, const ShadowSettings& settings);

    const std::vector<ObjectMesh>& meshes_;
    const std::vector<ObjectInstance>& objects_;
    std::vector<Group> groups_;
    std::vector<ShadowVertex> vertices_;
    std::vector<std::uint32_t> indices_;
    std::uint32_t revision_ = 0;
    std::uint32_t lod_revision_ = 0;
    std::uint32_t grids_ = 0;
    bool built_ = false;
    ShadowInput built_for_;
};

} // namespace alpenglow::sandbox
