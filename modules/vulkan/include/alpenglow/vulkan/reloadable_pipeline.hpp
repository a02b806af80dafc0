// A pipeline that follows its shader files while the program runs.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/pipeline.hpp>

namespace alpenglow::vulkan {

// One stage: the SPIR-V of the build, and the source that it was built from.
struct ShaderSource {
    VkShaderStageFlagBits stage = VK_SHADER_STAGE_VERTEX_BIT;
    std::span<const std::uint32_t> embedded; // outlives the pipeline
    std::filesystem::path file;              // need not exist: then there is nothing to follow
};

class ReloadablePipeline {
public:
    using Build = std::function<Result<Pipeline>(std::span<const ShaderStage>)>;

    // Builds from the embedded SPIR-V. `build` is kept for later versions.
    static Result<ReloadablePipeline> create(const Device& device, std::vector<ShaderSource> sources,
                                             std::vector<std::filesystem::path> include_directories, Build build);

    [[nodiscard]] VkPipeline get() const { return pipeline_.get(); }
    // The names of its shader files: "terrain.vert, color.frag".
    [[nodiscard]] std::string name() const;

    // Looks at the files' times of change. True: a changed file was compiled and the pipeline is new (the device was
    // idle in between). False: nothing changed. Error: the new source is broken, with the compiler's message; the old
    // pipeline stays and the same change is not reported twice.
    Result<bool> reload_if_changed();

private:
    struct WatchedFile {
        std::filesystem::path file;
        std::filesystem::file_time_type changed{};
    };
    void watch(const std::filesystem::path& file);

    const Device* device_ = nullptr;
    std::vector<ShaderSource> sources_;
    std::vector<std::filesystem::path> include_directories_;
    Build build_;
    Pipeline pipeline_;
    std::vector<WatchedFile> watched_; // the sources and all that their last compilation included
};

} // namespace alpenglow::vulkan
