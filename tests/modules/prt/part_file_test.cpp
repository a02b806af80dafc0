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

} // namespace
} // namespace alpenglow::prt
