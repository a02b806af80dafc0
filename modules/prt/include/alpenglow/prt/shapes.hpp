// Procedural meshes for scenes, tests and benchmarks. All face outwards, with normals computed.
#pragma once

#include <alpenglow/prt/mesh.hpp>

#include <functional>

namespace alpenglow::prt {

// A sphere about the origin, each of the icosahedron's faces cut into `divisions`^2 triangles; 10 divisions^2 + 2
// vertices.
[[nodiscard]] Mesh sphere(float radius_m, int divisions);
// The same, seen from inside.
[[nodiscard]] Mesh inverted(Mesh mesh);
// The plane z = 0, |x|, |y| <= half_m, facing +Z, `cells`^2 squares.
[[nodiscard]] Mesh plane(float half_m, int cells);
// A box of half sizes `half_m`, `cells`^2 squares a face, edges not shared (flat normals).
[[nodiscard]] Mesh box(const glm::vec3& half_m, int cells);
// A torus about +Z.
[[nodiscard]] Mesh torus(float major_m, float minor_m, int around, int across);
// A bowl: the lower half of a sphere, seen from inside, open at the top.
[[nodiscard]] Mesh bowl(float radius_m, int around, int down);
// A figure: stacked, blended limbs of a standing body from a radius function, folds and all, concave in many places.
// vertices is approximate.
[[nodiscard]] Mesh figure(int vertices);
// z = height(x, y) over |x|, |y| <= half_m.
[[nodiscard]] Mesh heightfield(float half_m, int cells, const std::function<float(float, float)>& height);
// A delta wing of span 2 half_m, thickness and all, nose towards +Y.
[[nodiscard]] Mesh glider(float half_m);
// One mesh from two.
[[nodiscard]] Mesh merged(Mesh a, const Mesh& b, const glm::vec3& shift_of_b_m = glm::vec3(0.0F));

} // namespace alpenglow::prt
