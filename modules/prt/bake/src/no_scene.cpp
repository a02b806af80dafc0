// In place of scene.cpp in builds without Embree: there is no scene, and bakes by rays say so. Cube maps need none.
#include "scene.hpp"

namespace alpenglow::prt {

struct Scene::Impl {};

Scene::Scene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

Result<Scene> Scene::build(const Mesh& /*mesh*/, unsigned /*threads*/) {
    return Error{"this build has no ray tracer", "bake", "a build with Embree, or a bake by cube maps"};
}

// Never called: there is no scene.
void Scene::occluded(const glm::vec3& /*origin*/, const float* /*x*/, const float* /*y*/, const float* /*z*/,
                     std::size_t /*stride*/, std::size_t /*count*/, std::uint8_t* /*hit*/) const {}
void Scene::intersect(const glm::vec3& /*origin*/, std::span<const glm::vec3> /*directions*/,
                      SceneHit* /*hits*/) const {}

} // namespace alpenglow::prt
