#include <alpenglow/sh/rotate.hpp>

#include "rotation_tables.hpp"

#include <array>
#include <cmath>

namespace alpenglow::sh {
namespace {

glm::dmat3 matrix_of(const glm::dquat& q) {
    const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    assert(norm2 > 0.0 && std::isfinite(norm2));
    // Scaled by 2 / |q|^2, so that the result is orthogonal to rounding whatever the quaternion's length.
    const double s = 2.0 / norm2;
    const double xx = s * q.x * q.x, yy = s * q.y * q.y, zz = s * q.z * q.z;
    const double xy = s * q.x * q.y, xz = s * q.x * q.z, yz = s * q.y * q.z;
    const double wx = s * q.w * q.x, wy = s * q.w * q.y, wz = s * q.w * q.z;
    return {1.0 - yy - zz, xy + wz, xz - wy, xy - wz, 1.0 - xx - zz, yz + wx, xz + wy, yz - wx, 1.0 - xx - yy};
}

template <class Real, class Value>
void apply_blocks(const Rotation& rotation, std::span<const Value> in, std::span<Value> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(rotation.order()));
    assert(in.size() >= count && out.size() >= count);
    static_cast<void>(count);
    out[0] = in[0];
    const double* block = rotation.elements().data() + 1;
    for (int l = 1; l < rotation.order(); ++l) {
        const int width = 2 * l + 1;
        const auto first = static_cast<std::size_t>(l * l);
        std::array<Value, 2 * max_order - 1> source;
        for (int n = 0; n < width; ++n) {
            source[static_cast<std::size_t>(n)] = in[first + static_cast<std::size_t>(n)];
        }
        for (int m = 0; m < width; ++m) {
            Value sum(0);
            for (int n = 0; n < width; ++n) {
                sum += source[static_cast<std::size_t>(n)] * static_cast<Real>(*block++);
            }
            out[first + static_cast<std::size_t>(m)] = sum;
        }
    }
}

template <class Real, class Value>
void turn_pairs(int order, double angle_rad, std::span<const Value> in, std::span<Value> out) noexcept {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && in.size() >= count && out.size() >= count);
    static_cast<void>(count);
    for (int m = 0; m < order; ++m) {
        const Real c = static_cast<Real>(std::cos(m * angle_rad));
        const Real s = static_cast<Real>(std::sin(m * angle_rad));
        for (int l = m; l < order; ++l) {
            const auto plus = static_cast<std::size_t>(index(l, m));
            const auto minus = static_cast<std::size_t>(index(l, -m));
            if (m == 0) {
                out[plus] = in[plus];
            } else {
                const Value a = in[plus];
                const Value b = in[minus];
                out[plus] = a * c - b * s;
                out[minus] = a * s + b * c;
            }
        }
    }
}

} // namespace

Rotation::Rotation(int order, const glm::dquat& rotation) : Rotation(order, matrix_of(rotation)) {}

Rotation::Rotation(int order, const glm::dmat3& d) : order_(order) {
    assert(order >= 1 && order <= max_order);
    elements_.resize(static_cast<std::size_t>(band_offset(order)));
    constexpr int axis[3] = {1, 2, 0};
    double r[3][3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            r[i][j] = d[axis[j]][axis[i]];
        }
    }
    detail::rotation_blocks(order, r, elements_.data());
}

void Rotation::apply(std::span<const double> in, std::span<double> out) const noexcept {
    apply_blocks<double>(*this, in, out);
}
void Rotation::apply(std::span<const float> in, std::span<float> out) const noexcept {
    apply_blocks<float>(*this, in, out);
}
void Rotation::apply(std::span<const glm::vec3> in, std::span<glm::vec3> out) const noexcept {
    apply_blocks<float>(*this, in, out);
}
void Rotation::apply(std::span<const glm::dvec3> in, std::span<glm::dvec3> out) const noexcept {
    apply_blocks<double>(*this, in, out);
}

void rotate_z(int order, double angle_rad, std::span<const double> in, std::span<double> out) noexcept {
    turn_pairs<double>(order, angle_rad, in, out);
}
void rotate_z(int order, double angle_rad, std::span<const float> in, std::span<float> out) noexcept {
    turn_pairs<float>(order, angle_rad, in, out);
}
void rotate_z(int order, double angle_rad, std::span<const glm::vec3> in, std::span<glm::vec3> out) noexcept {
    turn_pairs<float>(order, angle_rad, in, out);
}
void rotate_z(int order, double angle_rad, std::span<const glm::dvec3> in, std::span<glm::dvec3> out) noexcept {
    turn_pairs<double>(order, angle_rad, in, out);
}

} // namespace alpenglow::sh
