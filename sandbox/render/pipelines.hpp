// Pipelines from shaders that are embedded in the program and followed for changes in their files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/reloadable_pipeline.hpp>

#include "sandbox/world/quality.hpp"

namespace alpenglow::sandbox {

// One shader of a pipeline. `file` is relative to the folder shaders/.
[[nodiscard]] vulkan::ShaderSource vertex_shader(std::span<const std::uint32_t> spirv, const char* file);
[[nodiscard]] vulkan::ShaderSource fragment_shader(std::span<const std::uint32_t> spirv, const char* file);

// Writes an interpolated colour: passes/color.frag, which dithers what a display takes, or color_hdr.frag in `full`.
[[nodiscard]] vulkan::ShaderSource color_shader(Quality quality);

// `constants`: specialization constants 0, 1, ... of every stage. What `options` points at stays. `shader_directory`:
// the folder shaders/ to follow; empty: none is.
Result<vulkan::ReloadablePipeline> make_pipeline(const vulkan::Device& device,
                                                 std::vector<vulkan::ShaderSource> sources,
                                                 std::vector<std::uint32_t> constants,
                                                 const vulkan::GraphicsPipelineOptions& options,
                                                 const std::filesystem::path& shader_directory);

} // namespace alpenglow::sandbox
