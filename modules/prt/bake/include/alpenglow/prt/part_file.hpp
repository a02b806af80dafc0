// Files for parts of a bake, so that any batch scheduler can make them.
#pragma once

#include <alpenglow/prt/bake.hpp>

#include <filesystem>

namespace alpenglow::prt {

struct SavedPart {
    BakeSettings settings; // without callback, threads and memory: what the part was baked with
    BakePart part;
};

// Little-endian, checksummed, written beside and renamed.
[[nodiscard]] Status save_part(const BakeSettings& settings, const BakePart& part, const std::filesystem::path& path);
[[nodiscard]] Result<SavedPart> load_part(const std::filesystem::path& path);

} // namespace alpenglow::prt
