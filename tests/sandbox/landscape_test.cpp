// The landscape as a whole, from the file that the build has generated.
#include <sandbox/scene/scene.hpp>
#include <sandbox/world/horizon.hpp>
#include <sandbox/world/landscape_file.hpp>
#include <sandbox/world/vertex.hpp>
#include <sandbox/world/world.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

namespace alpenglow::sandbox {
namespace {

class Landscape : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        Result<std::unique_ptr<World>> read = read_landscape(built_landscape());
        ASSERT_TRUE(read) << read.error().message();
        world_ = std::move(read).value();
    }
    static void TearDownTestSuite() { world_.reset(); }
    static inline std::unique_ptr<World> world_;
};

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

// The name of the first part in which two worlds differ; empty if they are the same bit for bit.
std::string difference(const World& a, const World& b) {
    const auto same_grid = [](const HeightGrid& x, const HeightGrid& y) {
        return x.n == y.n && x.spacing_m == y.spacing_m && x.origin_m == y.origin_m &&
               same_bits(x.height_m, y.height_m);
    };
    const auto same_object = [](const ObjectInstance& x, const ObjectInstance& y) {
        return x.world_from_object == y.world_from_object && x.horizon == y.horizon && x.mesh == y.mesh;
    };
    const auto same_place = [](const TerrainGrid& x, const TerrainGrid& y) {
        return x.first_vertex == y.first_vertex && x.samples == y.samples && x.spacing_m == y.spacing_m &&
               x.origin_m == y.origin_m;
    };
    const WorldData& d = a.data;
    const WorldData& e = b.data;
    if (a.terrain.seed != b.terrain.seed || !same_grid(a.terrain.outer, b.terrain.outer) ||
        !same_grid(a.terrain.inner, b.terrain.inner) || !same_bits(a.terrain.inner_area_m2, b.terrain.inner_area_m2) ||
        !same_bits(a.terrain.outer_area_m2, b.terrain.outer_area_m2)) {
        return "terrain";
    }
    if (!same_bits(d.terrain.vertices, e.terrain.vertices)) {
        return "vertices";
    }
    if (a.lod->bounds().error_m != b.lod->bounds().error_m || a.lod->bounds().radius_m != b.lod->bounds().radius_m) {
        return "level of detail";
    }
    if (!same_bits(d.terrain.indices, e.terrain.indices)) {
        return "indices";
    }
    if (!std::equal(d.terrain_grids.begin(), d.terrain_grids.end(), e.terrain_grids.begin(), e.terrain_grids.end(),
                    same_place)) {
        return "grids";
    }
    if (!std::equal(d.objects.begin(), d.objects.end(), e.objects.begin(), e.objects.end(), same_object)) {
        return "objects";
    }
    return d.object_meshes.size() == e.object_meshes.size() ? "" : "object meshes";
}

TEST_F(Landscape, FileHoldsWhatIsGeneratedWhateverTheThreadCount) {
    // The build generated with the default thread count, which is read once a process: a child generates with another.
    const std::string threads = std::to_string(parallel_threads() + 1);
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        setenv("ALPENGLOW_THREADS", threads.c_str(), 1);
        const std::string differs = difference(*build_world(), *world_);
        _exit(write(ends[1], differs.data(), differs.size()) == static_cast<ssize_t>(differs.size()) ? 0 : 1);
    }
    close(ends[1]);
    char differs[64] = {};
    EXPECT_GE(read(ends[0], differs, sizeof differs - 1), 0);
    close(ends[0]);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_STREQ(differs, "");
}

// A damaged copy of the landscape's file, removed in the end.
class Damaged {
public:
    explicit Damaged(std::uintmax_t bytes) : path_(::testing::TempDir() + "landscape-" + std::to_string(getpid())) {
        std::ifstream from(built_landscape(), std::ios::binary);
        std::string content(std::min(bytes, std::filesystem::file_size(built_landscape())), '\0');
        from.read(content.data(), static_cast<std::streamsize>(content.size()));
        std::ofstream(path_, std::ios::binary) << content;
    }
    ~Damaged() { std::filesystem::remove(path_); }
    Damaged(const Damaged&) = delete;
    Damaged& operator=(const Damaged&) = delete;

    void flip(std::streamoff at) {
        std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
        file.seekg(at);
        const int byte = file.get();
        file.seekp(at);
        file.put(static_cast<char>(byte ^ 1));
    }
    [[nodiscard]] std::string read_error(std::uint32_t seed = default_seed) const {
        const auto world = read_landscape(path_, seed);
        return world ? "" : world.error().message();
    }
    [[nodiscard]] const std::string& path() const { return path_; }

private:
    std::string path_;
};

void expect_said(const std::string& message, const std::string& text) {
    EXPECT_NE(message.find(text), std::string::npos) << message;
}

TEST_F(Landscape, DamagedFilesAreRefusedByName) {
    const std::uintmax_t whole = std::filesystem::file_size(built_landscape());
    EXPECT_FALSE(read_landscape("no/such/landscape.bin"));
    EXPECT_FALSE(read_landscape(std::filesystem::temp_directory_path())); // a folder
    expect_said(Damaged(0).read_error(), "size: is 0 bytes");
    expect_said(Damaged(63).read_error(), "size: is 63 bytes");
    expect_said(Damaged(64).read_error(), "size: is 64 bytes");
    expect_said(Damaged(64).read_error(default_seed + 1), "seed: is 1 (expected 2)");
    const struct {
        std::streamoff at;
        const char* says;
    } flips[] = {{0, "magic"}, {8, "version: is 0 (expected 1)"}, {12, "header checksum"}, {48, "header checksum"}};
    for (const auto& flip : flips) {
        Damaged file(64);
        file.flip(flip.at);
        expect_said(file.read_error(), flip.says);
        expect_said(file.read_error(), file.path());
    }
    Damaged file(whole);
    EXPECT_EQ(file.read_error(), "");
    const auto last = static_cast<std::streamoff>(whole) - 1;
    file.flip(last);
    expect_said(file.read_error(), "checksum: is not that of the file's content");
    file.flip(last);
    file.flip(64);
    expect_said(file.read_error(), "checksum: is not that of the file's content");
    std::filesystem::resize_file(file.path(), whole - 1);
    expect_said(file.read_error(), "size: is " + std::to_string(whole - 1) + " bytes");
}

TEST_F(Landscape, IsWrittenWholeOrNotAtAll) {
    EXPECT_FALSE(write_landscape(*world_, "no/such/folder/landscape.bin"));
    const std::filesystem::path folder =
        std::filesystem::path(::testing::TempDir()) / ("landscape-folder-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    const std::filesystem::path path = folder / "landscape.bin";
    ASSERT_TRUE(write_landscape(*world_, path));
    const auto read = read_landscape(path);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(difference(**read, *world_), "");
    // Nothing else is left behind.
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
    std::filesystem::remove_all(folder);
}

TEST_F(Landscape, OpensTheFirstFileThatHoldsIt) {
    const std::filesystem::path files[] = {"no/such/landscape.bin", built_landscape()};
    const OpenedWorld opened = open_world(files);
    EXPECT_FALSE(opened.generated);
    ASSERT_EQ(opened.problems.size(), 1U);
    expect_said(opened.problems[0].message(), "no/such/landscape.bin");
    EXPECT_EQ(difference(*opened.world, *world_), "");
}

TEST_F(Landscape, IsAlpineAndFitsTogether) {
    const World* world = world_.get();
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
        const LodSettings settings;
        (void)world->lod->update(
            {camera.position_m, camera.projection(16.0F / 9.0F) * camera.view(), camera.pixels_per_radian(540.0F)},
            settings);
        EXPECT_LE(world->lod->indices().size() / 3, settings.max_triangles) << name;
    }
}

} // namespace
} // namespace alpenglow::sandbox
