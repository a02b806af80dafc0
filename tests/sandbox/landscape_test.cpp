// The generated landscape as a whole. Tests share few, long bodies because each generates it anew.
#include <sandbox/scene/scene.hpp>
#include <sandbox/world/horizon.hpp>
#include <sandbox/world/vertex.hpp>
#include <sandbox/world/world.hpp>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <sys/wait.h>
#include <unistd.h>

namespace alpenglow::sandbox {
namespace {

std::uint64_t hash_of(const Terrain& terrain) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (const std::vector<float>* heights : {&terrain.inner.height_m, &terrain.outer.height_m}) {
        for (const float h : *heights) {
            std::uint32_t bits = 0;
            std::memcpy(&bits, &h, sizeof bits);
            hash = (hash ^ bits) * 1099511628211ULL;
        }
    }
    return hash;
}

TEST(Landscape, IsTheSameWhateverTheThreadCount) {
    // The thread count is read once a process: ask two children.
    std::uint64_t hashes[2] = {1, 2};
    for (int k = 0; k < 2; ++k) {
        int ends[2];
        ASSERT_EQ(pipe(ends), 0);
        const pid_t child = fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            setenv("ALPENGLOW_THREADS", k == 0 ? "1" : "3", 1);
            const std::uint64_t hash = hash_of(generate_terrain(default_seed));
            _exit(write(ends[1], &hash, sizeof hash) == sizeof hash ? 0 : 1);
        }
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        ASSERT_EQ(status, 0);
        ASSERT_EQ(read(ends[0], &hashes[k], sizeof hashes[k]), static_cast<ssize_t>(sizeof hashes[k]));
        close(ends[0]);
        close(ends[1]);
    }
    EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Landscape, IsAlpineAndFitsTogether) {
    const std::unique_ptr<World> world = build_world();
    const Terrain& terrain = world->terrain;

    // A valley floor at 500 to 900 m between peaks of 2 to 3 km, and higher ones on the horizon.
    const auto [low, high] = std::minmax_element(terrain.inner.height_m.begin(), terrain.inner.height_m.end());
    EXPECT_GT(*low, 500.0F);
    EXPECT_LT(*low, 900.0F);
    EXPECT_GT(*high, 2000.0F);
    EXPECT_LT(*high, 3200.0F);
    EXPECT_LT(*std::max_element(terrain.outer.height_m.begin(), terrain.outer.height_m.end()), 4500.0F);
    for (const float h : terrain.outer.height_m) {
        ASSERT_TRUE(std::isfinite(h));
    }

    // The two grids agree where both have samples, and along the inner border.
    const int first = (Terrain::samples - 1) / 2 - (Terrain::samples - 1) / 2 / Terrain::ratio;
    for (int j = 0; j < Terrain::samples; j += Terrain::ratio) {
        for (int i = 0; i < Terrain::samples; i += Terrain::ratio) {
            ASSERT_EQ(terrain.inner.at(i, j), terrain.outer.at(first + i / Terrain::ratio, first + j / Terrain::ratio));
        }
    }
    for (int k = 0; k < Terrain::samples; ++k) {
        const float a = terrain.inner.at(k, 0);
        const float b = terrain.inner.at(0, k);
        EXPECT_NEAR(a, sample_bilinear(terrain.outer, terrain.inner.position_m(k, 0)), 0.1F);
        EXPECT_NEAR(b, sample_bilinear(terrain.outer, terrain.inner.position_m(0, k)), 0.1F);
    }

    // Vertices: unit normals, albedo within what ground reflects, the lake level and dark.
    ASSERT_EQ(world->data.terrain.vertices.size(), world->lod->vertex_count());
    for (std::size_t k = 0; k < world->data.terrain.vertices.size(); k += 97) {
        const Vertex& v = world->data.terrain.vertices[k];
        EXPECT_EQ(v.position_m, world->lod->position_m(static_cast<std::uint32_t>(k)));
        const glm::vec3 n = unpack_normal(v.normal);
        EXPECT_NEAR(glm::length(n), 1.0F, 0.02F);
        EXPECT_GT(n.z, 0.0F);
        const glm::vec3 albedo = unpack_albedo(v.albedo);
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(albedo[c], 0.0F);
            EXPECT_LE(albedo[c], 0.91F);
        }
    }
    int water = 0;
    for (int j = 0; j < Terrain::samples; ++j) {
        for (int i = 0; i < Terrain::samples; ++i) {
            if (lake_distance_m(terrain.inner.position_m(i, j)) < 0.0F) {
                ++water;
                ASSERT_EQ(terrain.inner.at(i, j), lake_height_m());
            }
        }
    }
    EXPECT_GT(water, 1000);

    // Objects stand on the ground, sorted by mesh, and know the horizon there.
    const std::vector<ObjectInstance>& objects = world->data.objects;
    EXPECT_GT(objects.size(), 40U);
    for (std::size_t k = 0; k < objects.size(); ++k) {
        const glm::vec3 foot(objects[k].world_from_object[3]);
        EXPECT_NEAR(foot.z, terrain.height_m(glm::vec2(foot)), 1.0F);
        EXPECT_LT(objects[k].mesh, world->data.object_meshes.size());
        EXPECT_TRUE(k == 0 || objects[k - 1].mesh <= objects[k].mesh);
    }

    // Every scene's camera stands free above the ground, and its view keeps the budget.
    for (const std::string& name : builtin_scene_names()) {
        const Result<Scene> scene = load_scene(name);
        ASSERT_TRUE(scene) << scene.error().message();
        const Camera camera = scene_camera(*scene);
        const float ground = terrain.height_m(glm::vec2(camera.position_m));
        EXPECT_GT(camera.position_m.z, ground + 1.5F) << name;
        EXPECT_LT(camera.position_m.z, ground + 1500.0F) << name;
        const LodSettings settings;
        (void)world->lod->update(
            {camera.position_m, camera.projection(16.0F / 9.0F) * camera.view(), camera.pixels_per_radian(540.0F)},
            settings);
        EXPECT_LE(world->lod->indices().size() / 3, settings.max_triangles) << name;
    }
}

} // namespace
} // namespace alpenglow::sandbox
