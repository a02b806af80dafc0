// A free camera: where it stands, where it looks, and its matrices. Knows nothing of keys and windows.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// World frame: metres, +X east, +Y north, +Z up.
struct Camera {
    glm::vec3 position_m{0.0F};
    float yaw_rad = 0.0F;   // azimuth of the view axis, from north through east
    float pitch_rad = 0.0F; // above the horizon, clamped to +-89 degrees by turn()
    float fov_y_rad = 0.9F; // full vertical angle of view
    float near_m = 1.0F;
    float far_m = 200000.0F;

    [[nodiscard]] glm::vec3 forward() const;
    [[nodiscard]] glm::vec3 right() const; // level
    [[nodiscard]] glm::vec3 up() const;

    // View space: +X right, +Y up, -Z forward.
    [[nodiscard]] glm::mat4 view() const;
    // Vulkan clip space: y down, depth 0 at near_m to 1 at far_m.
    [[nodiscard]] glm::mat4 projection(float aspect) const;
    // Pixels per radian in the middle of an image of that height.
    [[nodiscard]] float pixels_per_radian(float image_height_px) const;

    // Turns by angles; yaw stays within +-pi.
    void turn(float yaw_rad, float pitch_rad);
    // Flies: `along` is (right, up, forward) in metres, up meaning the world's zenith.
    void move(glm::vec3 along_m);
    // Keeps the eye at least `clearance_m` above the ground.
    void stay_above(float ground_m, float clearance_m);
};

} // namespace alpenglow::sandbox
