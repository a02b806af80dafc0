// Rays against a mesh. The one place that knows Embree is scene.cpp.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/prt/mesh.hpp>

#include <cstdint>
#include <memory>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::prt {

struct SceneHit {
    static constexpr std::uint32_t none = 0xFFFFFFFFU;
    std::uint32_t triangle = none;
    float u = 0.0F; // barycentric: (1 - u - v) a + u b + v c
    float v = 0.0F;
    float distance_m = 0.0F;
    bool back = false; // the triangle's back was hit
};

// Built once, then read from any thread. Floating-point traps of the caller are masked while Embree works.
class Scene {
public:
    [[nodiscard]] static Result<Scene> build(const Mesh& mesh, unsigned threads);
    Scene(Scene&&) noexcept;
    Scene& operator=(Scene&&) noexcept;
    ~Scene();

    // hit[i] = 1 where the ray from origin along (x[i stride], y[i stride], z[i stride]) meets the mesh.
    void occluded(const glm::vec3& origin, const float* x, const float* y, const float* z, std::size_t stride,
                  std::size_t count, std::uint8_t* hit) const;
    void occluded(const glm::vec3& origin, std::span<const glm::vec3> directions, std::uint8_t* hit) const {
        if (!directions.empty()) {
            occluded(origin, &directions[0].x, &directions[0].y, &directions[0].z, 3, directions.size(), hit);
        }
    }
    // The nearest hit of each ray.
    void intersect(const glm::vec3& origin, std::span<const glm::vec3> directions, SceneHit* hits) const;

private:
    struct Impl;
    explicit Scene(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

} // namespace alpenglow::prt
