#include <alpenglow/prt/part_file.hpp>
#include <alpenglow/prt/shapes.hpp>

#include <gtest/gtest.h>

#include <fstream>

#include <unistd.h>

namespace alpenglow::prt {
namespace {

TEST(PartFile, ComesBackAndJoins) {
    const Mesh mesh = merged(plane(1.0F, 6), sphere(0.3F, 3), glm::vec3(0.0F, 0.0F, 0.5F));
    BakeSettings settings;
    settings.rays = 256;
    settings.gather_rays = 32;
    settings.transport = Transport::interreflected;
    settings.colour = true;
    settings.seed = 77;
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("alpenglow_part_" + std::to_string(getpid()));
    std::vector<BakePart> parts;
    BakeSettings loaded;
    for (std::size_t shard = 1; shard <= 2; ++shard) {
        const ShardRange range = shard_range(mesh.positions.size(), shard, 2);
        const Result<BakePart> part = bake_part(mesh, settings, range.first, range.last - range.first);
        ASSERT_TRUE(part);
        ASSERT_TRUE(save_part(settings, *part, path));
        Result<SavedPart> saved = load_part(path);
        ASSERT_TRUE(saved) << saved.error().message();
        EXPECT_EQ(saved->part.direct, part->direct);
        loaded = saved->settings;
        parts.push_back(std::move(saved->part));
    }
    const Result<Bake> joined = finish(mesh, loaded, parts);
    const Result<Bake> whole = bake(mesh, settings);
    ASSERT_TRUE(joined) << joined.error().message();
    ASSERT_TRUE(whole);
    EXPECT_EQ(joined->field.values, whole->field.values);

    // Damage of any byte, and any cut, is found.
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> good((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    for (std::size_t at = 0; at < good.size(); at += 97) {
        std::vector<char> bad = good;
        bad[at] = static_cast<char>(bad[at] ^ 4);
        std::ofstream(path, std::ios::binary).write(bad.data(), static_cast<std::streamsize>(bad.size()));
        EXPECT_FALSE(load_part(path)) << at;
        std::ofstream(path, std::ios::binary).write(good.data(), static_cast<std::streamsize>(at));
        EXPECT_FALSE(load_part(path)) << at;
    }
    std::filesystem::remove(path);
    EXPECT_FALSE(load_part(path));
}

// Glossy, neighbourhood and volume bakes: three parts through files, in any order, give the whole's bytes.
class FieldParts : public ::testing::Test {
protected:
    static constexpr std::size_t shards = 3;

    template <class Part>
    std::vector<FieldPart> through_files(std::size_t points, SavedFieldPart saved, const Part& part,
                                         SavedFieldPart& loaded) {
        const std::filesystem::path path =
            std::filesystem::temp_directory_path() / ("alpenglow_field_" + std::to_string(getpid()));
        std::vector<FieldPart> parts;
        for (const std::size_t shard : {2, 3, 1}) {
            const ShardRange range = shard_range(points, shard, shards);
            Result<FieldPart> baked = part(range.first, range.last - range.first);
            EXPECT_TRUE(baked) << baked.error().message();
            saved.part = std::move(*baked);
            EXPECT_TRUE(save_field_part(saved, path));
            EXPECT_EQ(part_file_kind(path), 'f');
            EXPECT_FALSE(load_part(path));
            Result<SavedFieldPart> back = load_field_part(path);
            EXPECT_TRUE(back) << back.error().message();
            EXPECT_EQ(back->part.values, saved.part.values);
            parts.push_back(back->part);
            loaded = std::move(*back);
        }
        // Damage of any byte, and any cut, is found.
        std::ifstream in(path, std::ios::binary);
        const std::vector<char> good((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
        for (std::size_t at = 0; at < good.size(); at += good.size() / 37 + 1) {
            std::vector<char> bad = good;
            bad[at] = static_cast<char>(bad[at] ^ 4);
            std::ofstream(path, std::ios::binary).write(bad.data(), static_cast<std::streamsize>(bad.size()));
            EXPECT_FALSE(load_field_part(path)) << at;
            std::ofstream(path, std::ios::binary).write(good.data(), static_cast<std::streamsize>(at));
            EXPECT_FALSE(load_field_part(path)) << at;
        }
        std::filesystem::remove(path);
        EXPECT_EQ(part_file_kind(path), 0);
        return parts;
    }
    const Mesh mesh_ = merged(plane(1.0F, 4), sphere(0.3F, 2), glm::vec3(0.0F, 0.0F, 0.4F));
};

TEST_F(FieldParts, Glossy) {
    SavedFieldPart saved;
    saved.glossy.transport = Transport::interreflected;
    saved.glossy.order = 3;
    saved.glossy.out_order = 4;
    saved.glossy.rays = 128;
    saved.glossy.gather_rays = 64;
    saved.glossy.specular = 0.2F;
    saved.glossy.max_bounces = 2;
    SavedFieldPart loaded;
    std::vector<FieldPart> parts = through_files(
        mesh_.positions.size(), saved,
        [&](std::size_t first, std::size_t count) { return bake_glossy_part(mesh_, saved.glossy, first, count); },
        loaded);
    const Result<Bake> whole = bake_glossy(mesh_, saved.glossy);
    const Result<Bake> joined_bake = finish_glossy(mesh_, loaded.glossy, parts);
    ASSERT_TRUE(whole);
    ASSERT_TRUE(joined_bake) << joined_bake.error().message();
    EXPECT_EQ(joined_bake->field.values, whole->field.values);
    EXPECT_EQ(joined_bake->report.shadow_rays, whole->report.shadow_rays);
    // What does not belong together is refused.
    loaded.glossy.seed += 1;
    EXPECT_FALSE(finish_glossy(mesh_, loaded.glossy, parts));
    EXPECT_FALSE(finish_glossy(plane(1.0F, 4), saved.glossy, parts));
    std::vector<FieldPart> twice = parts;
    twice.push_back(parts[0]);
    EXPECT_FALSE(finish_glossy(mesh_, saved.glossy, twice));
    parts.pop_back();
    EXPECT_FALSE(finish_glossy(mesh_, saved.glossy, parts));
}

TEST_F(FieldParts, Neighbourhood) {
    for (const bool bounce : {false, true}) {
        SavedFieldPart saved;
        saved.neighbourhood.order = 3;
        saved.neighbourhood.rays = 128;
        saved.neighbourhood.bounce = bounce;
        saved.grid = grid_around(mesh_, {5, 4, 5}, 0.3F, 0.3F, 0.3F); // some points lie inside the sphere
        SavedFieldPart loaded;
        const std::vector<FieldPart> parts = through_files(
            100, saved,
            [&](std::size_t first, std::size_t count) {
                return bake_neighbourhood_part(mesh_, saved.grid, saved.neighbourhood, first, count);
            },
            loaded);
        const Result<Bake> whole = bake_neighbourhood(mesh_, saved.grid, saved.neighbourhood);
        const Result<Bake> joined_bake = finish_neighbourhood(mesh_, loaded.grid, loaded.neighbourhood, parts);
        ASSERT_TRUE(whole);
        ASSERT_TRUE(joined_bake) << joined_bake.error().message();
        EXPECT_EQ(joined_bake->field.values, whole->field.values);
    }
}

TEST_F(FieldParts, Volume) {
    VolumeDensity density;
    density.grid = {glm::uvec3(6, 5, 7), glm::vec3(0.0F), glm::vec3(0.2F)};
    for (std::size_t i = 0; i < 210; ++i) {
        density.extinction_per_m.push_back(i % 3 == 0 ? 4.0F : 0.0F);
    }
    SavedFieldPart saved;
    saved.volume.order = 3;
    saved.volume.directions = 32;
    saved.volume.max_bounces = 3;
    SavedFieldPart loaded;
    const std::vector<FieldPart> parts = through_files(
        210, saved,
        [&](std::size_t first, std::size_t count) { return bake_volume_part(density, saved.volume, first, count); },
        loaded);
    const Result<Bake> whole = bake_volume(density, saved.volume);
    const Result<Bake> joined_bake = finish_volume(density, loaded.volume, parts);
    ASSERT_TRUE(whole);
    ASSERT_TRUE(joined_bake) << joined_bake.error().message();
    EXPECT_EQ(joined_bake->field.values, whole->field.values);
}

} // namespace
} // namespace alpenglow::prt
