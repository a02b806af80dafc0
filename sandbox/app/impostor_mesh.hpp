// From pictures to the meshes that they are drawn on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/clouds/view.hpp>
#include <alpenglow/impostors/capture.hpp>

#include "sandbox/world/impostor_render_data.hpp"

namespace alpenglow::sandbox {

inline constexpr int kMeshCell = 8; // texels a side of a mesh's cells: CaptureSettings::warp_cell

// One layer of a picture as a grid of nodes on its rays, at the depth that its warp has there.
struct PictureMesh {
    std::vector<glm::vec3> places;    // relative to `origin_m`
    std::vector<glm::vec2> texels;    // of the picture
    std::vector<std::uint16_t> cells; // lower-index corners of cells with anything to see, as node numbers
    int across = 0;                   // nodes a row
    glm::dvec3 origin_m{0.0};
};

[[nodiscard]] PictureMesh picture_mesh(const impostors::Capture& capture, std::size_t layer,
                                       const glm::dvec3& origin_m);

// The same of clouds marched directly: nodes at the least depth around them, so that nothing near is lost in the rough.
[[nodiscard]] PictureMesh picture_mesh(const clouds::Picture& picture, const impostors::Frustum& view);

// For pictures that are used again: nodes at the mean depth around them, as what is seen moves on the screen, but no
// nearer than `least_m`: the fog next to the eye has nothing that could be seen to move, and would tear the mesh off
// the view's rim.
[[nodiscard]] PictureMesh mean_depth_mesh(const clouds::Picture& picture, const impostors::Frustum& view,
                                          double least_m);

// Where another picture shows a place, in its texels; clamped to its rim, which is transparent.
[[nodiscard]] glm::vec2 texel_in(const impostors::Frustum& view, const glm::dvec3& place_m);

// A part of a layer between two depths from the eye: it is drawn there, and with that share of its optical depth.
struct DepthPart {
    glm::dvec3 eye_m{0.0};
    glm::dvec3 forward{0.0, 1.0, 0.0};
    double near_m = 0.0, far_m = 1e30;
    float share = 1.0F;
};

// Where the picture that goes is, if any: `before` null for none.
struct Fade {
    const impostors::Frustum* before = nullptr;
    glm::vec2 before_tile{0.0F}; // its upper left corner in the atlas
    float weight = 1.0F;         // of the new
};

// Collects runs of triangles, from far to near.
class MeshBuilder {
public:
    void clear();
    void add(const PictureMesh& mesh, const glm::vec2& tile, float weight, const Fade& fade, const DepthPart* part);

    [[nodiscard]] std::span<const ImpostorVertex> vertices() const { return vertices_; }
    [[nodiscard]] std::span<const std::uint32_t> indices() const { return indices_; }
    [[nodiscard]] std::span<const ImpostorRun> runs() const { return runs_; }

private:
    std::vector<ImpostorVertex> vertices_;
    std::vector<std::uint32_t> indices_;
    std::vector<ImpostorRun> runs_;
};

} // namespace alpenglow::sandbox
