#include "gpu_test.hpp"

#include <array>
#include <bit>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <unistd.h>

#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/reloadable_pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include <alpenglow_shaders/triangle.frag.hpp>
#include <alpenglow_shaders/triangle.vert.hpp>

namespace alpenglow::vulkan {
namespace {

constexpr std::uint32_t kSize = 64;
constexpr RenderPassOptions kPass{.depth = VK_FORMAT_D32_SFLOAT};

using Rgba = std::array<int, 4>;

// A target, the pass on it and an empty pipeline layout.
class TriangleTest : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        Result<RenderPass> made = create_render_pass(*device, kPass);
        ASSERT_TRUE(made) << made.error().message();
        pass = std::move(made).value();
        Result<RenderTarget> created =
            create_render_target(*device, kPass, pass.get(), {kSize, kSize}, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
        ASSERT_TRUE(created) << created.error().message();
        target = std::move(created).value();
        Result<PipelineLayout> empty = create_pipeline_layout(*device, {});
        ASSERT_TRUE(empty);
        layout = std::move(empty).value();
    }

    void TearDown() override {
        pass = {};
        target = {};
        layout = {};
        GpuTest::TearDown();
    }

    // The triangle with the fragment shader's constant `red`.
    Result<Pipeline> build(std::span<const ShaderStage> stages, float red = 0.0F, Blend blend = Blend::none) {
        const std::array<std::uint32_t, 1> constants{std::bit_cast<std::uint32_t>(red)};
        return create_graphics_pipeline(*device, {.stages = stages,
                                                  .constants = constants,
                                                  .layout = layout.get(),
                                                  .pass = pass.get(),
                                                  .blend = blend,
                                                  .depth_test = true,
                                                  .depth_write = true});
    }

    void draw(VkPipeline pipeline, int times = 1) {
        ASSERT_TRUE(submit_and_wait(*device, [&](VkCommandBuffer commands) {
            begin_render_pass(commands, pass.get(), target, {{0.2F, 0.2F, 0.2F, 1.0F}});
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
            for (int i = 0; i < times; ++i) {
                vkCmdDraw(commands, 3, 1, 0, 0);
            }
            vkCmdEndRenderPass(commands);
        }));
        Result<std::vector<std::byte>> read = read_image(*device, *target.color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        ASSERT_TRUE(read);
        pixels = std::move(read).value();
    }

    [[nodiscard]] Rgba pixel(std::uint32_t x, std::uint32_t y) const {
        Rgba rgba{};
        for (std::size_t i = 0; i < 4; ++i) {
            rgba[i] = std::to_integer<int>(pixels[4 * (y * kSize + x) + i]);
        }
        return rgba;
    }

    RenderPass pass;
    RenderTarget target;
    PipelineLayout layout;
    std::vector<std::byte> pixels;
    const std::array<ShaderStage, 2> embedded{
        {{VK_SHADER_STAGE_VERTEX_BIT, triangle_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, triangle_frag}}};
};

TEST_F(TriangleTest, CoversTheUpperLeftHalfAndNothingElse) {
    const Result<Pipeline> pipeline = build(embedded);
    ASSERT_TRUE(pipeline) << pipeline.error().message();
    draw(pipeline->get());
    for (std::uint32_t y = 0; y < kSize; ++y) {
        for (std::uint32_t x = 0; x < kSize; ++x) {
            if (x + y + 1 < kSize) {
                ASSERT_EQ(pixel(x, y), (Rgba{0, 102, 255, 255})) << x << ", " << y;
            } else if (x + y + 1 > kSize) {
                ASSERT_EQ(pixel(x, y), (Rgba{51, 51, 51, 255})) << x << ", " << y;
            }
        }
    }
}

TEST_F(TriangleTest, SpecializationConstantsReachTheShader) {
    const Result<Pipeline> pipeline = build(embedded, 0.6F);
    ASSERT_TRUE(pipeline);
    draw(pipeline->get());
    EXPECT_EQ(pixel(3, 3), (Rgba{153, 102, 255, 255}));
}

TEST_F(TriangleTest, BlendsAsNamed) {
    struct Case {
        Blend blend;
        Rgba expected;
    };
    // Source (0, 0.4, 1, 1) on target 0.2.
    for (const Case& c : {Case{Blend::add, {51, 153, 255, 255}}, Case{Blend::multiply, {0, 20, 51, 255}},
                          Case{Blend::alpha, {0, 102, 255, 255}}, Case{Blend::over, {0, 102, 255, 255}}}) {
        const Result<Pipeline> pipeline = build(embedded, 0.0F, c.blend);
        ASSERT_TRUE(pipeline);
        draw(pipeline->get());
        for (std::size_t i = 0; i < 4; ++i) {
            EXPECT_NEAR(pixel(3, 3)[i], c.expected[i], 1) << "channel " << i;
        }
    }
}

// Shader files that a test may edit.
class ReloadTest : public TriangleTest {
protected:
    void SetUp() override {
        TriangleTest::SetUp();
        directory = std::filesystem::temp_directory_path() / ("alpenglow_reload_" + std::to_string(::getpid()));
        std::filesystem::create_directories(directory);
        for (const char* name : {"triangle.vert", "triangle.frag", "corners.glsl"}) {
            std::filesystem::copy_file(std::filesystem::path(SHADER_DIRECTORY) / name, directory / name,
                                       std::filesystem::copy_options::overwrite_existing);
        }
        Result<ReloadablePipeline> made =
            ReloadablePipeline::create(*device,
                                       {{VK_SHADER_STAGE_VERTEX_BIT, triangle_vert, directory / "triangle.vert"},
                                        {VK_SHADER_STAGE_FRAGMENT_BIT, triangle_frag, directory / "triangle.frag"}},
                                       {}, [this](std::span<const ShaderStage> stages) { return build(stages); });
        ASSERT_TRUE(made) << made.error().message();
        pipeline = std::make_unique<ReloadablePipeline>(std::move(made).value());
    }

    void TearDown() override {
        pipeline.reset();
        std::error_code ignored;
        std::filesystem::remove_all(directory, ignored);
        TriangleTest::TearDown();
    }

    // Replaces text in a file and makes its time of change differ, however coarse the file system's clock.
    void edit(const char* name, const std::string& from, const std::string& to) {
        const std::filesystem::path file = directory / name;
        std::ostringstream text;
        text << std::ifstream(file).rdbuf();
        std::string content = text.str();
        const std::size_t at = content.find(from);
        ASSERT_NE(at, std::string::npos);
        content.replace(at, from.size(), to);
        std::ofstream(file) << content;
        ++edits;
        std::filesystem::last_write_time(file,
                                         std::filesystem::file_time_type::clock::now() + std::chrono::seconds(edits));
    }

    std::filesystem::path directory;
    std::unique_ptr<ReloadablePipeline> pipeline;
    int edits = 0;
};

TEST_F(ReloadTest, UnchangedFilesKeepThePipeline) {
    const VkPipeline before = pipeline->get();
    const Result<bool> reloaded = pipeline->reload_if_changed();
    ASSERT_TRUE(reloaded);
    EXPECT_FALSE(*reloaded);
    EXPECT_EQ(pipeline->get(), before);
}

TEST_F(ReloadTest, AChangedFileDrawsAnew) {
    edit("triangle.frag", "0.4, 1.0, 1.0", "1.0, 0.0, 1.0");
    const Result<bool> reloaded = pipeline->reload_if_changed();
    ASSERT_TRUE(reloaded) << reloaded.error().message();
    EXPECT_TRUE(*reloaded);
    draw(pipeline->get());
    EXPECT_EQ(pixel(3, 3), (Rgba{0, 255, 0, 255}));
}

TEST_F(ReloadTest, AChangedIncludeDrawsAnew) {
    edit("corners.glsl", "index == 1 ? 1.0", "index == 1 ? 0.0");
    const Result<bool> reloaded = pipeline->reload_if_changed();
    ASSERT_TRUE(reloaded) << reloaded.error().message();
    EXPECT_TRUE(*reloaded);
    draw(pipeline->get());
    EXPECT_EQ(pixel(3, 3), (Rgba{0, 102, 255, 255}));
    EXPECT_EQ(pixel(50, 3), (Rgba{51, 51, 51, 255}));
}

TEST_F(ReloadTest, BrokenSourceKeepsTheOldPipelineAndSaysWhy) {
    const VkPipeline before = pipeline->get();
    edit("triangle.frag", "red, 0.4", "crimson, 0.4");
    const Result<bool> broken = pipeline->reload_if_changed();
    ASSERT_FALSE(broken);
    EXPECT_NE(broken.error().message().find("crimson"), std::string::npos) << broken.error().message();
    EXPECT_EQ(pipeline->get(), before);
    draw(pipeline->get());
    EXPECT_EQ(pixel(3, 3), (Rgba{0, 102, 255, 255}));
    const Result<bool> again = pipeline->reload_if_changed(); // not reported twice
    ASSERT_TRUE(again);
    EXPECT_FALSE(*again);
    edit("triangle.frag", "crimson, 0.4", "red, 0.8");
    const Result<bool> mended = pipeline->reload_if_changed();
    ASSERT_TRUE(mended) << mended.error().message();
    EXPECT_TRUE(*mended);
    draw(pipeline->get());
    EXPECT_EQ(pixel(3, 3), (Rgba{0, 204, 255, 255}));
}

} // namespace
} // namespace alpenglow::vulkan
