// PNG files.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <alpenglow/core/result.hpp>

namespace alpenglow::sandbox {

// Writes RGBA bytes, rows from the top, as an opaque PNG; whole or not at all.
[[nodiscard]] Status write_png(const std::string& path, int width, int height, std::span<const std::byte> rgba);

} // namespace alpenglow::sandbox
