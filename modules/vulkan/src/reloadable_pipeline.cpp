#include <alpenglow/vulkan/reloadable_pipeline.hpp>

#include <algorithm>
#include <system_error>
#include <utility>

#include <alpenglow/vulkan/shader_compiler.hpp>

namespace alpenglow::vulkan {
namespace {

// The epoch for a file that cannot be read, so that its return counts as a change.
std::filesystem::file_time_type time_of_change(const std::filesystem::path& file) {
    std::error_code failed;
    const std::filesystem::file_time_type time = std::filesystem::last_write_time(file, failed);
    return failed ? std::filesystem::file_time_type{} : time;
}

} // namespace

Result<ReloadablePipeline> ReloadablePipeline::create(const Device& device, std::vector<ShaderSource> sources,
                                                      std::vector<std::filesystem::path> include_directories,
                                                      Build build) {
    ReloadablePipeline reloadable;
    reloadable.device_ = &device;
    reloadable.sources_ = std::move(sources);
    reloadable.include_directories_ = std::move(include_directories);
    reloadable.build_ = std::move(build);
    std::vector<ShaderStage> stages;
    for (const ShaderSource& source : reloadable.sources_) {
        stages.push_back({source.stage, source.embedded});
        reloadable.watch(source.file);
        // What a source includes is known only after compiling it; until then every header beside it counts.
        std::error_code failed;
        for (std::filesystem::directory_iterator it(source.file.parent_path(), failed), end; !failed && it != end;
             it.increment(failed)) {
            if (it->path().extension() == ".glsl" || it->path().extension() == ".h") {
                reloadable.watch(it->path());
            }
        }
    }
    Result<Pipeline> pipeline = reloadable.build_(stages);
    if (!pipeline) {
        return pipeline.error();
    }
    reloadable.pipeline_ = std::move(pipeline).value();
    return reloadable;
}

std::string ReloadablePipeline::name() const {
    std::string names;
    for (const ShaderSource& source : sources_) {
        names += (names.empty() ? "" : ", ") + source.file.filename().string();
    }
    return names;
}

void ReloadablePipeline::watch(const std::filesystem::path& file) {
    const auto same = [&file](const WatchedFile& watched) { return watched.file == file; };
    if (std::none_of(watched_.begin(), watched_.end(), same)) {
        watched_.push_back({file, time_of_change(file)});
    }
}

Result<bool> ReloadablePipeline::reload_if_changed() {
    bool changed = false;
    for (WatchedFile& watched : watched_) {
        const std::filesystem::file_time_type now = time_of_change(watched.file);
        changed = changed || now != watched.changed;
        watched.changed = now;
    }
    if (!changed) {
        return false;
    }
    std::vector<CompiledShader> compiled;
    for (const ShaderSource& source : sources_) {
        Result<CompiledShader> shader = compile_shader(source.file, include_directories_);
        if (!shader) {
            return shader.error();
        }
        for (const std::filesystem::path& file : shader->files) {
            watch(file);
        }
        compiled.push_back(std::move(shader).value());
    }
    std::vector<ShaderStage> stages;
    for (std::size_t i = 0; i < compiled.size(); ++i) {
        stages.push_back({sources_[i].stage, compiled[i].spirv});
    }
    Result<Pipeline> pipeline = build_(stages);
    if (!pipeline) {
        return pipeline.error();
    }
    if (const Status idle = device_->wait_idle(); !idle) { // frames in flight may still use the old one
        return idle.error();
    }
    pipeline_ = std::move(pipeline).value();
    return true;
}

} // namespace alpenglow::vulkan
