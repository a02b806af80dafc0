// Points of heightfields and lightmaps, for bake_points: the "SH lightmap".
#pragma once

#include <alpenglow/prt/bake.hpp>

namespace alpenglow::prt {

// Texel centres of a map over the mesh's texture coordinates (0 .. 1, row 0 at v = 0): positions and normals of the
// triangle that covers each, zero normals where none does. Points are row by row.
[[nodiscard]] Result<BakePoints> lightmap_points(const Mesh& mesh, std::size_t width, std::size_t height);

// Fills texels that nobody covers from their neighbours, `rings` texels out, so that filtering at the borders of
// charts stays sound.
void dilate(TransferField& field, const BakePoints& points, std::size_t width, std::size_t rings);

} // namespace alpenglow::prt
