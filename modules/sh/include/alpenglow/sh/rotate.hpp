// Rotation of coefficient vectors. Rotating f by R gives g(d) = f(R^-1 d): a lobe along d moves to R d.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

namespace alpenglow::sh {

// The block-diagonal matrix of one rotation, made once and applied to many vectors. Ivanic and Ruedenberg (1996, with
// the 1998 corrections) in double from the direction matrix: polynomial in its entries, so that there is no angle to
// lose digits at, however small the tilt. Error of an applied rotation relative to the vector's norm: 1e-14 in double,
// 1.5e-7 in float. Do not rotate a rotated vector again and again: keep the source and compose quaternions.
class Rotation {
public:
    // The quaternion need not be normalised; a zero or non-finite one is misuse. order 1 .. max_order.
    Rotation(int order, const glm::dquat& rotation);
    // An orthogonal matrix, reflections included.
    Rotation(int order, const glm::dmat3& directions);

    [[nodiscard]] int order() const noexcept { return order_; }

    // Row m, column n of band l: g_l^m = sum_n element(l, m, n) f_l^n.
    [[nodiscard]] double element(int l, int m, int n) const noexcept {
        return elements_[static_cast<std::size_t>(band_offset(l) + (m + l) * (2 * l + 1) + n + l)];
    }
    // Rows of band l, (2l+1)^2 elements, from band_offset(l) on.
    [[nodiscard]] std::span<const double> elements() const noexcept { return elements_; }
    [[nodiscard]] static constexpr int band_offset(int l) noexcept { return l * (4 * l * l - 1) / 3; }

    // in and out may be the same vector, and must not overlap otherwise.
    void apply(std::span<const double> in, std::span<double> out) const noexcept;
    void apply(std::span<const float> in, std::span<float> out) const noexcept;
    void apply(std::span<const glm::vec3> in, std::span<glm::vec3> out) const noexcept;
    void apply(std::span<const glm::dvec3> in, std::span<glm::dvec3> out) const noexcept;

private:
    int order_;
    std::vector<double> elements_;
};

// Rotation about +Z by `angle_rad` (from +X towards +Y): mixes only the pairs m, -m. Habel et al. 2008, eq. 4.
// in and out may be the same vector.
void rotate_z(int order, double angle_rad, std::span<const double> in, std::span<double> out) noexcept;
void rotate_z(int order, double angle_rad, std::span<const float> in, std::span<float> out) noexcept;
void rotate_z(int order, double angle_rad, std::span<const glm::vec3> in, std::span<glm::vec3> out) noexcept;
void rotate_z(int order, double angle_rad, std::span<const glm::dvec3> in, std::span<glm::dvec3> out) noexcept;

} // namespace alpenglow::sh
