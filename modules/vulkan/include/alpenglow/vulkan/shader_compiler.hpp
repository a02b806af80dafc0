// GLSL to SPIR-V at run time, as the build does it: Vulkan 1.1 semantics, #include relative to the including file and
// then to the include directories.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <alpenglow/core/result.hpp>

namespace alpenglow::vulkan {

struct CompiledShader {
    std::vector<std::uint32_t> spirv;
    std::vector<std::filesystem::path> files; // all files that were read: the shader first, then what it includes
};

// Compiles one file; its extension (.vert, .frag, .comp) names the stage. The error of broken source carries the
// compiler's message with file and line.
Result<CompiledShader> compile_shader(const std::filesystem::path& file,
                                      std::span<const std::filesystem::path> include_directories = {});

} // namespace alpenglow::vulkan
