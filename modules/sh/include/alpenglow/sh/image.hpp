// Projection of environment images: cube maps and equirectangular maps, RGB, as floats one pixel after the other.
//
// Each pixel counts as constant over its own solid angle. What a pixel contributes is the integral of the basis over
// it, which for equirectangular maps is computed exactly, and for cube maps by `supersampling` points a side, each with
// its exact solid angle.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/sh/basis.hpp>

#include <array>
#include <span>
#include <vector>

namespace alpenglow::sh {

// Faces in the order +X, -X, +Y, -Y, +Z, -Z, each size*size pixels, rows from the top, three floats a pixel, oriented
// as in OpenGL and Vulkan: on +X the column runs towards -Z and the row towards -Y, on +Z column +X and row -Y, and so
// on.
struct CubeMap {
    std::array<std::span<const float>, 6> faces;
    int size = 0; // pixels a side
};

// The unit direction through a point of a face; s and t run from -1 to 1 with columns and rows.
[[nodiscard]] glm::dvec3 cube_direction(int face, double s, double t) noexcept;

// The solid angle of the rectangle [s0, s1] x [t0, t1] of a face, exact: the faces sum to 4 pi.
[[nodiscard]] double cube_solid_angle(double s0, double s1, double t0, double t1) noexcept;

// Longitude from -pi to pi with the columns (0, in the middle, is +X, and +Y is to its right), latitude from +pi/2 (+Z)
// down with the rows; three floats a pixel.
struct EquirectMap {
    std::span<const float> pixels;
    int width = 0, height = 0;
};

// Projects cube maps of one size again and again. The integrals of the basis over every pixel are tabulated once, for
// one octant (the reflections x, y, z -> -x, -y, -z give the others their signs), so that supersampling costs nothing
// per image and eight pixels cost one multiplication a coefficient. Tables: 3 (size/2)^2 order^2 floats. From 128 pixels
// a side on and without supersampling only solid angles and distances are tabulated, 2 (size/2)^2 floats: evaluating the
// basis is then faster than fetching it.
class CubeProjector {
public:
    // size 1 .. 16384, order 1 .. max_order, supersampling 1 .. 64.
    [[nodiscard]] static Result<CubeProjector> make(int size, int order, int supersampling = 1);

    // Radiance coefficients, order*order of them. A pixel that is NaN or infinite counts as black; the number of such
    // pixels is returned. Error in float: 1e-6 of the mean radiance; constants stay constant to that.
    [[nodiscard]] Result<std::size_t> project(const CubeMap& map, std::span<glm::vec3> out) const;

    [[nodiscard]] int size() const noexcept { return size_; }
    [[nodiscard]] int order() const noexcept { return order_; }

private:
    CubeProjector() = default;
    int size_ = 0, order_ = 0, supersampling_ = 1;
    std::size_t row_ = 0;       // floats a row of the octant, padded
    std::vector<float> table_;  // [axis][coefficient][row][column], or [1 / distance, solid angle][row][column]
    std::vector<float> centre_; // of rows and columns, 0 .. 1, where the table is of the second kind
};

// One image, with a projector made for it; and an equirectangular map, whose pixel integrals are cheap. As above.
[[nodiscard]] Result<std::size_t> project(const CubeMap& map, int order, std::span<glm::vec3> out,
                                          int supersampling = 1);
[[nodiscard]] Result<std::size_t> project(const EquirectMap& map, int order, std::span<glm::vec3> out);

// The straightforward loops in double: the reference of the above.
[[nodiscard]] Result<std::size_t> project_reference(const CubeMap& map, int order, std::span<glm::dvec3> out,
                                                    int supersampling = 1);
[[nodiscard]] Result<std::size_t> project_reference(const EquirectMap& map, int order, std::span<glm::dvec3> out,
                                                    int supersampling = 1);

} // namespace alpenglow::sh
