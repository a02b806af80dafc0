// A walled courtyard with an arcade on the valley floor: boxes, the light that they leave to a point, and their mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "sandbox/world/horizon.hpp"
#include "sandbox/world/probe_render_data.hpp"
#include "sandbox/world/world.hpp"

namespace alpenglow::sandbox {

// What lights the yard.
struct YardLight {
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    glm::vec3 sun_lux{0.0F}; // on surfaces that face it
    glm::vec3 moon_lux{0.0F};
    std::array<glm::mat4, 3> irradiance_matrix{}; // sky and open ground, as FrameData
};

class Yard {
public:
    static constexpr glm::vec3 albedo{0.075F, 0.068F,
                                      0.06F}; // of its stone: dark, so that shadows need their light from the sky

    explicit Yard(const World& world);

    // The middle of the floor; the yard reaches 8 m east and west of it, 6 m north and 5.5 m south.
    [[nodiscard]] glm::vec3 middle_m() const { return middle_m_; }

    [[nodiscard]] bool is_solid(const glm::vec3& point_m) const;
    // Whether walls or mountains stand before a direction.
    [[nodiscard]] bool hides(const glm::vec3& point_m, const glm::vec3& direction) const;
    // Fraction of a small box around a point, half as wide as `reach_m`, from which a light in that direction is seen;
    // what is inside walls does not count.
    [[nodiscard]] float visibility(const glm::vec3& point_m, const glm::vec3& reach_m, const glm::vec3& to_light) const;

    // Appends the mesh in this light. Visibilities are traced anew where a light has moved by a quarter of a degree.
    void append_mesh(const YardLight& light, std::vector<ColorVertex>& vertices, std::vector<std::uint32_t>& indices);

private:
    struct Box {
        glm::vec3 low_m, high_m;
        float cell_m; // of its mesh
    };
    struct Corner {
        glm::vec3 position_m, normal;
        glm::vec3 spread_m; // half the cell, within the face
        float shade;        // variation of the stone, around 1
        float open;         // part of the light of sky and ground that walls leave
        float sun = 0.0F, moon = 0.0F;
    };
    void make_corners(const Box& box);
    [[nodiscard]] bool walls_hide(const glm::vec3& point_m, const glm::vec3& direction) const;
    [[nodiscard]] float openness(const glm::vec3& point_m, const glm::vec3& normal) const;
    [[nodiscard]] float lit_part(const Corner& corner, const glm::vec3& to_light) const;

    glm::vec3 middle_m_{0.0F};
    HorizonBytes horizon_{};
    std::vector<Box> boxes_;
    std::vector<Corner> corners_;
    std::vector<std::uint32_t> indices_;
    glm::vec3 traced_to_sun_{0.0F}, traced_to_moon_{0.0F};
};

// Evenly spread unit vectors (a Fibonacci lattice).
[[nodiscard]] glm::vec3 lattice_direction(int i, int count);

} // namespace alpenglow::sandbox
