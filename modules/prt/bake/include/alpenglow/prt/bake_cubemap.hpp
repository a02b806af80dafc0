// Occlusion by rendering a cube map at every vertex, as in "Spherical Harmonics Lighting" (the demo page, 2011): a
// baker for machines without a ray tracer. Parts join with `finish`, like ray-traced ones, to the same kind of file.
#pragma once

#include <alpenglow/prt/bake.hpp>

#include <functional>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::prt {

// Draws the mesh around each eye: texel (face * resolution + y) * resolution + x of each cube, one cube after the
// other, gets the triangle that its middle sees first, or no_triangle. Face 2 axis + (negative ? 1 : 0); the direction
// of texel (x, y) has 1 or -1 on `axis`, (2 x + 1) / resolution - 1 on the next axis and likewise y on the one after.
inline constexpr std::uint32_t no_triangle = 0xFFFFFFFFU;
using CubeRasteriser = std::function<Status(std::span<const glm::vec3> eyes_m, std::span<std::uint32_t> triangles)>;

// Vertices [first, first + count), moved along their normals as a ray's origin is (the page's near plane), on cube
// faces of resolution^2 texels, 4 .. 128. settings.rays, max_error and sampling do not matter here; gather hits are
// read from the cube at the directions that rays would take. Mirrors are an Error. The mesh is rasterised on the CPU,
// at a cost per vertex that grows with the number of triangles; on a device: bake_cubemap_vulkan.hpp.
[[nodiscard]] Result<BakePart> bake_part_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution,
                                                 std::size_t first, std::size_t count);
// The same by a rasteriser of another kind, which gets `batch` eyes at a time.
[[nodiscard]] Result<BakePart> bake_part_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution,
                                                 std::size_t first, std::size_t count, const CubeRasteriser& rasteriser,
                                                 std::size_t batch);

// All vertices, joined.
[[nodiscard]] Result<Bake> bake_cubemap(const Mesh& mesh, const BakeSettings& settings, std::size_t resolution = 32);

} // namespace alpenglow::prt
