#include "helpers.hpp"

#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/transfer_file.hpp>

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include <unistd.h>

namespace alpenglow::prt {
namespace {

class TransferFile : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("alpenglow_prt_" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    static std::vector<char> read(const std::filesystem::path& path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    }
    static void write(const std::filesystem::path& path, const std::vector<char>& bytes) {
        std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }

    std::filesystem::path folder_;
};

TEST_F(TransferFile, ComesBackAsItWas) {
    for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
        TransferField field = test::random_field(5, 0, 3, 123, 5);
        field.mesh_hash = 42;
        const Result<TransferTable> table = encode(field, encoding);
        ASSERT_TRUE(table);
        const std::filesystem::path path = folder_ / "a.transfer";
        ASSERT_TRUE(save_transfer(*table, path));
        const Result<TransferTable> back = load_transfer(path, {.expect_mesh_hash = 42});
        ASSERT_TRUE(back) << back.error().message();
        EXPECT_EQ(std::memcmp(&back->info, &table->info, sizeof(TransferInfo)), 0);
        ASSERT_EQ(back->blocks.size(), table->blocks.size());
        EXPECT_EQ(std::memcmp(back->blocks.data(), table->blocks.data(), table->blocks.size()), 0);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(back->blocks.data()) % 64, 0U); // mapped, ready for SIMD
        std::filesystem::remove(path);                                             // the mapping outlives the name
        const std::vector<glm::vec3> light = test::random_light(5, 1);
        std::vector<glm::vec3> a(field.count);
        std::vector<glm::vec3> b(field.count);
        evaluate(*table, light, a);
        evaluate(*back, light, b);
        EXPECT_EQ(a, b);
    }
}

TEST_F(TransferFile, EveryDamageIsFound) {
    const Result<TransferTable> table = encode(test::random_field(2, 0, 1, 20, 5), Encoding::f32);
    ASSERT_TRUE(table);
    const std::filesystem::path path = folder_ / "a.transfer";
    ASSERT_TRUE(save_transfer(*table, path));
    const std::vector<char> good = read(path);
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::vector<char> bad = good;
        bad[at] = static_cast<char>(bad[at] ^ 0x10);
        write(path, bad);
        EXPECT_FALSE(load_transfer(path)) << "byte " << at;
    }
    for (std::size_t length = 0; length < good.size(); length += 7) {
        write(path, {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)});
        EXPECT_FALSE(load_transfer(path)) << "length " << length;
    }
    // Without the checksum a damaged header must still not lead outside the file.
    for (std::size_t at = 0; at < 320; ++at) {
        for (const int flip : {0x01, 0x80, 0xFF}) {
            std::vector<char> bad = good;
            bad[at] = static_cast<char>(bad[at] ^ flip);
            write(path, bad);
            const Result<TransferTable> loaded = load_transfer(path, {.verify_checksum = false});
            if (loaded && loaded->info.rows == 1 && loaded->info.count < 1000) {
                std::vector<glm::vec3> out(loaded->info.count);
                evaluate(*loaded, test::random_light(2, 1), out);
            }
        }
    }
}

TEST_F(TransferFile, SaysWhatIsWrong) {
    const Result<TransferTable> table = encode(test::random_field(2, 0, 1, 20, 5), Encoding::f32);
    ASSERT_TRUE(table);
    const std::filesystem::path path = folder_ / "a.transfer";
    ASSERT_TRUE(save_transfer(*table, path));
    const std::vector<char> good = read(path);

    const Result<TransferTable> other = load_transfer(path, {.expect_mesh_hash = 7});
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().message().find("mesh with hash 7"), std::string::npos);

    std::vector<char> version = good;
    version[8] = 9;
    write(path, version);
    const Result<TransferTable> newer = load_transfer(path);
    ASSERT_FALSE(newer);
    EXPECT_NE(newer.error().message().find("version is 9"), std::string::npos);
    EXPECT_NE(newer.error().message().find("expected 1"), std::string::npos);

    write(path, {good.begin(), good.end() - 5});
    const Result<TransferTable> cut = load_transfer(path);
    ASSERT_FALSE(cut);
    EXPECT_NE(cut.error().message().find("header says"), std::string::npos);

    EXPECT_FALSE(load_transfer(folder_ / "nothing"));
    EXPECT_FALSE(load_transfer(folder_));
}

TEST_F(TransferFile, AFailedWriteLeavesTheOldFile) {
    const Result<TransferTable> table = encode(test::random_field(3, 0, 1, 20, 5), Encoding::f32);
    ASSERT_TRUE(table);
    // A full disk: every write to this device fails so. The file beside it is untouched, and nothing is left behind.
    const std::filesystem::path path = folder_ / "a.transfer";
    ASSERT_TRUE(save_transfer(*table, path));
    const std::vector<char> before = read(path);
    const std::string temporary = path.string() + ".part-" + std::to_string(getpid());
    std::filesystem::create_symlink("/dev/full", temporary);
    const Status status = save_transfer(*table, path);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message().find("No space left"), std::string::npos) << status.error().message();
    EXPECT_EQ(read(path), before);
    EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(temporary)));

    EXPECT_FALSE(save_transfer(*table, folder_ / "no" / "such" / "folder"));
}

} // namespace
} // namespace alpenglow::prt
