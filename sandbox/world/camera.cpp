#include "camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace alpenglow::sandbox {

glm::vec3 Camera::forward() const {
    const float c = std::cos(pitch_rad);
    return {c * std::sin(yaw_rad), c * std::cos(yaw_rad), std::sin(pitch_rad)};
}

glm::vec3 Camera::right() const {
    return {std::cos(yaw_rad), -std::sin(yaw_rad), 0.0F};
}

glm::vec3 Camera::up() const {
    const float s = std::sin(pitch_rad);
    return {-s * std::sin(yaw_rad), -s * std::cos(yaw_rad), std::cos(pitch_rad)};
}

glm::mat4 Camera::view() const {
    const glm::vec3 r = right();
    const glm::vec3 u = up();
    const glm::vec3 f = forward();
    const auto along = [&](glm::vec3 axis) {
        return -(axis.x * position_m.x + axis.y * position_m.y + axis.z * position_m.z);
    };
    return {glm::vec4(r.x, u.x, -f.x, 0.0F), glm::vec4(r.y, u.y, -f.y, 0.0F), glm::vec4(r.z, u.z, -f.z, 0.0F),
            glm::vec4(along(r), along(u), -along(f), 1.0F)};
}

glm::mat4 Camera::projection(float aspect) const {
    const float scale = 1.0F / std::tan(0.5F * fov_y_rad);
    const float depth = far_m / (near_m - far_m);
    return {glm::vec4(scale / aspect, 0.0F, 0.0F, 0.0F), glm::vec4(0.0F, -scale, 0.0F, 0.0F),
            glm::vec4(0.0F, 0.0F, depth, -1.0F), glm::vec4(0.0F, 0.0F, near_m * depth, 0.0F)};
}

float Camera::pixels_per_radian(float image_height_px) const {
    return 0.5F * image_height_px / std::tan(0.5F * fov_y_rad);
}

void Camera::turn(float yaw, float pitch) {
    constexpr float turn_rad = 2.0F * std::numbers::pi_v<float>;
    yaw_rad = std::remainder(yaw_rad + yaw, turn_rad);
    constexpr float limit = 89.0F / 180.0F * std::numbers::pi_v<float>;
    pitch_rad = std::clamp(pitch_rad + pitch, -limit, limit);
}

void Camera::move(glm::vec3 along_m) {
    position_m += along_m.x * right() + along_m.z * forward() + glm::vec3(0.0F, 0.0F, along_m.y);
}

void Camera::stay_above(float ground_m, float clearance_m) {
    position_m.z = std::max(position_m.z, ground_m + clearance_m);
}

} // namespace alpenglow::sandbox
