// What is wrong with a mesh, before any ray is shot.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/prt/mesh.hpp>

#include <cstddef>

namespace alpenglow::prt {

struct MeshReport {
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::size_t degenerate_triangles = 0; // no area: ignored
    std::size_t isolated_vertices = 0;    // in no proper triangle: baked dark
    std::size_t bad_normals = 0;          // zero, not unit or not finite: replaced by the triangles' mean
};

// Errors for what no bake can use: no triangle, NaN or infinite positions, indices out of range, arrays of wrong
// length, coordinates past 1e15, nothing but degenerate triangles.
[[nodiscard]] Result<MeshReport> validate(const Mesh& mesh);

} // namespace alpenglow::prt
