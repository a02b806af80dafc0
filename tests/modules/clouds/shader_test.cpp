// shaders/alpenglow/cloud.glsl, compiled as C++: the CPU's picture from the CPU's tables.
#include "clouds_test_support.hpp"

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/shader_tables.hpp>

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <gtest/gtest.h>

namespace {

std::vector<std::uint32_t> volume_words;
std::vector<std::uint32_t> light_words;
std::vector<std::uint32_t> view_words;
std::vector<std::uint32_t> detail_words;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
namespace shader {
using glm::abs, glm::asin, glm::ceil, glm::clamp, glm::dot, glm::exp, glm::floor, glm::log, glm::max, glm::min,
    glm::mix;
using glm::sqrt, glm::uint, glm::uintBitsToFloat, glm::vec3;
inline uint cloud_volume_word(uint index) {
    return volume_words[index];
}
inline uint cloud_light_word(uint index) {
    return light_words[index];
}
inline uint cloud_view_word(uint index) {
    return view_words[index];
}
inline uint cloud_detail_word(uint index) {
    return detail_words[index];
}
#include <alpenglow/cloud.glsl>
} // namespace shader
#pragma GCC diagnostic pop

using namespace alpenglow;
using namespace alpenglow::clouds;

// Without detail and with it, still and drifting, in steps of one length and in growing ones.
std::vector<MarchSettings> ways(const DetailTexture& detail) {
    MarchSettings plain;
    MarchSettings detailed;
    detailed.detail = &detail;
    detailed.detail_strength = 2.0F;
    detailed.detail_cells = 2.0F;
    MarchSettings drifting = detailed;
    drifting.detail_offsets = detail_drift(37.0, 100.0);
    drifting.optical_step = 0.25F;
    drifting.stop_transmittance = 4e-3F;
    return {plain, detailed, drifting};
}

TEST(CloudShader, DrawsTheCpusPicture) {
    SparseGrid grid = noise_cloud(81, 30);
    GridTransform transform;
    transform.voxel_m = {2.0, 1.5, 1.0};
    transform.origin_m = {100.0, -50.0, 20.0};
    grid.set_transform(transform);
    const BrickVolume volume(grid);
    const DetailTexture detail;
    volume_words = pack_volume(volume);
    detail_words = pack_detail(detail);
    for (const LightingMethod method : {LightingMethod::harris, LightingMethod::transport}) {
        LightingSettings settings;
        settings.method = method;
        CloudLighting lighting;
        lighting.reset(volume, {0.3F, 0.98F, {}}, settings);
        lighting.bake_light(0, {test::unit({0.2F, 0.4F, 0.8F}), glm::vec3(10.0F, 9.0F, 8.0F), 0.0F});
        lighting.bake_light(1, {test::unit({-0.2F, -0.4F, 0.3F}), glm::vec3(0.2F, 0.3F, 0.8F), 0.0F});
        lighting.bake_sky(SkySh::uniform(glm::vec3(0.3F, 0.5F, 1.0F)));
        light_words = pack_light(volume, lighting);
        const glm::dvec3 centre = transform.world_from_index({15, 15, 15});
        for (const MarchSettings& way : ways(detail)) {
            for (const glm::dvec3& eye : {centre + glm::dvec3(-90, -30, 40), centre, centre + glm::dvec3(0, 0, 90)}) {
                const Camera camera = look_at(eye, centre + glm::dvec3(1.0, 0.5, 0.0), 0.4F, 21, 15);
                const Picture cpu = march(volume, lighting, camera, way);
                view_words = pack_view(volume, lighting, lighting.contract(transform.index_from_world(eye)), way);
                for (int y = 0; y < 15; ++y) {
                    for (int x = 0; x < 21; ++x) {
                        const glm::vec3 direction(transform.local_direction(
                            glm::dvec3(camera.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F))));
                        const auto ray = shader::alpenglow_cloud_march(shader_eye(volume, eye), direction,
                                                                       direction / glm::vec3(transform.voxel_m), 1e30F);
                        const std::size_t pixel = std::size_t(y) * 21 + std::size_t(x);
                        for (int k = 0; k < 3; ++k) {
                            ASSERT_NEAR(ray.radiance[k], cpu.radiance[pixel][k],
                                        2e-3F * cpu.radiance[pixel][k] + 2e-4F);
                        }
                        ASSERT_NEAR(ray.transmittance, cpu.transmittance[pixel], 1e-4F);
                        ASSERT_NEAR(ray.depth, cpu.depth_m[pixel], 1e-2F * cpu.depth_m[pixel] + 1e-2F);
                    }
                }
            }
        }
    }
}

} // namespace
