// The generated landscape as a file, so that the program need not generate it at each start: what is costly is stored,
// what follows cheaply from it (positions, normals, objects) is not.
//
// Little-endian, 64 bytes of header and five arrays, one entry a sample, samples in the order of `WorldData::terrain`
// (the outer grid row by row, then the inner grid), N = 2 x 1025 x 1025:
//
//   0  char[8]  "AGLANDSC"            40  uint64   bytes after the header
//   8  uint32   version               48  uint64   XXH3 of the bytes after the header
//  12  uint32   samples a side        56  uint64   XXH3 of the 56 bytes before
//  16  uint32   outer over inner spacing
//  20  float32  inner spacing in m
//  24  uint32   seed                  64  float32  [N]     height in m
//  28  uint32   0                         uint32   [N]     albedo and sky visibility, as Vertex::albedo
//  32  uint64   0                         uint32   [N][4]  horizon, as Vertex::horizon
//                                         bfloat16 [N]     level of detail: error bound in m, negative: never split
//                                         bfloat16 [N]     level of detail: radius in m
//
// bfloat16 is the upper half of a float32.
#pragma once

#include "world.hpp"

#include <alpenglow/core/result.hpp>

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace alpenglow::sandbox {

inline constexpr std::uint32_t landscape_version = 1;

// Written beside and renamed: whoever reads gets the old file or the new one.
[[nodiscard]] Status write_landscape(const World& world, const std::filesystem::path& path);

// The same bits as build_world(seed) of the program that wrote it; an error names file, field and value.
[[nodiscard]] Result<std::unique_ptr<World>> read_landscape(const std::filesystem::path& path,
                                                            std::uint32_t seed = default_seed);

// Where the build has put the file; empty in a build that makes none.
[[nodiscard]] std::filesystem::path built_landscape();

struct OpenedWorld {
    std::unique_ptr<World> world;
    std::vector<Error> problems; // of files that were tried in vain
    bool generated = false;
};

// The landscape from the first file that holds it, else generated.
[[nodiscard]] OpenedWorld open_world(std::span<const std::filesystem::path> files, std::uint32_t seed = default_seed);

} // namespace alpenglow::sandbox
