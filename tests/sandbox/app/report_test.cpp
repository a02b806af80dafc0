#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "sandbox/app/report.hpp"

namespace alpenglow::sandbox {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(Report, HoldsEachFrameAndTheMedians) {
    RunReport run{.scene = "noon", .device = "a device", .quality = "lean", .width = 960, .height = 540};
    for (const double ms : {5.0, 1.0, 3.0}) {
        FrameReport frame{.cpu_ms = ms, .wall_ms = 2.0 * ms};
        frame.systems.push_back({.system = "sky", .considered = 1, .updated = ms > 4.0 ? 1U : 0U, .cpu_ms = ms / 10.0});
        run.frames.push_back(frame);
    }
    const auto document = nlohmann::json::parse(to_json(run));
    EXPECT_EQ(document["frames"].size(), 3U);
    EXPECT_EQ(document["frames"][0]["systems"]["sky"]["updated"], 1);
    EXPECT_EQ(document["medians"]["cpu_ms"], 3.0);
    EXPECT_EQ(document["medians"]["wall_ms"], 6.0);
    const auto& sky = document["medians"]["systems"]["sky"];
    for (const char* field : {"considered", "updated", "skipped", "cpu_ms", "error_bound"}) {
        EXPECT_TRUE(sky.contains(field)) << field;
    }
    EXPECT_EQ(sky["updated"], 0.0);
}

TEST(Report, AFailedWriteLeavesTheOldFileAndNoPartialOne) {
    const fs::path folder = fs::temp_directory_path() / "alpenglow-report-test";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const fs::path path = folder / "report.json";
    ASSERT_TRUE(write_file(path.string(), "first"));
    EXPECT_EQ(read(path), "first");

    const Status missing = write_file((folder / "nowhere" / "report.json").string(), "x");
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message().find("nowhere"), std::string::npos);

    fs::create_directories(folder / "taken");
    ASSERT_FALSE(write_file((folder / "taken").string(), "x")); // a folder is in the way
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 2);
    EXPECT_EQ(read(path), "first");
    fs::remove_all(folder);
}

} // namespace
} // namespace alpenglow::sandbox
