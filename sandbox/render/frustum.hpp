// The planes of a view.
#pragma once

#include <array>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// The planes of the frustum's sides, pointing inwards, unit normals: a point p is inside where dot(n, p) >= 0, p being
// relative to the camera, which all four contain.
[[nodiscard]] inline std::array<glm::vec3, 4> side_planes(const glm::mat4& clip_from_relative) {
    const auto row = [&](glm::length_t r) {
        return glm::vec3(clip_from_relative[0][r], clip_from_relative[1][r], clip_from_relative[2][r]);
    };
    return {glm::normalize(row(3) + row(0)), glm::normalize(row(3) - row(0)), glm::normalize(row(3) + row(1)),
            glm::normalize(row(3) - row(1))};
}

} // namespace alpenglow::sandbox
