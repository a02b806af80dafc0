#include <alpenglow/sky/sky_sh.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

using Coefficients = std::array<glm::dvec3, 49>;

double distance(const Coefficients& a, const Coefficients& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += glm::dot(a[i] - b[i], a[i] - b[i]);
    }
    return std::sqrt(sum);
}

TEST(SkySh, UniformHemisphereIsExact) {
    Coefficients c{};
    project_symmetric_sky([](const glm::dvec3&) { return glm::dvec3(1.0, 2.0, 3.0); }, 0.7, 7, {16, 32}, c);
    for (int l = 0; l < 7; ++l) {
        constexpr std::array<double, 7> integral{1.0, 0.5, 0.0, -0.125, 0.0, 0.0625, 0.0};
        const double want = two_pi * std::sqrt((2 * l + 1) / (4.0 * pi)) * integral[static_cast<std::size_t>(l)];
        for (int m = -l; m <= l; ++m) {
            const glm::dvec3 got = c[static_cast<std::size_t>(sh::index(l, m))];
            EXPECT_NEAR(got.x, m == 0 ? want : 0.0, 1e-9) << l << ' ' << m;
            EXPECT_NEAR(got.z, m == 0 ? 3.0 * want : 0.0, 1e-9);
        }
    }
}

TEST(SkySh, QuadratureConverges) {
    Coefficients fine{};
    project_preetham(1.1, 3.0, 7, {96, 128}, fine);
    double before = 1e9;
    for (int n : {6, 12, 24}) {
        Coefficients c{};
        project_preetham(1.1, 3.0, 7, {n, n + n / 3}, c);
        const double error = distance(c, fine) / distance(fine, Coefficients{});
        EXPECT_LT(error, 0.3 * before);
        before = error;
    }
    EXPECT_LT(before, 2e-6);
}

TEST(SkySh, SineTermsVanishBeforeTheRotation) {
    Coefficients c{};
    project_preetham(0.9, 4.0, 7, {12, 16}, c);
    for (int l = 0; l < 7; ++l) {
        for (int m = -l; m < 0; ++m) {
            EXPECT_EQ(c[static_cast<std::size_t>(sh::index(l, m))], glm::dvec3(0.0));
        }
    }
}

TEST(SkySh, RotationIsThatOfTheShModule) {
    Coefficients c{};
    project_preetham(0.9, 4.0, 7, {12, 16}, c);
    const double azimuth = 2.3;
    Coefficients want{};
    sh::rotate_z(7, azimuth, std::span<const glm::dvec3>(c), std::span<glm::dvec3>(want));
    rotate_symmetric_sky(glm::dvec3(0.6 * std::cos(azimuth), 0.6 * std::sin(azimuth), 0.8), 7, c);
    EXPECT_LT(distance(c, want), 1e-12 * distance(want, Coefficients{}));
}

TEST(SkySh, FewerBandsAreAPrefix) {
    Coefficients all{};
    project_preetham(0.5, 2.5, 7, {12, 16}, all);
    for (int bands = 1; bands < 7; ++bands) {
        Coefficients c{};
        project_preetham(0.5, 2.5, bands, {12, 16}, c);
        for (int i = 0; i < bands * bands; ++i) {
            EXPECT_EQ(c[static_cast<std::size_t>(i)], all[static_cast<std::size_t>(i)]);
        }
    }
}

TEST(SkySh, BrightestTowardsTheSun) {
    Coefficients c{};
    project_preetham(0.9, 2.5, 7, {12, 16}, c);
    const glm::dvec3 towards = sh::evaluate(7, c, glm::dvec3(std::sin(0.9), 0.0, std::cos(0.9)));
    const glm::dvec3 away = sh::evaluate(7, c, glm::dvec3(-std::sin(0.9), 0.0, std::cos(0.9)));
    EXPECT_GT(towards.y, 1.5 * away.y);
}

} // namespace
} // namespace alpenglow::sky
