// Which objects a view can see: in its frustum and no smaller than a pixel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

// A run of visible objects of one mesh.
struct ObjectRun {
    std::uint32_t mesh = 0;
    std::uint32_t first = 0; // in VisibleObjects::objects()
    std::uint32_t count = 0;
};

class VisibleObjects {
public:
    VisibleObjects() = default;
    explicit VisibleObjects(const WorldData& world);

    // Looks anew if the view has changed. True if the list has changed.
    bool update(const glm::mat4& clip_from_relative, glm::vec3 camera_m, float pixels_per_radian);

    [[nodiscard]] std::span<const std::uint32_t> objects() const { return visible_; } // indices into WorldData::objects
    [[nodiscard]] std::span<const ObjectRun> runs() const { return runs_; }

private:
    struct Ball {
        glm::vec3 centre_m{0.0F};
        float radius_m = 0.0F;
        std::uint32_t mesh = 0;
    };
    std::vector<Ball> balls_; // one an object
    std::vector<std::uint32_t> visible_;
    std::vector<ObjectRun> runs_;
    glm::mat4 clip_from_relative_{0.0F};
    glm::vec3 camera_m_{0.0F};
    float pixels_per_radian_ = 0.0F;
};

} // namespace alpenglow::sandbox
