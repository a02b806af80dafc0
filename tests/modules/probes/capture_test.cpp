#include <gtest/gtest.h>

#include "support.hpp"

#include <alpenglow/probes/capture.hpp>
#include <alpenglow/sh/project.hpp>

namespace alpenglow::probes {
namespace {

RenderFace renderer(const std::function<glm::vec3(const glm::vec3&)>& radiance, int* faces = nullptr) {
    return [=](const glm::vec3&, int face, int edge, std::span<glm::vec3> texels) {
        ASSERT_EQ(edge, 32);
        ASSERT_EQ(texels.size(), 1024U);
        for (int row = 0; row < edge; ++row) {
            for (int column = 0; column < edge; ++column) {
                texels[static_cast<std::size_t>(row * edge + column)] =
                    radiance(texel_direction(face, column, row, edge));
            }
        }
        if (faces != nullptr) {
            ++*faces;
        }
    };
}

TEST(CaptureTest, FacesLookWhereTheySay) {
    const std::array<glm::vec3, 6> axes{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
    for (int face = 0; face < 6; ++face) {
        glm::vec3 sum(0.0F);
        for (int row = 0; row < 4; ++row) {
            for (int column = 0; column < 4; ++column) {
                const glm::vec3 d = texel_direction(face, column, row, 4);
                EXPECT_NEAR(glm::length(d), 1.0F, 1e-6F);
                sum += d;
            }
        }
        EXPECT_GT(glm::dot(glm::normalize(sum), axes[static_cast<std::size_t>(face)]), 1.0F - 1e-6F);
    }
    // Vulkan's table: on +X, s grows towards -Z and t towards -Y.
    EXPECT_LT(texel_direction(0, 3, 1, 4).z, 0.0F);
    EXPECT_LT(texel_direction(0, 1, 3, 4).y, 0.0F);
    EXPECT_GT(texel_direction(2, 1, 3, 4).z, 0.0F); // +Y: t towards +Z
}

TEST(CaptureTest, AConstantStaysConstant) {
    std::array<glm::vec3, max_probe_coefficients> out{};
    capture_probe(glm::vec3(0.0F), 5, renderer([](const glm::vec3&) { return glm::vec3(1.0F, 2.0F, 3.0F); }), out);
    EXPECT_NEAR(out[0].x, std::sqrt(4.0 * pi), 1e-6);
    EXPECT_NEAR(out[0].z, 3.0 * std::sqrt(4.0 * pi), 3e-6);
    for (std::size_t i = 1; i < 25; ++i) { // symmetric up to band 3; band 4 sees the points of a texel
        EXPECT_LE(glm::length(out[i]), i < 16 ? 2e-5 : 2e-3) << i;
    }
}

TEST(CaptureTest, BandLimitedLightComesBack) {
    std::mt19937 engine(4);
    std::normal_distribution<float> normal;
    std::vector<float> c(9);
    for (float& v : c) {
        v = normal(engine);
    }
    int faces = 0;
    std::array<glm::vec3, max_probe_coefficients> out{};
    capture_probe(glm::vec3(0.0F), 3,
                  renderer([&](const glm::vec3& d) { return glm::vec3(sh::evaluate(3, c, d)); }, &faces), out);
    EXPECT_EQ(faces, 6);
    for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_NEAR(out[i].y, c[i], 5e-3);
    }
}

TEST(CaptureTest, CapturedGridsRenderTheirBudgetAndAddSunAndMoon) {
    ProbeGrid grid = test::small_grid();
    grid.source = ProbeSource::captured;
    ProbeGridSh light;
    int faces = 0;
    Capture capture;
    capture.render = renderer([](const glm::vec3& d) { return glm::vec3(d.z > 0.0F ? 1000.0F : 100.0F); }, &faces);
    capture.budget = 3;
    ProbeSources sources = test::clear_sky(3);
    const std::vector<glm::vec3> here{{-9.0F, 1.0F, 5.5F}};
    std::uint32_t frames = 0;
    for (std::uint32_t updated = 1; updated > 0; ++frames) {
        ASSERT_TRUE(begin_frame(grid, light));
        mark_needed(grid, light, here);
        updated = update_grid(grid, light, sources, capture).updated;
        EXPECT_LE(updated, 3U);
        ASSERT_LT(frames, 10U);
    }
    EXPECT_EQ(frames, 4U); // ceil(8 / 3) of work, and one that finds none
    EXPECT_EQ(faces, 6 * 8);
    const DirectLight direct = direct_light(3, grid.deringing, sources);
    const std::uint32_t p = trilinear_corners(grid, here[0]).probe[0];
    const double mean = 550.0 * std::sqrt(4.0 * pi) + static_cast<double>(direct.sun[0].x + direct.moon[0].x);
    EXPECT_NEAR(coefficient(light, p, 0).x, mean, 1e-3 * mean);
    EXPECT_GE(test::least_irradiance(3, test::probe_light(light, p)), -1e-6);
}

TEST(CaptureTest, ABrokenRendererBreaksItsProbeAlone) {
    ProbeGrid grid = test::small_grid();
    grid.source = ProbeSource::captured;
    ProbeGridSh light;
    Capture capture;
    const glm::vec3 broken = probe_position_m(grid, 30);
    capture.budget = 1000;
    capture.render = [&](const glm::vec3& p, int, int, std::span<glm::vec3> texels) {
        std::fill(texels.begin(), texels.end(), glm::vec3(p == broken ? std::nanf("") : 10.0F));
    };
    ASSERT_TRUE(begin_frame(grid, light));
    std::fill(light.needed.begin(), light.needed.end(), std::uint8_t{1});
    update_grid(grid, light, test::clear_sky(3), capture);
    for (std::size_t p = 0; p < 105; ++p) {
        EXPECT_EQ(std::isnan(light.window[p]), p == 30);
        EXPECT_TRUE(std::isfinite(coefficient(light, p, 0).x));
    }
}

} // namespace
} // namespace alpenglow::probes
