#include "sandbox/render/visible_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "sandbox/render/frustum.hpp"

namespace alpenglow::sandbox {
VisibleObjects::VisibleObjects(const WorldData& world) {
    std::vector<Ball> meshes; // around the middle of the bounding box
    for (const MeshData& mesh : world.object_meshes) {
        Ball ball;
        if (!mesh.vertices.empty()) {
            glm::vec3 low = mesh.vertices.front().position_m;
            glm::vec3 high = low;
            for (const Vertex& vertex : mesh.vertices) {
                low = glm::min(low, vertex.position_m);
                high = glm::max(high, vertex.position_m);
            }
            ball.centre_m = 0.5F * (low + high);
            for (const Vertex& vertex : mesh.vertices) {
                ball.radius_m = std::max(ball.radius_m, glm::distance(ball.centre_m, vertex.position_m));
            }
        }
        meshes.push_back(ball);
    }
    balls_.reserve(world.objects.size());
    for (const ObjectInstance& object : world.objects) {
        const Ball& mesh = meshes[object.mesh];
        const glm::mat4& m = object.world_from_object;
        const float scale =
            std::max({glm::length(glm::vec3(m[0])), glm::length(glm::vec3(m[1])), glm::length(glm::vec3(m[2]))});
        balls_.push_back({glm::vec3(m * glm::vec4(mesh.centre_m, 1.0F)), mesh.radius_m * scale, object.mesh});
    }
}

bool VisibleObjects::update(const glm::mat4& clip_from_relative, glm::vec3 camera_m, float pixels_per_radian) {
    if (clip_from_relative == clip_from_relative_ && camera_m == camera_m_ && pixels_per_radian == pixels_per_radian_) {
        return false;
    }
    clip_from_relative_ = clip_from_relative;
    camera_m_ = camera_m;
    pixels_per_radian_ = pixels_per_radian;
    const std::array<glm::vec3, 4> planes = side_planes(clip_from_relative);
    std::vector<std::uint32_t> visible;
    runs_.clear();
    for (std::uint32_t i = 0; i < balls_.size(); ++i) {
        const Ball& ball = balls_[i];
        const glm::vec3 relative = ball.centre_m - camera_m;
        const bool inside = std::all_of(planes.begin(), planes.end(), [&](const glm::vec3& plane) {
            return glm::dot(plane, relative) >= -ball.radius_m;
        });
        const bool large = 2.0F * ball.radius_m * pixels_per_radian >= glm::length(relative); // a pixel across
        if (!inside || !large) {
            continue;
        }
        if (runs_.empty() || runs_.back().mesh != ball.mesh) {
            runs_.push_back({ball.mesh, static_cast<std::uint32_t>(visible.size()), 0});
        }
        ++runs_.back().count;
        visible.push_back(i);
    }
    const bool changed = visible != visible_;
    visible_ = std::move(visible);
    return changed;
}

} // namespace alpenglow::sandbox
