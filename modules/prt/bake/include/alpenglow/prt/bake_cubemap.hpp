// Occlusion by rendering a cube map at every vertex, as in "Spherical Harmonics Lighting" (the demo page, 2011): a
// baker for machines without a ray tracer. Parts join with `finish`, like ray-traced ones, to the same kind of file.
#pragma once

#include <alpenglow/prt/bake.hpp>

namespace alpenglow::prt {

// The mesh rasterised on the CPU around vertices [first, first + count), moved along their normals as a ray's origin is
// (the page's near plane), on cube faces of resolution^2 texels, 4 .. 128, depth and triangle per texel. Cost per
// vertex grows with the number of triangles. settings.rays, max_error and sampling do not matter here; gather hits are
// read from the cube at the directions that rays would take. Mirrors are an Error.
[[nodiscard]] Result<BakePart> bake_part_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution,
                                                 std::size_t first, std::size_t count);

// All vertices, joined.
[[nodiscard]] Result<Bake> bake_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution = 32);

} // namespace alpenglow::prt
