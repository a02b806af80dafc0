#include "sandbox/render/visible_objects.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "sandbox/render/gpu_data.hpp"

namespace alpenglow::sandbox {
namespace {

Vertex point(glm::vec3 at) {
    Vertex vertex{};
    vertex.position_m = at;
    return vertex;
}

// Two meshes of points and many copies of each.
WorldData scattered_world() {
    WorldData world;
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (int mesh = 0; mesh < 2; ++mesh) {
        MeshData data;
        for (int i = 0; i < 12; ++i) {
            data.vertices.push_back(point({3.0F * unit(random), 3.0F * unit(random), 4.0F + 4.0F * unit(random)}));
        }
        world.object_meshes.push_back(data);
    }
    for (int i = 0; i < 400; ++i) {
        ObjectInstance object;
        object.mesh = i < 200 ? 0 : 1;
        object.world_from_object = glm::translate(
            glm::mat4(1.0F), glm::vec3(800.0F * unit(random), 800.0F * unit(random), 60.0F * unit(random)));
        object.world_from_object =
            glm::rotate(object.world_from_object, 3.0F * unit(random), glm::vec3(0.0F, 0.0F, 1.0F));
        object.world_from_object =
            glm::scale(object.world_from_object, glm::vec3(1.0F + 0.9F * unit(random), 1.0F, 1.5F));
        world.objects.push_back(object);
    }
    return world;
}

FrameData view_from(glm::vec3 camera_m, glm::vec3 along) {
    FrameData frame;
    frame.camera_m = camera_m;
    frame.view = glm::lookAtRH(camera_m, camera_m + along, glm::vec3(0.0F, 0.0F, 1.0F));
    frame.projection = glm::perspectiveRH_ZO(0.9F, 16.0F / 9.0F, 1.0F, 10000.0F);
    frame.projection[1][1] *= -1.0F;
    return frame;
}

// Whatever has a point in the picture is kept; what is kept may be a little too much, but not all.
TEST(VisibleObjectsTest, KeepsEverythingThatProjectsIntoTheImage) {
    const WorldData world = scattered_world();
    VisibleObjects visible(world);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (int i = 0; i < 60; ++i) {
        const FrameData frame = view_from({300.0F * unit(random), 300.0F * unit(random), 30.0F * unit(random)},
                                          glm::normalize(glm::vec3(unit(random), unit(random), 0.7F * unit(random))));
        const glm::mat4 clip = clip_from_relative(frame);
        visible.update(clip, frame.camera_m, 1e6F);
        EXPECT_LT(visible.objects().size(), world.objects.size());
        for (std::uint32_t object = 0; object < world.objects.size(); ++object) {
            const ObjectInstance& instance = world.objects[object];
            bool seen = false;
            for (const Vertex& vertex : world.object_meshes[instance.mesh].vertices) {
                const glm::vec3 at(instance.world_from_object * glm::vec4(vertex.position_m, 1.0F));
                const glm::vec4 p = clip * glm::vec4(at - frame.camera_m, 1.0F);
                seen = seen || (p.w > 0.0F && std::abs(p.x) <= p.w && std::abs(p.y) <= p.w);
            }
            const bool kept =
                std::find(visible.objects().begin(), visible.objects().end(), object) != visible.objects().end();
            ASSERT_TRUE(!seen || kept) << "object " << object << ", view " << i;
        }
    }
}

TEST(VisibleObjectsTest, LeavesOutWhatIsBehindOrSmallerThanAPixel) {
    WorldData world;
    MeshData mesh;
    mesh.vertices = {point({-1.0F, 0.0F, 0.0F}), point({1.0F, 0.0F, 0.0F})};
    world.object_meshes.push_back(mesh);
    for (const float y : {50.0F, -50.0F, 3000.0F}) {
        ObjectInstance object;
        object.world_from_object = glm::translate(glm::mat4(1.0F), glm::vec3(0.0F, y, 0.0F));
        world.objects.push_back(object);
    }
    VisibleObjects visible(world);
    const FrameData frame = view_from({0.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F});
    EXPECT_TRUE(visible.update(clip_from_relative(frame), frame.camera_m, 600.0F));
    ASSERT_EQ(visible.objects().size(), 1U);
    EXPECT_EQ(visible.objects()[0], 0U);
}

TEST(VisibleObjectsTest, RunsFollowTheMeshesAndAnUnchangedViewDoesNothing) {
    const WorldData world = scattered_world();
    VisibleObjects visible(world);
    const FrameData frame = view_from({0.0F, 0.0F, 20.0F}, {1.0F, 0.0F, 0.0F});
    const glm::mat4 clip = clip_from_relative(frame);
    EXPECT_TRUE(visible.update(clip, frame.camera_m, 600.0F));
    EXPECT_FALSE(visible.update(clip, frame.camera_m, 600.0F));
    std::uint32_t next = 0;
    for (const ObjectRun& run : visible.runs()) {
        EXPECT_EQ(run.first, next);
        for (std::uint32_t i = 0; i < run.count; ++i) {
            EXPECT_EQ(world.objects[visible.objects()[run.first + i]].mesh, run.mesh);
        }
        next += run.count;
    }
    EXPECT_EQ(next, visible.objects().size());
}

} // namespace
} // namespace alpenglow::sandbox
