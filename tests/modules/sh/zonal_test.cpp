#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>
#include <alpenglow/sh/window.hpp>
#include <alpenglow/sh/zonal.hpp>

#include <limits>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

TEST(Zonal, LightsAreTheirIntegrals) {
    // Integrated in z alone, with a fine midpoint rule.
    const auto integral = [](int l, auto&& radiance) {
        double sum = 0.0;
        constexpr int n = 200000;
        for (int i = 0; i < n; ++i) {
            const double z = (2.0 * i + 1.0) / n - 1.0;
            sum += radiance(z) * std::sqrt((2.0 * l + 1.0) / (4.0 * pi)) * std::legendre(static_cast<unsigned>(l), z);
        }
        return sum * 2.0 / n * two_pi;
    };
    std::array<double, max_order> z{};
    for (const double angle : {0.05, 0.7, 1.5707963, 2.5, pi}) {
        const double edge = std::cos(angle);
        zonal_disc(max_order, angle, z);
        for (int l = 0; l < max_order; ++l) {
            EXPECT_NEAR(z[static_cast<std::size_t>(l)], integral(l, [&](double c) { return c > edge ? 1.0 : 0.0; }),
                        1e-4);
        }
        zonal_cone(max_order, angle, z);
        for (int l = 0; l < max_order; ++l) {
            EXPECT_NEAR(z[static_cast<std::size_t>(l)],
                        integral(l, [&](double c) { return std::max(0.0, (c - edge) / (1.0 - edge)); }), 1e-6);
        }
    }
    zonal_hemisphere(max_order, 3.0, 1.0, z);
    for (int l = 0; l < max_order; ++l) {
        EXPECT_NEAR(z[static_cast<std::size_t>(l)], integral(l, [](double c) { return c > 0.0 ? 3.0 : 1.0; }), 1e-6);
    }
}

TEST(Zonal, ASmallDiscIsADeltaTimesItsSolidAngle) {
    std::array<double, max_order> disc{}, delta{};
    zonal_delta(max_order, delta);
    for (const double angle : {1e-3, 1e-6, 1e-9}) {
        zonal_disc(max_order, angle, disc);
        for (std::size_t l = 0; l < max_order; ++l) {
            EXPECT_NEAR(disc[l] / (delta[l] * disc_solid_angle(angle)), 1.0, 20.0 * angle * angle + 1e-14);
        }
    }
    zonal_disc(max_order, 0.0, disc);
    EXPECT_EQ(disc[5], 0.0);
}

TEST(Zonal, ADeltaTurnedToADirectionIsTheBasisThere) {
    test::Random random(60);
    const glm::dvec3 d = random.direction();
    std::array<double, max_order> z{};
    std::vector<double> f(36), y(36);
    zonal_delta(6, z);
    add_zonal(6, z, d, 2.5, f);
    evaluate_basis(6, d, y);
    for (std::size_t i = 0; i < 36; ++i) {
        EXPECT_NEAR(f[i], 2.5 * y[i], 1e-14);
    }
}

TEST(Zonal, ConvolutionWithTheClampedCosineIsIrradiance) {
    test::Random random(61);
    const std::vector<double> f = random.coefficients(6);
    std::vector<double> a(36), b(36);
    // The clamped cosine itself: a cone to the equator.
    std::array<double, 6> cosine{};
    zonal_cone(6, 0.5 * pi, cosine);
    convolve(6, f, cosine, a);
    irradiance(6, f, std::span<double>(b));
    EXPECT_LE(test::distance(a, b), 1e-13);
    std::array<float, 6> factors{};
    convolution_factors(6, cosine, factors);
    for (int l = 0; l < 6; ++l) {
        EXPECT_NEAR(static_cast<double>(factors[static_cast<std::size_t>(l)]), cosine_factor(l), 1e-6);
    }
}

TEST(Zonal, OptimalLinearDirection) {
    test::Random random(62);
    std::array<double, 3> z{};
    zonal_delta(3, z);
    for (const double scale : {1e-300, 1e-40, 1.0, 1e300}) {
        const glm::dvec3 d = random.direction();
        std::vector<double> f(9);
        add_zonal(3, z, d, scale, f);
        EXPECT_GT(glm::dot(optimal_linear_direction(f), d), 1.0 - 1e-12);
    }
    for (const double y : {-1.0, 1.0}) {
        const std::vector<double> f{1.0, y, 0.0, 0.0};
        EXPECT_EQ(optimal_linear_direction(f), glm::dvec3(0.0, -y, 0.0));
    }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(optimal_linear_direction(std::vector<double>{1, 0, 0, 0}), glm::dvec3(0, 0, 1));
    EXPECT_EQ(optimal_linear_direction(std::vector<double>{1, nan, 0, 0}), glm::dvec3(0, 0, 1));
    EXPECT_EQ(optimal_linear_direction(std::vector<float>{1, 0, -2, 0}), glm::vec3(0, 0, -1));
}

TEST(Windows, StartAtOneFallAndEndAtTheirCutOff) {
    std::array<double, max_order> w{};
    for (const Window window : {Window::none, Window::hann, Window::sinc, Window::sinc4, Window::gauss}) {
        for (const double cutoff : {0.5, 1.0, 2.5, 5.6, 8.0, 100.0, std::numeric_limits<double>::infinity()}) {
            window_factors(window, cutoff, max_order, w);
            EXPECT_EQ(w[0], 1.0);
            for (int l = 1; l < max_order; ++l) {
                const double factor = w[static_cast<std::size_t>(l)];
                EXPECT_LE(factor, w[static_cast<std::size_t>(l - 1)] + 1e-15);
                EXPECT_GE(factor, 0.0);
                if (l >= cutoff && window != Window::none && window != Window::gauss) {
                    EXPECT_EQ(factor, 0.0);
                }
                if (std::isinf(cutoff)) {
                    EXPECT_EQ(factor, 1.0);
                }
            }
        }
    }
    window_factors(Window::sinc, 5.6, 4, w); // Table 1 of the deringing paper, its last column, bands 2 and 3
    EXPECT_NEAR(w[2], 0.8030, 5e-5);
    EXPECT_NEAR(w[3], 0.5904, 5e-5);
    std::array<double, max_order> lanczos{};
    lanczos_factors(6.0, 1e9, max_order, lanczos);
    window_factors(Window::sinc, 6.0, max_order, w);
    EXPECT_NEAR(lanczos[3], w[3], 1e-12);
}

} // namespace
} // namespace alpenglow::sh
