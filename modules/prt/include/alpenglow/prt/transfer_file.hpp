// Transfer files: one table as it stands in memory behind a header, little-endian, so that a file is mapped and used
// without copying. docs/prt.md describes the format byte by byte.
#pragma once

#include <alpenglow/prt/transfer_table.hpp>

#include <filesystem>

namespace alpenglow::prt {

inline constexpr std::uint32_t transfer_file_version = 1;

// Writes beside `path` and renames, so that a failure (disk full, no permission) leaves the old file as it was.
[[nodiscard]] Status save_transfer(const TransferTable& table, const std::filesystem::path& path);

struct LoadOptions {
    std::uint64_t expect_mesh_hash = 0; // 0: any; else a file baked for another mesh is an Error
    bool verify_checksum = true;        // reads the whole file once
};

// Maps the file; the table keeps the mapping. Every size in the header is checked against the file before use.
[[nodiscard]] Result<TransferTable> load_transfer(const std::filesystem::path& path, const LoadOptions& options = {});

// Writes `parts` one after the other to a temporary file beside `path`, flushes it to the disk, and renames it.
[[nodiscard]] Status write_file_atomically(const std::filesystem::path& path,
                                           std::span<const std::span<const std::byte>> parts);

} // namespace alpenglow::prt
