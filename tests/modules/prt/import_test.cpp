#include <alpenglow/prt/import_mesh.hpp>

#include <gtest/gtest.h>

#include <fstream>

#include <unistd.h>

namespace alpenglow::prt {
namespace {

class Import : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("alpenglow_import_" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::filesystem::path write(const char* name, const std::string& text) {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    std::filesystem::path folder_;
};

TEST_F(Import, ReadsObj) {
    const auto path = write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    const Result<Mesh> mesh = import_mesh(path, {.y_up = false});
    ASSERT_TRUE(mesh) << mesh.error().message();
    EXPECT_EQ(mesh->triangles.size(), 2U);
    EXPECT_EQ(mesh->positions.size(), 4U);
    for (const glm::vec3& n : mesh->normals) {
        EXPECT_NEAR(n.z, 1.0F, 1e-6F);
    }
    const Result<Mesh> turned = import_mesh(path);
    ASSERT_TRUE(turned);
    for (const glm::vec3& n : turned->normals) {
        EXPECT_NEAR(n.y, -1.0F, 1e-6F); // the file's +Z comes to -Y
    }
}

TEST_F(Import, ReadsGltf) {
    // One triangle, positions in a data URI: (0,0,0), (1,0,0), (0,1,0).
    const auto path = write("a.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"translation":[0,0,5]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","max":[1,1,0],"min":[0,0,0]}]})");
    const Result<Mesh> mesh = import_mesh(path, {.y_up = false});
    ASSERT_TRUE(mesh) << mesh.error().message();
    ASSERT_EQ(mesh->triangles.size(), 1U);
    for (const glm::vec3& p : mesh->positions) {
        EXPECT_NEAR(p.z, 5.0F, 1e-6F); // the node's transform is applied
    }
}

TEST_F(Import, RefusesWhatIsNoMesh) {
    EXPECT_FALSE(import_mesh(folder_ / "missing.obj"));
    EXPECT_FALSE(import_mesh(folder_));
    EXPECT_FALSE(import_mesh(write("empty.obj", "")));
    EXPECT_FALSE(import_mesh(write("points.obj", "v 0 0 0\nv 1 0 0\n")));
    EXPECT_FALSE(import_mesh(write("cut.gltf", R"({"asset":{"version":"2.0"},"scene":0,)")));
    EXPECT_FALSE(import_mesh(write("cut.glb", "glTF\x02")));
    EXPECT_FALSE(import_mesh(write("noise.obj", std::string(1000, '\xA7'))));
    EXPECT_FALSE(import_mesh(write("unknown.xyzw", "hello")));
}

} // namespace
} // namespace alpenglow::prt
