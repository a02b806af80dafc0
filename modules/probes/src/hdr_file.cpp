// The one place that sees stb_image.
#include <alpenglow/probes/environment.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#include <stb_image.h>

namespace alpenglow::probes {

namespace {

// Hands the file's bytes to stb_image. At the end of data stb_image reads zeros, and zeros are run lengths that never
// get on: it would not return. So an end of line and then 0xff, which ends every header and every run, follow the
// file, and `overrun` tells.
struct Reader {
    const std::vector<unsigned char>* bytes = nullptr;
    std::size_t at = 0;
    bool overrun = false;
    bool line_ended = false;
};

int read(void* user, char* data, int size) {
    auto& reader = *static_cast<Reader*>(user);
    const std::size_t left = reader.bytes->size() - reader.at;
    if (left == 0) {
        reader.overrun = true;
        std::memset(data, 0xff, static_cast<std::size_t>(size));
        if (!reader.line_ended && size > 0) {
            data[0] = '\n';
            reader.line_ended = true;
        }
        return size;
    }
    const std::size_t count = std::min(left, static_cast<std::size_t>(size));
    std::memcpy(data, reader.bytes->data() + reader.at, count);
    reader.at += count;
    return static_cast<int>(count);
}
void skip(void* user, int count) {
    auto& reader = *static_cast<Reader*>(user);
    reader.at = std::min(reader.bytes->size(), reader.at + static_cast<std::size_t>(std::max(count, 0)));
}
int at_end(void* /*user*/) {
    return 0;
}

} // namespace

Result<EnvironmentMap> load_environment(const std::filesystem::path& file, int order, std::size_t max_bytes) {
    const auto error = [&](const std::string& what, const std::string& expected) {
        return Error{.what = what, .where = file.string(), .expected = expected};
    };
    std::error_code code;
    const auto file_size = std::filesystem::file_size(file, code);
    std::ifstream stream(file, std::ios::binary);
    if (code || !stream) {
        return error("cannot be read: " + (code ? code.message() : std::string(std::strerror(errno))),
                     "a Radiance .hdr file");
    }
    if (file_size > max_bytes || file_size > 0x7fffffffU) {
        return error("has " + std::to_string(file_size) + " bytes",
                     "at most " + std::to_string(std::min<std::size_t>(max_bytes, 0x7fffffffU)));
    }
    const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};

    int width = 0;
    int height = 0;
    if (bytes.empty() ||
        stbi_info_from_memory(bytes.data(), static_cast<int>(bytes.size()), &width, &height, nullptr) == 0) {
        return error(bytes.empty() ? "is empty" : "has no header of a Radiance image",
                     "#?RADIANCE, FORMAT=32-bit_rle_rgbe, an empty line and -Y height +X width");
    }
    if (width < 1 || height < 1) {
        return error("has a size of " + std::to_string(width) + " x " + std::to_string(height), "1 x 1 or more");
    }
    const double pixels = static_cast<double>(width) * height;
    if (pixels * sizeof(glm::vec3) > static_cast<double>(max_bytes)) {
        return error("has a size of " + std::to_string(width) + " x " + std::to_string(height) + ", which takes " +
                         std::to_string(static_cast<long long>(pixels * sizeof(glm::vec3) / 1048576.0)) + " MiB",
                     "at most " + std::to_string(max_bytes >> 20U) + " MiB");
    }
    const auto truncated = [&] {
        return error("ends before all of its " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                     "a whole file");
    };
    // The shortest row of runs: 4 bytes, then for each channel 2 bytes for every 127 pixels.
    if (static_cast<double>(bytes.size()) < std::min(4.0 * pixels, height * (4.0 + 8.0 * ((width + 126) / 127)))) {
        return truncated();
    }
    Reader reader{.bytes = &bytes};
    const stbi_io_callbacks callbacks{read, skip, at_end};
    const std::unique_ptr<float, decltype(&stbi_image_free)> data(
        stbi_loadf_from_callbacks(&callbacks, &reader, &width, &height, nullptr, 3), &stbi_image_free);
    if (reader.overrun) {
        return truncated();
    }
    if (data == nullptr) {
        return error(std::string("is damaged: ") + stbi_failure_reason(), "a Radiance image");
    }
    EnvironmentMap map;
    map.width = width;
    map.height = height;
    map.order = order;
    map.radiance.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < map.radiance.size(); ++i) {
        map.radiance[i] = {data.get()[3 * i], data.get()[3 * i + 1], data.get()[3 * i + 2]};
    }
    if (Status status = check(map); !status) {
        return status.error();
    }
    return map;
}

} // namespace alpenglow::probes
