#include "clouds_test_support.hpp"

#include <alpenglow/clouds/bricks.hpp>
#include <alpenglow/clouds/library.hpp>
#include <alpenglow/clouds/vdb.hpp>

#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <openvdb/openvdb.h>
#pragma GCC diagnostic pop

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

std::string temporary(const std::string& name) {
    return (std::filesystem::path(::testing::TempDir()) / ("alpenglow_clouds_" + name)).string();
}

std::string write_vdb(const std::string& name, const openvdb::GridCPtrVec& grids) {
    const std::string path = temporary(name);
    openvdb::io::File(path).write(grids);
    return path;
}

openvdb::FloatGrid::Ptr float_grid(float background = 0.0F) {
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(background);
    grid->setName("density");
    grid->tree().setValueOn(openvdb::Coord(3, 4, 5), 0.5F);
    return grid;
}

// The error of loading and checking `grid`.
std::string complaint(const openvdb::GridBase::Ptr& grid, const VdbLimits& limits = {}) {
    const std::string path = write_vdb("bad.vdb", {grid});
    const auto loaded = load_vdb(path);
    if (!loaded) {
        return loaded.error().message();
    }
    const auto sparse = sparse_from_vdb(*loaded, path + ": density", limits);
    return sparse ? "" : sparse.error().message();
}

TEST(CloudStorage, RoundTripThroughAFileKeepsValuesAndTransform) {
    SparseGrid grid = noise_cloud(3, 24);
    GridTransform transform;
    const double a = 0.6;
    transform.axes = glm::dmat3(std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1);
    transform.voxel_m = {10.0, 12.0, 7.0};
    transform.origin_m = {1000.0, -200.0, 1500.0};
    grid.set_transform(transform);
    const std::string path = temporary("round.vdb");
    const VdbGrid handle = vdb_from_sparse(grid, "smoke");
    ASSERT_TRUE(save_vdb(path, std::vector<VdbGrid>{handle}));
    const auto infos = list_vdb(path);
    ASSERT_TRUE(infos);
    ASSERT_EQ(infos->size(), 1U);
    EXPECT_EQ(infos->front().name, "smoke");
    const auto loaded = load_vdb(path, "smoke");
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->active_voxels(), grid.active_voxels());
    const auto back = sparse_from_vdb(*loaded, path);
    ASSERT_TRUE(back);
    for (int z = -2; z < 26; ++z) {
        for (int y = -2; y < 26; ++y) {
            for (int x = -2; x < 26; ++x) {
                ASSERT_EQ(back->value(x, y, z), grid.value(x, y, z));
            }
        }
    }
    const glm::dvec3 p = back->transform().world_from_index({3, 4, 5});
    const glm::dvec3 q = transform.world_from_index({3, 4, 5});
    EXPECT_NEAR(p.x, q.x, 1e-9);
    EXPECT_NEAR(p.y, q.y, 1e-9);
    EXPECT_NEAR(p.z, q.z, 1e-9);
    EXPECT_NEAR(back->transform().index_from_world(p).y, 4.0, 1e-9);
}

TEST(CloudStorage, BricksStayWithinTheirBoundOfOpenVdb) {
    const SparseGrid grid = noise_cloud(7, 40);
    const VdbGrid vdb = vdb_from_sparse(grid, "density");
    const BrickVolume bricks(grid);
    std::vector<glm::vec3> points;
    for (std::uint32_t i = 0; i < 20000; ++i) {
        points.emplace_back(44.0F * test::random_at(3 * i) - 2.0F, 44.0F * test::random_at(3 * i + 1) - 2.0F,
                            44.0F * test::random_at(3 * i + 2) - 2.0F);
    }
    std::vector<float> exact(points.size());
    sample_vdb(vdb, points, exact);
    std::vector<float> xs;
    std::vector<float> ys;
    std::vector<float> zs;
    for (const glm::vec3& p : points) {
        xs.push_back(p.x);
        ys.push_back(p.y);
        zs.push_back(p.z);
    }
    std::vector<float> batch(points.size());
    sample_batch(bricks, xs, ys, zs, batch);
    const float bound = grid.max_density() / 510.0F + 2e-6F; // a brick's range is at most the grid's
    for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_NEAR(bricks.sample(points[i]), exact[i], bound);
        ASSERT_NEAR(batch[i], bricks.sample(points[i]), 1e-6F);
        ASSERT_NEAR(grid.sample(points[i].x, points[i].y, points[i].z), exact[i], 1e-6F);
    }
    EXPECT_EQ(bricks.active_voxels(), grid.active_voxels());
}

TEST(CloudStorage, BlockMeansKeepTheMass) {
    const SparseGrid grid = noise_cloud(9, 37);
    const BrickVolume bricks(grid);
    double exact = 0.0;
    for (int z = 0; z < 37; ++z) {
        for (int y = 0; y < 37; ++y) {
            for (int x = 0; x < 37; ++x) {
                exact += double(grid.value(x, y, z));
            }
        }
    }
    for (const int factor : {1, 2, 3, 5}) {
        const glm::ivec3 dims((bricks.active_high() - bricks.active_low() + factor) / factor);
        double sum = 0.0;
        for (const float v : bricks.block_means(bricks.active_low(), dims, factor)) {
            sum += double(v) * factor * factor * factor;
        }
        EXPECT_NEAR(sum / exact, 1.0, 1e-3) << factor;
    }
}

TEST(CloudStorage, TilesSingleVoxelsAndWideSparseGridsAreClouds) {
    openvdb::initialize();
    auto tile = openvdb::FloatGrid::create(0.0F);
    tile->tree().addTile(2, openvdb::Coord(0, 0, 0), 0.25F, true); // 128^3
    const auto spread = sparse_from_vdb({tile}, "tile");
    ASSERT_TRUE(spread);
    EXPECT_EQ(spread->active_voxels(), 128U * 128U * 128U);
    EXPECT_EQ(spread->value(127, 127, 127), 0.25F);
    EXPECT_EQ(spread->value(128, 0, 0), 0.0F);
    const BrickVolume constant(*spread);
    EXPECT_FLOAT_EQ(constant.sample({60.3F, 60.4F, 60.9F}), 0.25F);

    auto wide = openvdb::FloatGrid::create(0.0F);
    wide->tree().setValueOn(openvdb::Coord(-1000, -1000, -1000), 1.0F);
    wide->tree().setValueOn(openvdb::Coord(999, 999, 999), 1.0F);
    const auto sparse = sparse_from_vdb({wide}, "wide");
    ASSERT_TRUE(sparse);
    const BrickVolume bricks(*sparse);
    EXPECT_EQ(bricks.active_voxels(), 2U);
    EXPECT_NEAR(bricks.sample({999.0F, 999.0F, 999.0F}), 1.0F, 1e-5F);
    EXPECT_NEAR(bricks.sample({-1000.0F, -1000.0F, -1000.5F}), 0.5F, 3e-3F);
    EXPECT_LT(bricks.memory_bytes(), std::size_t(2) << 20);

    auto empty = openvdb::FloatGrid::create(0.0F);
    const auto nothing = sparse_from_vdb({empty}, "empty");
    ASSERT_TRUE(nothing);
    const BrickVolume no_bricks(*nothing);
    EXPECT_TRUE(no_bricks.empty());
    EXPECT_EQ(no_bricks.sample({0, 0, 0}), 0.0F);
}

TEST(CloudStorage, BadFilesAreNamedWithWhatIsWrong) {
    EXPECT_NE(load_vdb("/nonexistent/cloud.vdb").error().message().find("/nonexistent/cloud.vdb: no such file"),
              std::string::npos);
    EXPECT_NE(load_vdb(::testing::TempDir()).error().message().find("directory"), std::string::npos);

    const std::string wrong = temporary("wrong.vdb");
    std::ofstream(wrong) << "this is not a volume at all";
    EXPECT_NE(load_vdb(wrong).error().message().find("wrong magic number"), std::string::npos);

    const std::string good = temporary("good.vdb");
    ASSERT_TRUE(save_vdb(good, std::vector<VdbGrid>{vdb_from_sparse(noise_cloud(1, 24), "density")}));
    std::ifstream in(good, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    for (const double part : {0.0, 0.001, 0.01, 0.1, 0.5, 0.9, 0.999}) {
        const std::string cut = temporary("cut.vdb");
        std::ofstream(cut, std::ios::binary)
            << bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size())));
        const auto loaded = load_vdb(cut);
        ASSERT_FALSE(loaded) << part;
        EXPECT_NE(loaded.error().message().find("cut.vdb"), std::string::npos);
    }
    EXPECT_NE(load_vdb(good, "smoke").error().message().find("no grid 'smoke': it holds 'density' (float)"),
              std::string::npos);

    openvdb::initialize();
    auto vectors = openvdb::Vec3SGrid::create();
    vectors->setName("v");
    const std::string no_float = write_vdb("vectors.vdb", {vectors});
    EXPECT_NE(load_vdb(no_float).error().message().find("has no float grid: it holds 'v' (vec3s)"), std::string::npos);
    EXPECT_NE(load_vdb(no_float, "v").error().message().find("is of type vec3s"), std::string::npos);
    EXPECT_FALSE(save_vdb("/nonexistent/folder/a.vdb", std::vector<VdbGrid>{vdb_from_sparse(noise_cloud(1, 8), "d")}));
}

TEST(CloudStorage, BadGridsAreNamedWithWhatIsWrong) {
    EXPECT_EQ(complaint(float_grid()), "");
    auto grid = float_grid();
    grid->tree().setValueOn(openvdb::Coord(1, 2, 3), std::numeric_limits<float>::quiet_NaN());
    EXPECT_NE(complaint(grid).find("density NaN at voxel (1, 2, 3)"), std::string::npos);
    grid = float_grid();
    grid->tree().setValueOn(openvdb::Coord(1, 2, 3), -0.25F);
    EXPECT_NE(complaint(grid).find("density -0.25"), std::string::npos);
    grid = float_grid();
    grid->tree().setValueOn(openvdb::Coord(1, 2, 3), std::numeric_limits<float>::infinity());
    EXPECT_NE(complaint(grid).find("density inf"), std::string::npos);
    grid = float_grid();
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    EXPECT_NE(complaint(grid).find("level set"), std::string::npos);
    EXPECT_NE(complaint(float_grid(0.5F)).find("background"), std::string::npos);
    grid = float_grid();
    openvdb::math::Mat4d shear = openvdb::math::Mat4d::identity();
    shear(0, 1) = 0.5;
    grid->setTransform(openvdb::math::Transform::createLinearTransform(shear));
    EXPECT_NE(complaint(grid).find("shears"), std::string::npos);
    grid = float_grid();
    grid->tree().setValueOn(openvdb::Coord(100000, 0, 0), 1.0F);
    EXPECT_NE(complaint(grid).find("voxels on axis 0"), std::string::npos);
    grid = float_grid();
    grid->tree().addTile(3, openvdb::Coord(0, 0, 0), 1.0F, true); // 4096^3: 256 GiB of floats
    EXPECT_NE(complaint(grid).find("MiB"), std::string::npos);
    grid = float_grid();
    grid->tree().addTile(2, openvdb::Coord(0, 0, 0), 1.0F, true);
    EXPECT_NE(complaint(grid, {1 << 20}).find("at most 1 MiB"), std::string::npos);
}

TEST(CloudStorage, CoarseLevelsKeepMassAndPlace) {
    SparseGrid grid = noise_cloud(13, 27);
    GridTransform transform;
    transform.voxel_m = {2.0, 3.0, 4.0};
    transform.origin_m = {7.0, 8.0, 9.0};
    grid.set_transform(transform);
    const auto moments = [](const SparseGrid& g) {
        double mass = 0.0;
        glm::dvec3 first(0.0);
        const glm::dvec3 v = g.transform().voxel_m;
        for (std::int32_t b = 0; b < g.table().count(); ++b) {
            for (int i = 0; i < 512; ++i) {
                const double m = double(g.brick(b)[i]) * v.x * v.y * v.z;
                const glm::ivec3 index =
                    g.min() + g.table().coordinates()[std::size_t(b)] * 8 + glm::ivec3(i & 7, (i >> 3) & 7, i >> 6);
                mass += m;
                first += g.transform().world_from_index(glm::dvec3(index)) * m;
            }
        }
        return std::pair(mass, first / mass);
    };
    const auto [mass, centre] = moments(grid);
    for (const int level : {1, 2, 3}) {
        const auto [coarse_mass, coarse_centre] = moments(coarsen(grid, level));
        EXPECT_NEAR(coarse_mass / mass, 1.0, 1e-5);
        // A coarse voxel's mass sits at its middle: a fraction of it off.
        EXPECT_NEAR(coarse_centre.x, centre.x, 0.02 * 2.0 * (1 << level));
        EXPECT_NEAR(coarse_centre.z, centre.z, 0.02 * 4.0 * (1 << level));
    }
}

TEST(CloudStorage, TheLibraryKeepsItsBudget) {
    std::vector<std::string> paths;
    for (unsigned i = 0; i < 4; ++i) {
        paths.push_back(temporary("library" + std::to_string(i) + ".vdb"));
        ASSERT_TRUE(save_vdb(paths.back(), std::vector<VdbGrid>{vdb_from_sparse(noise_cloud(30 + i, 24), "density")}));
    }
    const std::size_t one = BrickVolume(noise_cloud(30, 24)).memory_bytes();
    CloudLibrary library(one * 5 / 2);
    auto first = library.load(paths[0]);
    ASSERT_TRUE(first);
    EXPECT_EQ(*library.load(paths[0]), *first); // shared
    std::shared_ptr<const BrickVolume> held = *first;
    first = Error{};
    for (int round = 0; round < 2; ++round) {
        for (const std::string& path : paths) {
            const auto volume = library.load(path); // unused ones go
            ASSERT_TRUE(volume);
            EXPECT_LE(library.memory_bytes(), one * 5 / 2);
        }
    }
    EXPECT_EQ(*library.load(paths[0]), held); // what is in use stays
    const auto other = library.load(paths[1]);
    const auto third = library.load(paths[2]);
    ASSERT_FALSE(third);
    EXPECT_NE(third.error().message().find("library2.vdb"), std::string::npos);
    EXPECT_NE(third.error().message().find("coarser level"), std::string::npos);
    EXPECT_TRUE(library.load(paths[2], {}, 2));
    EXPECT_FALSE(library.load("/nonexistent.vdb"));
}

} // namespace
