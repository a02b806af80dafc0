#include "sandbox/app/picture.hpp"

#include <stb/stb_image_write.h>

#include <vector>

#include "sandbox/app/report.hpp"

namespace alpenglow::sandbox {

Status write_png(const std::string& path, int width, int height, std::span<const std::byte> rgba) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    std::vector<unsigned char> rgb(3 * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            rgb[3 * i + c] = static_cast<unsigned char>(rgba[4 * i + c]);
        }
    }
    std::string file;
    const auto append = [](void* context, void* data, int size) {
        static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
    };
    if (stbi_write_png_to_func(append, &file, width, height, 3, rgb.data(), 3 * width) == 0) {
        return Error{"the picture cannot be encoded", path, "enough memory"};
    }
    return write_file(path, file);
}

} // namespace alpenglow::sandbox
