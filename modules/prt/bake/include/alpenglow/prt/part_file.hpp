// Files for parts of a bake, so that any batch scheduler can make them.
#pragma once

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/bake_glossy.hpp>
#include <alpenglow/prt/bake_neighbourhood.hpp>
#include <alpenglow/prt/bake_volume.hpp>

#include <filesystem>

namespace alpenglow::prt {

struct SavedPart {
    BakeSettings settings; // without callback, threads and memory: what the part was baked with
    BakePart part;
};

// Little-endian, checksummed, written beside and renamed.
[[nodiscard]] Status save_part(const BakeSettings& settings, const BakePart& part, const std::filesystem::path& path);
[[nodiscard]] Result<SavedPart> load_part(const std::filesystem::path& path);

// Parts of the other kinds, with the settings of theirs.
struct SavedFieldPart {
    FieldPart part;
    GlossySettings glossy;               // of a glossy part
    NeighbourhoodSettings neighbourhood; // of a neighbourhood's, with its grid
    Grid grid;
    VolumeSettings volume; // of a volume's
};
[[nodiscard]] Status save_field_part(const SavedFieldPart& saved, const std::filesystem::path& path);
[[nodiscard]] Result<SavedFieldPart> load_field_part(const std::filesystem::path& path);
// Which of the two a file is: 'd' for BakePart, 'f' for FieldPart, 0 for neither.
[[nodiscard]] char part_file_kind(const std::filesystem::path& path);

} // namespace alpenglow::prt
