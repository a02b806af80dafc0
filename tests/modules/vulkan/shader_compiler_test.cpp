#include <alpenglow/vulkan/shader_compiler.hpp>

#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <gtest/gtest.h>

namespace alpenglow::vulkan {
namespace {

const std::filesystem::path kShaders = SHADER_DIRECTORY;

TEST(ShaderCompilerTest, CompilesAndListsTheFilesItRead) {
    const Result<CompiledShader> shader = compile_shader(kShaders / "triangle.vert");
    ASSERT_TRUE(shader) << shader.error().message();
    ASSERT_FALSE(shader->spirv.empty());
    EXPECT_EQ(shader->spirv[0], 0x07230203U); // SPIR-V's magic number
    ASSERT_EQ(shader->files.size(), 2U);
    EXPECT_EQ(shader->files[0], kShaders / "triangle.vert");
    EXPECT_EQ(shader->files[1].filename(), "corners.glsl");
}

// A copy of the shader elsewhere, so that only the include directory can supply the header.
TEST(ShaderCompilerTest, FindsIncludesInTheIncludeDirectories) {
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("alpenglow_" + std::to_string(::getpid()) + ".vert");
    std::filesystem::copy_file(kShaders / "triangle.vert", file, std::filesystem::copy_options::overwrite_existing);
    const Result<CompiledShader> without = compile_shader(file);
    const std::vector<std::filesystem::path> directories{kShaders};
    const Result<CompiledShader> with = compile_shader(file, directories);
    std::filesystem::remove(file);
    ASSERT_FALSE(without);
    EXPECT_NE(without.error().message().find("corners.glsl"), std::string::npos);
    EXPECT_TRUE(with) << with.error().message();
}

TEST(ShaderCompilerTest, ErrorsNameFileAndLine) {
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("alpenglow_" + std::to_string(::getpid()) + ".frag");
    std::ofstream(file) << "#version 450\nvoid main() {\n  undeclared = 1.0;\n}\n";
    const Result<CompiledShader> shader = compile_shader(file);
    std::filesystem::remove(file);
    ASSERT_FALSE(shader);
    const std::string message = shader.error().message();
    EXPECT_NE(message.find(file.string() + ":3"), std::string::npos) << message;
    EXPECT_NE(message.find("undeclared"), std::string::npos) << message;
}

TEST(ShaderCompilerTest, MissingFileAndUnknownStage) {
    const Result<CompiledShader> missing = compile_shader(kShaders / "missing.frag");
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message().find("missing.frag"), std::string::npos);
    const Result<CompiledShader> unknown = compile_shader(kShaders / "corners.glsl");
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message().find(".glsl"), std::string::npos);
}

} // namespace
} // namespace alpenglow::vulkan
