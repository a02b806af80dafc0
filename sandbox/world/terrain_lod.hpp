// View-dependent triangulation of the terrain: a right-triangulated irregular network (longest-edge bisection) over
// both nested grids as one, chosen by error on the screen, without cracks, within a budget of triangles.
#pragma once

#include "render_data.hpp"
#include "terrain.hpp"
#include "upper_bound.hpp"

#include <alpenglow/core/system_report.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// What a view needs to know for the choice.
struct LodView {
    glm::vec3 camera_m{0.0F};
    glm::mat4 clip_from_world{1.0F};  // Vulkan clip space, depth 0 .. 1
    float pixels_per_radian = 800.0F; // at the middle of the image: height / (2 tan(fov / 2))
};

struct LodSettings {
    std::uint32_t max_triangles = 13500;
    float target_error_px = 1.0F; // no finer than this even where the budget would allow it
    float haze_m = 25000.0F;      // the allowed error grows by e over this distance: haze takes contrast away
    float move_m = 3.0F;          // the triangulation is kept while the camera has moved less
    float turn_rad = 0.07F;       // and turned less; what counts as in view is wider by as much
};

// What a vertex knows of the triangles that it splits.
struct LodBounds {
    std::vector<UpperBound> error_m;  // E(v); negative: never split
    std::vector<UpperBound> radius_m; // r(v)
};

// Vertices are numbered as in `WorldData::terrain`: the outer grid row by row, then the inner grid.
//
// A split vertex v, the middle of the long edge a-b of its triangles, carries E(v), a bound on the vertical distance
// between those two triangles and the finest surface under them: E(v) = |h(v) - (h(a) + h(b))/2| + max over its four
// child vertices of E, because replacing a triangle by its two halves moves the surface by at most the first term. It
// also carries the radius r(v) of a ball round v that holds the triangles and the balls of its children. Both shrink
// from parent to child, so that "E(v) / (distance - r(v)) > threshold" never holds for a child without holding for its
// parents: the mesh has no cracks, whatever the view (Lindstrom and Pascucci 2002).
//
// Finer samples exist in the inner square alone. A split vertex whose parents are missing is never used, which grades
// the resolution from 16 to 128 m towards the border without seams.
class TerrainLod {
public:
    // With `vertices` (of make_terrain_mesh), a vertex that differs from its neighbours in colour or normal counts as
    // an error too, in proportion to the edge that would hide it: E(v) is then the larger of the two bounds.
    explicit TerrainLod(const Terrain& terrain, std::span<const Vertex> vertices = {});
    // With bounds found before, one a vertex.
    TerrainLod(const Terrain& terrain, LodBounds bounds);

    // Rebuilds the triangulation if the view has changed enough; else keeps it. Returns what it did: `updated` is 1
    // after a rebuild, `error_bound` is the error on the screen in pixels, which a kept triangulation may exceed by the
    // camera's move.
    SystemReport update(const LodView& view, const LodSettings& settings);

    [[nodiscard]] std::span<const std::uint32_t> indices() const { return indices_; } // counter-clockwise from above
    [[nodiscard]] std::uint32_t revision() const { return revision_; }
    [[nodiscard]] float error_px() const { return error_px_; } // bound for the camera it was built at

    // A triangulation of the whole square that depends on no view: everything with E above `error_m`.
    [[nodiscard]] std::vector<std::uint32_t> coarse_indices(float error_m) const;

    // Height of the current triangulation's surface at a point (as if all of it were in view).
    [[nodiscard]] float surface_height_m(glm::vec2 position_m) const;

    [[nodiscard]] std::size_t vertex_count() const { return bounds_.error_m.size(); }
    [[nodiscard]] glm::vec3 position_m(std::uint32_t vertex) const;
    [[nodiscard]] float vertex_error_m(std::uint32_t vertex) const { return bounds_.error_m[vertex].value(); }
    [[nodiscard]] const LodBounds& bounds() const { return bounds_; }

private:
    // A sample by its virtual 16 m coordinates from the outer grid's south-west corner.
    struct Corner {
        glm::ivec2 at;
        std::uint32_t vertex;
        glm::vec3 position_m;
    };
    // Long edge a-b, right angle at c; counter-clockwise.
    struct Triangle {
        Corner a, b, c;
    };
    struct Threshold {
        glm::vec3 camera_m{0.0F};
        float ratio = 0.0F;    // allowed error over distance
        float per_haze = 0.0F; // 1 / haze_m
    };

    [[nodiscard]] std::int64_t vertex_of(glm::ivec2 p) const; // -1: no such sample
    [[nodiscard]] Corner corner(glm::ivec2 at) const;
    [[nodiscard]] std::array<Triangle, 2> roots() const;
    [[nodiscard]] std::int64_t split_vertex(const Triangle& triangle) const; // -1: a smallest triangle
    [[nodiscard]] bool active(std::uint32_t v, float distance_m, const Threshold& t) const;
    void bound_errors(std::span<const Vertex> vertices);
    // Triangulates what is in view into indices_; false, and no more, once there are more than `max_triangles`.
    bool build(const LodView& view, const LodSettings& settings, float threshold_px);

    const Terrain& terrain_;
    LodBounds bounds_;
    std::vector<std::uint32_t> indices_;
    std::uint32_t revision_ = 0;
    float error_px_ = 0.0F; // 0: nothing built yet
    Threshold threshold_{};
    LodView built_for_;
};

} // namespace alpenglow::sandbox
