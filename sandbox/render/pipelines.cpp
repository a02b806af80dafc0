#include "sandbox/render/pipelines.hpp"

#include <utility>

#include <alpenglow_shaders/color.frag.hpp>
#include <alpenglow_shaders/color_hdr.frag.hpp>

namespace alpenglow::sandbox {

vulkan::ShaderSource vertex_shader(std::span<const std::uint32_t> spirv, const char* file) {
    return {VK_SHADER_STAGE_VERTEX_BIT, spirv, file};
}

vulkan::ShaderSource fragment_shader(std::span<const std::uint32_t> spirv, const char* file) {
    return {VK_SHADER_STAGE_FRAGMENT_BIT, spirv, file};
}

vulkan::ShaderSource color_shader(Quality quality) {
    return quality == Quality::full ? fragment_shader(color_hdr_frag, "passes/color_hdr.frag")
                                    : fragment_shader(color_frag, "passes/color.frag");
}

Result<vulkan::ReloadablePipeline> make_pipeline(const vulkan::Device& device,
                                                 std::vector<vulkan::ShaderSource> sources,
                                                 std::vector<std::uint32_t> constants,
                                                 const vulkan::GraphicsPipelineOptions& options,
                                                 const std::filesystem::path& shader_directory) {
    for (vulkan::ShaderSource& source : sources) {
        source.file = shader_directory.empty() ? std::filesystem::path() : shader_directory / source.file;
    }
    return vulkan::ReloadablePipeline::create(
        device, std::move(sources), {shader_directory},
        [&device, options = options, // a copy that may be changed
         constants = std::move(constants)](std::span<const vulkan::ShaderStage> stages) mutable {
            options.stages = stages;
            options.constants = constants;
            return vulkan::create_graphics_pipeline(device, options);
        });
}

} // namespace alpenglow::sandbox
