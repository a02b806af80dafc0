// Domains to their ends and past them, with floating-point traps on.
#include "test_terrain.hpp"

#include <fp_traps.hpp>

#include <sandbox/world/camera.hpp>
#include <sandbox/world/horizon.hpp>
#include <sandbox/world/object_shadows.hpp>
#include <sandbox/world/terrain_lod.hpp>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace alpenglow::sandbox {
namespace {

TEST(WorldStress, HorizonsOfExtremeGround) {
    const test::FpTraps traps;
    for (const float height : {0.0F, 1e-6F, 9000.0F, 1e6F, -1e6F}) {
        for (const int n : {2, 3, 7, 40}) {
            HeightGrid grid = make_grid(n, 16.0F);
            for (std::size_t k = 0; k < grid.height_m.size(); ++k) {
                grid.height_m[k] = (k * 7919U) % 5U == 0U ? height : 0.0F;
            }
            for (const HorizonBytes& bytes : compute_horizons(grid, nullptr)) {
                const float visible = sky_visibility(bytes);
                EXPECT_GE(visible, -1e-6F);
                EXPECT_LE(visible, 1.0F + 1e-6F);
            }
        }
    }
    for (float tangent = 1e-30F; tangent < 1e30F; tangent *= 3.0F) {
        EXPECT_LE(decode_horizon_rad(encode_horizon(tangent)), 1.5708F);
    }
}

TEST(WorldStress, LevelOfDetailFromAnywhere) {
    const test::FpTraps traps;
    const Terrain& terrain = rough_terrain();
    TerrainLod lod(terrain);
    const LodSettings settings;
    const glm::vec3 positions[] = {{0.0F, 0.0F, 0.0F},          {0.0F, 0.0F, -5000.0F},     {0.0F, 0.0F, 150000.0F},
                                   {-65536.0F, 65536.0F, 5.0F}, {500000.0F, 0.0F, 3000.0F}, lod.position_m(12345)};
    for (const glm::vec3& p : positions) {
        for (const float pitch : {-1.553F, 0.0F, 1.553F}) {
            Camera camera;
            camera.position_m = p;
            camera.pitch_rad = pitch;
            (void)lod.update({p, camera.projection(1.0F) * camera.view(), camera.pixels_per_radian(100.0F)}, settings);
            EXPECT_LE(lod.indices().size() / 3, settings.max_triangles);
            EXPECT_TRUE(std::isfinite(lod.surface_height_m(glm::vec2(p))));
        }
    }
}

TEST(WorldStress, ShadowsOfEverySun) {
    const test::FpTraps traps;
    std::vector<ObjectMesh> meshes;
    for (std::uint32_t k = 0; k < object_kinds; ++k) {
        meshes.push_back(make_object_mesh(static_cast<ObjectKind>(k)));
    }
    std::vector<ObjectInstance> objects(object_kinds);
    for (std::uint32_t k = 0; k < object_kinds; ++k) {
        objects[k].mesh = k;
        objects[k].world_from_object[3] = glm::vec4(9.0F * static_cast<float>(k), 0.0F, 0.0F, 1.0F);
    }
    const TerrainLod lod = flat_lod();
    ObjectShadows shadows(meshes, objects);
    for (const float elevation : {-1.5708F, -0.01F, 0.0F, 1e-7F, 0.021F, 0.3F, 1.2F, 1.5707963F}) {
        for (const float azimuth : {0.0F, 1.5707963F, 4.0F}) {
            for (const float radius : {0.0F, 4.65e-3F, 0.3F}) {
                const glm::vec3 to_light(std::sin(azimuth) * std::cos(elevation),
                                         std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
                ShadowInput input{glm::normalize(to_light), radius, {20.0F, -30.0F, 5.0F}};
                (void)shadows.update(input, lod);
                for (const ShadowVertex& v : shadows.vertices()) {
                    ASSERT_TRUE(v.shade >= 0.0F && v.shade <= 1.0F);
                }
                EXPECT_LT(shadows.indices().size() / 3, 20000U);
            }
        }
    }
}

} // namespace
} // namespace alpenglow::sandbox
