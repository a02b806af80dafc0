// Runs the sandbox as a user would.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace alpenglow::test {

struct Outcome {
    int code = -1;      // exit code; 128 + signal if it crashed
    std::string output; // stdout and stderr together
};

// Runs the sandbox with these arguments, as a shell splits them; `environment` precedes it: "LP_NUM_THREADS=1".
[[nodiscard]] Outcome run_sandbox(const std::string& arguments, const std::string& environment = "");

[[nodiscard]] std::string read_file(const std::filesystem::path& path);

struct Picture {
    int width = 0;
    int height = 0;
    std::vector<unsigned char> rgb;
    // Mean of each channel over the rectangle, in fractions of the picture.
    [[nodiscard]] std::vector<double> mean(double left, double top, double right, double bottom) const;
};
[[nodiscard]] Picture load_picture(const std::filesystem::path& path);

// A folder of its own for each test, empty at the start and gone at the end.
class ProgramTest : public ::testing::Test {
protected:
    void SetUp() override;
    void TearDown() override;
    [[nodiscard]] std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }
    [[nodiscard]] std::size_t files() const;

    std::filesystem::path folder_;
};

} // namespace alpenglow::test
