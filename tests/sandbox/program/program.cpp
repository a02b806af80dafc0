#include "program.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>

#include <stb/stb_image.h>
#include <sys/wait.h>
#include <unistd.h>

namespace alpenglow::test {

Outcome run_sandbox(const std::string& arguments, const std::string& environment) {
    const std::string command = "env " + environment + " " ALPENGLOW_SANDBOX " " + arguments + " 2>&1 </dev/null";
    Outcome outcome;
    std::FILE* pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) {
        return outcome;
    }
    std::array<char, 4096> chunk{};
    for (std::size_t n = 0; (n = std::fread(chunk.data(), 1, chunk.size(), pipe)) > 0;) {
        outcome.output.append(chunk.data(), n);
    }
    const int status = pclose(pipe);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return outcome;
}

std::string read_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<double> Picture::mean(double left, double top, double right, double bottom) const {
    const auto at = [](double fraction, int size) { return static_cast<int>(fraction * size); };
    std::vector<double> sum(3, 0.0);
    double count = 0.0;
    for (int y = at(top, height); y < at(bottom, height); ++y) {
        for (int x = at(left, width); x < at(right, width); ++x) {
            for (std::size_t c = 0; c < 3; ++c) {
                sum[c] += rgb[3 * static_cast<std::size_t>(y * width + x) + c];
            }
            count += 1.0;
        }
    }
    for (double& channel : sum) {
        channel /= count;
    }
    return sum;
}

Picture load_picture(const std::filesystem::path& path) {
    Picture picture;
    int channels = 0;
    unsigned char* data = stbi_load(path.c_str(), &picture.width, &picture.height, &channels, 3);
    if (data == nullptr) {
        ADD_FAILURE() << path << " is no picture";
        return {};
    }
    picture.rgb.assign(data, data + 3 * static_cast<std::ptrdiff_t>(picture.width) * picture.height);
    stbi_image_free(data);
    return picture;
}

void ProgramTest::SetUp() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("alpenglow-" + std::string(info->name()) + "-" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
}

void ProgramTest::TearDown() {
    std::filesystem::remove_all(folder_);
}

std::size_t ProgramTest::files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
}

} // namespace alpenglow::test
