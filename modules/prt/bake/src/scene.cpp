#include "scene.hpp"

#include <embree3/rtcore.h>

#include <cfenv>
#include <limits>
#include <string>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace alpenglow::prt {
namespace {

// Embree wants denormals flushed and divides by zero on purpose.
class EmbreeFloatMode {
public:
#if defined(__SSE__)
    EmbreeFloatMode() : saved_(_mm_getcsr()) {
        _mm_setcsr((saved_ | 0x9F80U) & ~0x3FU);
    }
    ~EmbreeFloatMode() {
        _mm_setcsr(saved_);
    }
#else
    EmbreeFloatMode() {
        std::feholdexcept(&saved_);
    }
    ~EmbreeFloatMode() {
        std::fesetenv(&saved_);
    }
#endif
    EmbreeFloatMode(const EmbreeFloatMode&) = delete;
    EmbreeFloatMode& operator=(const EmbreeFloatMode&) = delete;

private:
#if defined(__SSE__)
    unsigned saved_;
#else
    std::fenv_t saved_{};
#endif
};

} // namespace

struct Scene::Impl {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    ~Impl() {
        if (scene != nullptr) {
            rtcReleaseScene(scene);
        }
        if (device != nullptr) {
            rtcReleaseDevice(device);
        }
    }
};

Scene::Scene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

Result<Scene> Scene::build(const Mesh& mesh, unsigned threads) {
    const EmbreeFloatMode mode;
    auto impl = std::make_unique<Impl>();
    const std::string config = threads == 0 ? std::string() : "threads=" + std::to_string(threads);
    impl->device = rtcNewDevice(config.c_str());
    if (impl->device == nullptr) {
        return Error{"Embree device: error " + std::to_string(rtcGetDeviceError(nullptr)), "bake", ""};
    }
    impl->scene = rtcNewScene(impl->device);
    rtcSetSceneFlags(impl->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(impl->scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(impl->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree's own copies: shared buffers would need padding behind the mesh's last vertex.
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.positions.size()));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    if (positions == nullptr || indices == nullptr) {
        rtcReleaseGeometry(geometry);
        return Error{"out of memory for " + std::to_string(mesh.triangles.size()) + " triangles", "bake", ""};
    }
    for (const glm::vec3& p : mesh.positions) {
        *positions++ = p.x;
        *positions++ = p.y;
        *positions++ = p.z;
    }
    for (const glm::uvec3& t : mesh.triangles) {
        *indices++ = t.x;
        *indices++ = t.y;
        *indices++ = t.z;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(impl->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(impl->scene);
    if (const RTCError error = rtcGetDeviceError(impl->device); error != RTC_ERROR_NONE) {
        return Error{"Embree: error " + std::to_string(error) + " while building", "bake", ""};
    }
    return Scene(std::move(impl));
}

void Scene::occluded(const glm::vec3& origin, const float* x, const float* y, const float* z, std::size_t stride,
                     std::size_t count, std::uint8_t* hit) const {
    const EmbreeFloatMode mode;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = 0; i < count; ++i) {
        alignas(16) RTCRay ray;
        ray.org_x = origin.x;
        ray.org_y = origin.y;
        ray.org_z = origin.z;
        ray.tnear = 0.0F;
        ray.dir_x = x[i * stride];
        ray.dir_y = y[i * stride];
        ray.dir_z = z[i * stride];
        ray.time = 0.0F;
        ray.tfar = std::numeric_limits<float>::infinity();
        ray.mask = 0xFFFFFFFFU;
        ray.id = 0;
        ray.flags = 0;
        rtcOccluded1(impl_->scene, &context, &ray);
        hit[i] = ray.tfar < 0.0F ? 1 : 0;
    }
}

void Scene::intersect(const glm::vec3& origin, std::span<const glm::vec3> directions, SceneHit* hits) const {
    const EmbreeFloatMode mode;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = 0; i < directions.size(); ++i) {
        alignas(16) RTCRayHit ray;
        ray.ray.org_x = origin.x;
        ray.ray.org_y = origin.y;
        ray.ray.org_z = origin.z;
        ray.ray.tnear = 0.0F;
        ray.ray.dir_x = directions[i].x;
        ray.ray.dir_y = directions[i].y;
        ray.ray.dir_z = directions[i].z;
        ray.ray.time = 0.0F;
        ray.ray.tfar = std::numeric_limits<float>::infinity();
        ray.ray.mask = 0xFFFFFFFFU;
        ray.ray.id = 0;
        ray.ray.flags = 0;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(impl_->scene, &context, &ray);
        SceneHit& hit = hits[i];
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
            hit = SceneHit{};
            continue;
        }
        hit.triangle = ray.hit.primID;
        hit.u = ray.hit.u;
        hit.v = ray.hit.v;
        hit.distance_m = ray.ray.tfar;
        hit.back =
            ray.hit.Ng_x * directions[i].x + ray.hit.Ng_y * directions[i].y + ray.hit.Ng_z * directions[i].z > 0.0F;
    }
}

} // namespace alpenglow::prt
