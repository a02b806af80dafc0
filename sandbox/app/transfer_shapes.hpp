// Meshes of the scene `transfer` that alpenglow/prt/shapes.hpp does not have. Metres, +Z up, normals and albedo filled.
#pragma once

#include <functional>

#include <glm/vec3.hpp>

#include <alpenglow/prt/mesh.hpp>

namespace alpenglow::sandbox {

// A standing figure 1.9 m tall on a plinth of half a metre: a robe in folds, one arm raised with a ball, one hand on
// the hip. Looks towards -Y. `cell_m`: about the length of an edge.
[[nodiscard]] prt::Mesh make_figure(float cell_m);

// A round slab, its upper face at z = 0, from `hole_m` (0: none) to `radius_m`, with rings of `around` vertices.
[[nodiscard]] prt::Mesh make_disc(float radius_m, float thickness_m, int around, int rings,
                                  const std::function<glm::vec3(float radius_m)>& albedo);

// A tube along a torus knot (2, 3) that stands upright on z = 0, of height about 2 `size_m`.
[[nodiscard]] prt::Mesh make_knot(float size_m, float tube_m, int along, int across, const glm::vec3& albedo);

// A band that lies on z = 0: inner and outer wall and the rim between them.
[[nodiscard]] prt::Mesh make_ring(float inner_m, float outer_m, float height_m, int around, int up,
                                  const glm::vec3& albedo);

// A bowl on a foot, open above.
[[nodiscard]] prt::Mesh make_brazier(int around, const glm::vec3& albedo);

// A glider of span 2 `half_m`, nose towards +Y: white, with red tips.
[[nodiscard]] prt::Mesh make_glider(float half_m, int divisions);

// A mesh whose triangles are cut into four, `times` times.
[[nodiscard]] prt::Mesh subdivided(prt::Mesh mesh, int times);

void paint(prt::Mesh& mesh, const glm::vec3& albedo);

// The zero surface of a signed distance in a box (dual contouring on a regular grid, vertices at the mean of the edges'
// crossings and then drawn onto the surface: naive surface nets, Gibson 1998).
[[nodiscard]] prt::Mesh surface_nets(const std::function<float(const glm::vec3&)>& distance_m, const glm::vec3& low_m,
                                     const glm::vec3& high_m, float cell_m);

} // namespace alpenglow::sandbox
