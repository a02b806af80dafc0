#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/image.hpp>

#include <limits>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

struct OwnedCube {
    std::array<std::vector<float>, 6> pixels;
    int size;
    explicit OwnedCube(int s) : size(s) {
        for (auto& face : pixels) {
            face.resize(static_cast<std::size_t>(s * s * 3));
        }
    }
    template <class F>
    void fill(F&& f) {
        for (int face = 0; face < 6; ++face) {
            for (int i = 0; i < size; ++i) {
                for (int j = 0; j < size; ++j) {
                    const glm::vec3 v(
                        f(cube_direction(face, (2.0 * j + 1.0) / size - 1.0, (2.0 * i + 1.0) / size - 1.0)));
                    for (int c = 0; c < 3; ++c) {
                        pixels[static_cast<std::size_t>(face)][static_cast<std::size_t>(3 * (i * size + j) + c)] = v[c];
                    }
                }
            }
        }
    }
    CubeMap map() const {
        CubeMap m;
        for (std::size_t f = 0; f < 6; ++f) {
            m.faces[f] = pixels[f];
        }
        m.size = size;
        return m;
    }
};

std::vector<float> equirect(int width, int height, auto&& f) {
    std::vector<float> pixels;
    for (int i = 0; i < height; ++i) {
        for (int j = 0; j < width; ++j) {
            const double theta = pi * (i + 0.5) / height, phi = two_pi * (j + 0.5) / width - pi;
            const glm::vec3 v(
                f(glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta))));
            pixels.insert(pixels.end(), {v.x, v.y, v.z});
        }
    }
    return pixels;
}

glm::dvec3 sky(const glm::dvec3& d) {
    return {1.0 + d.z + 0.5 * d.x * d.y, std::exp(d.x - d.z), 2.0 + std::sin(3.0 * d.y) + d.x * d.z};
}

template <class Out>
double worst(const Out& a, const std::vector<glm::dvec3>& b) {
    double w = 0.0;
    for (std::size_t i = 0; i < b.size(); ++i) {
        w = std::max(w, glm::length(glm::dvec3(a[i]) - b[i]));
    }
    return w;
}

class Images : public ::testing::TestWithParam<BatchTarget> {
protected:
    void SetUp() override {
        if (!limit_batch_target(GetParam())) {
            GTEST_SKIP() << "not on this machine";
        }
    }
    void TearDown() override { limit_batch_target(BatchTarget::best); }
};

TEST_P(Images, CubeMapsOfEverySizeAgreeWithTheStraightforwardLoop) {
    test::Random random(50);
    for (const int size : {1, 2, 3, 7, 8, 16, 33, 50, 64}) {
        for (const int supersampling : {1, 2}) {
            OwnedCube cube(size);
            cube.fill([&](const glm::dvec3& d) { return sky(d) + random.uniform(0.0, 1.0); });
            for (const int order : {3, 8}) {
                const auto count = static_cast<std::size_t>(coefficient_count(order));
                std::vector<glm::vec3> out(count);
                std::vector<glm::dvec3> expected(count);
                // On odd sizes the middle pixels are split where the axis passes: other points, the same integral.
                const bool even = size % 2 == 0;
                ASSERT_TRUE(project(cube.map(), order, std::span<glm::vec3>(out), even ? supersampling : 5));
                ASSERT_TRUE(
                    project_reference(cube.map(), order, std::span<glm::dvec3>(expected), even ? supersampling : 5));
                EXPECT_LE(worst(out, expected), (even ? 1e-6 : 0.02) * glm::length(expected[0]))
                    << "size " << size << " order " << order;
            }
        }
    }
}

TEST_P(Images, ConstantsStayConstant) {
    for (const int size : {1, 5, 16, 64, 128}) {
        OwnedCube cube(size);
        cube.fill([](const glm::dvec3&) { return glm::dvec3(1.0, 2.0, 1e4); });
        std::vector<glm::vec3> out(36);
        ASSERT_TRUE(project(cube.map(), 6, std::span<glm::vec3>(out), size < 16 ? 48 : 4));
        EXPECT_NEAR(static_cast<double>(out[0].z) / (1e4 * std::sqrt(4.0 * pi)), 1.0, 1e-6);
        for (std::size_t i = 1; i < out.size(); ++i) {
            // What the midpoints of supersampled pixels leave, by the symmetry of the cube only in bands 4 and up.
            const double left = i < 16 ? 1e-6 : 2.0 / (size * size * (size < 16 ? 48.0 * 48.0 : 16.0)) + 1e-6;
            EXPECT_LE(std::abs(static_cast<double>(out[i].z)) / (1e4 * std::sqrt(4.0 * pi)), left)
                << i << " size " << size;
        }
    }
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {7, 3}, {64, 32}, {100, 50}, {333, 111}}) {
        const std::vector<float> pixels =
            equirect(width, height, [](const glm::dvec3&) { return glm::dvec3(1.0, 2.0, 1e4); });
        std::vector<glm::vec3> out(36);
        ASSERT_TRUE(project(EquirectMap{pixels, width, height}, 6, std::span<glm::vec3>(out)));
        EXPECT_NEAR(static_cast<double>(out[0].z) / (1e4 * std::sqrt(4.0 * pi)), 1.0, 1e-6);
        for (std::size_t i = 1; i < out.size(); ++i) {
            EXPECT_LE(std::abs(static_cast<double>(out[i].z)) / (1e4 * std::sqrt(4.0 * pi)), 1e-6) << width << ' ' << i;
        }
    }
}

TEST_P(Images, EquirectangularMapsAreTheLimitOfSupersampling) {
    for (const auto& [width, height] : {std::pair{1, 1}, {5, 4}, {16, 8}, {37, 20}, {64, 33}}) {
        test::Random random(51);
        const std::vector<float> pixels =
            equirect(width, height, [&](const glm::dvec3& d) { return sky(d) + random.uniform(0.0, 1.0); });
        std::vector<glm::vec3> out(36);
        std::vector<glm::dvec3> expected(36);
        ASSERT_TRUE(project(EquirectMap{pixels, width, height}, 6, std::span<glm::vec3>(out)));
        ASSERT_TRUE(project_reference(EquirectMap{pixels, width, height}, 6, std::span<glm::dvec3>(expected),
                                      64 / std::min(height, 8)));
        EXPECT_LE(worst(out, expected), 0.02) << width << ' ' << height;
    }
}

TEST_P(Images, OrientationsAreThoseStated) {
    // A bright direction comes out as the optimal linear direction would: the linear band points at it.
    test::Random random(52);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec3 to = random.direction();
        const auto lobe = [&](const glm::dvec3& d) { return glm::dvec3(std::exp(20.0 * (glm::dot(d, to) - 1.0))); };
        OwnedCube cube(32);
        cube.fill(lobe);
        const std::vector<float> pixels = equirect(64, 32, lobe);
        std::vector<glm::vec3> a(4), b(4);
        ASSERT_TRUE(project(cube.map(), 2, std::span<glm::vec3>(a)));
        ASSERT_TRUE(project(EquirectMap{pixels, 64, 32}, 2, std::span<glm::vec3>(b)));
        for (const auto& f : {a, b}) {
            EXPECT_GT(glm::dot(glm::normalize(glm::dvec3(-f[3].x, -f[1].x, f[2].x)), to), 0.9995);
        }
    }
}

TEST_P(Images, BadPixelsAreBlackAndCounted) {
    for (const int size : {5, 16, 32}) {
        OwnedCube cube(size), black(size);
        cube.fill(sky);
        black.fill(sky);
        const auto spoil = [&](std::size_t face, std::size_t p, float with) {
            cube.pixels[face][3 * p + 1] = with;
            for (std::size_t c = 0; c < 3; ++c) {
                black.pixels[face][3 * p + c] = 0.0F;
            }
        };
        const auto last = static_cast<std::size_t>(size * size - 1);
        spoil(0, 0, std::numeric_limits<float>::quiet_NaN());
        spoil(3, last, std::numeric_limits<float>::infinity());
        spoil(5, last / 2, -std::numeric_limits<float>::infinity());
        std::vector<glm::vec3> a(9), b(9);
        const Result<std::size_t> bad = project(cube.map(), 3, std::span<glm::vec3>(a));
        ASSERT_TRUE(bad);
        EXPECT_EQ(*bad, 3U);
        ASSERT_TRUE(project(black.map(), 3, std::span<glm::vec3>(b)));
        EXPECT_EQ(a, b);
    }
    std::vector<float> pixels = equirect(20, 10, sky);
    pixels[3 * 17] = std::numeric_limits<float>::quiet_NaN();
    std::vector<glm::vec3> out(9);
    EXPECT_EQ(*project(EquirectMap{pixels, 20, 10}, 3, std::span<glm::vec3>(out)), 1U);
    EXPECT_TRUE(std::isfinite(out[4].x));
}

TEST_P(Images, WrongSizesAreErrorsThatSayWhat) {
    std::vector<glm::vec3> out(9);
    CubeMap map;
    EXPECT_FALSE(project(map, 3, std::span<glm::vec3>(out)));
    map.size = 4;
    const Result<std::size_t> result = project(map, 3, std::span<glm::vec3>(out));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message(), "cube map: face 0 has 0 floats (expected 48)");
    EXPECT_FALSE(project(EquirectMap{{}, 0, 5}, 3, std::span<glm::vec3>(out)));
    EXPECT_FALSE(CubeProjector::make(16, 3, 0));
}

INSTANTIATE_TEST_SUITE_P(AllTargets, Images,
                         ::testing::Values(BatchTarget::scalar, BatchTarget::sse4, BatchTarget::avx2,
                                           BatchTarget::avx512));

} // namespace
} // namespace alpenglow::sh
