#include <alpenglow/vulkan/shader_compiler.hpp>

#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

namespace alpenglow::vulkan {
namespace {

std::optional<std::string> read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        return std::nullopt;
    }
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

std::optional<EShLanguage> stage_of(const std::filesystem::path& file) {
    const std::string extension = file.extension().string();
    if (extension == ".vert") {
        return EShLangVertex;
    }
    if (extension == ".frag") {
        return EShLangFragment;
    }
    if (extension == ".comp") {
        return EShLangCompute;
    }
    return std::nullopt;
}

// Resolves #include and notes every file that it read.
class FileIncluder final : public glslang::TShader::Includer {
public:
    FileIncluder(std::span<const std::filesystem::path> directories, std::vector<std::filesystem::path>& files)
        : directories_(directories), files_(files) {}

    IncludeResult* includeLocal(const char* header, const char* includer, std::size_t depth) override {
        if (IncludeResult* found = open(std::filesystem::path(includer).parent_path() / header)) {
            return found;
        }
        return includeSystem(header, includer, depth);
    }

    IncludeResult* includeSystem(const char* header, const char*, std::size_t) override {
        for (const std::filesystem::path& directory : directories_) {
            if (IncludeResult* found = open(directory / header)) {
                return found;
            }
        }
        return nullptr;
    }

    void releaseInclude(IncludeResult* result) override {
        if (result != nullptr) {
            delete static_cast<std::string*>(result->userData);
            delete result;
        }
    }

private:
    IncludeResult* open(const std::filesystem::path& file) {
        std::optional<std::string> text = read_text(file);
        if (!text) {
            return nullptr;
        }
        files_.push_back(file);
        auto owned = std::make_unique<std::string>(*std::move(text));
        const char* data = owned->data();
        const std::size_t size = owned->size();
        return new IncludeResult(file.string(), data, size, owned.release());
    }

    std::span<const std::filesystem::path> directories_;
    std::vector<std::filesystem::path>& files_;
};

// glslang counts its users; its tables live as long as one of these.
struct GlslangProcess {
    GlslangProcess() { glslang::InitializeProcess(); }
    ~GlslangProcess() { glslang::FinalizeProcess(); }
    GlslangProcess(const GlslangProcess&) = delete;
    GlslangProcess& operator=(const GlslangProcess&) = delete;
};

} // namespace

Result<CompiledShader> compile_shader(const std::filesystem::path& file,
                                      std::span<const std::filesystem::path> include_directories) {
    const std::optional<EShLanguage> stage = stage_of(file);
    if (!stage) {
        return Error{"unknown shader stage \"" + file.extension().string() + "\"", file.string(),
                     "a name that ends in .vert, .frag or .comp"};
    }
    const std::optional<std::string> text = read_text(file);
    if (!text) {
        return Error{"cannot read the shader", file.string(), "a readable file"};
    }

    CompiledShader compiled;
    compiled.files.push_back(file);
    const GlslangProcess process;
    glslang::TShader shader(*stage);
    const std::string name = file.string();
    const char* source = text->c_str();
    const int length = static_cast<int>(text->size());
    const char* source_name = name.c_str();
    shader.setStringsWithLengthsAndNames(&source, &length, &source_name, 1);
    shader.setEnvInput(glslang::EShSourceGlsl, *stage, glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_1);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_3);
    const auto messages = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
    FileIncluder includer(include_directories, compiled.files);
    if (!shader.parse(GetDefaultResources(), 450, ENoProfile, false, false, messages, includer)) {
        return Error{shader.getInfoLog(), name, ""};
    }
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(messages)) {
        return Error{program.getInfoLog(), name, ""};
    }
    glslang::SpvOptions options;
    options.disableOptimizer = true; // as the build does; drivers optimise
    glslang::GlslangToSpv(*program.getIntermediate(*stage), compiled.spirv, &options);
    return compiled;
}

} // namespace alpenglow::vulkan
