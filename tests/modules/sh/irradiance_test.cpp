#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>

#include <array>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

TEST(Irradiance, FactorsAreThoseOfEquation8) {
    const double printed[] = {3.141593, 2.094395, 0.785398, 0.0, -0.130900, 0.0, 0.049087}; // eq. 9
    for (int l = 0; l <= 6; ++l) {
        EXPECT_NEAR(cosine_factor(l), printed[l], 5e-7);
    }
    for (int l = 2; l < max_order; l += 2) {
        const double half = std::tgamma(l / 2 + 1.0);
        const double formula = 2.0 * pi * (l / 2 % 2 != 0 ? 1.0 : -1.0) / ((l + 2.0) * (l - 1.0)) *
                               (std::tgamma(l + 1.0) / (std::pow(2.0, l) * half * half));
        EXPECT_NEAR(cosine_factor(l), formula, 1e-14) << l;
    }
}

// The brute integral of max(n . d, 0) L(d) for band-limited light.
TEST(Irradiance, IsTheHemisphericalIntegral) {
    test::Random random(11);
    const std::vector<double> L = random.coefficients(5);
    std::vector<double> e(L.size());
    irradiance(5, L, e);
    // The kernel has a kink, so that the quadrature converges like degree^-2.
    const SphereQuadrature q = sphere_quadrature(400);
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 n = random.direction();
        double sum = 0.0;
        for (std::size_t k = 0; k < q.weights.size(); ++k) {
            sum += q.weights[k] * std::max(glm::dot(n, q.directions[k]), 0.0) * evaluate(5, L, q.directions[k]);
        }
        EXPECT_NEAR(evaluate(5, e, n), sum, 2e-4 * test::norm(L));
    }
}

// Figure 2 of the paper: the printed tables, whose basis has no Condon-Shortley phase.
struct Probe {
    const char* name;
    double rgb[9][3];
};
const Probe probes[] = {{"Grace Cathedral",
                         {{.79, .44, .54},
                          {.39, .35, .60},
                          {-.34, -.18, -.27},
                          {-.29, -.06, .01},
                          {-.11, -.05, -.12},
                          {-.26, -.22, -.47},
                          {-.16, -.09, -.15},
                          {.56, .21, .14},
                          {.21, -.05, -.30}}},
                        {"Eucalyptus Grove",
                         {{.38, .43, .45},
                          {.29, .36, .41},
                          {.04, .03, .01},
                          {-.10, -.10, -.09},
                          {-.06, -.06, -.04},
                          {.01, -.01, -.05},
                          {-.09, -.13, -.15},
                          {-.06, -.05, -.04},
                          {.02, -.00, -.05}}},
                        {"St. Peters Basilica",
                         {{.36, .26, .23},
                          {.18, .14, .13},
                          {-.02, -.01, -.00},
                          {.03, .02, .01},
                          {.02, .01, .00},
                          {-.05, -.03, -.01},
                          {-.09, -.08, -.07},
                          {.01, .00, .00},
                          {-.08, -.06, .00}}}};

TEST(Irradiance, PrintedTablesGiveTheSameThroughMAndThroughNineTermsAndThroughFactors) {
    test::Random random(12);
    for (const Probe& probe : probes) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            std::array<double, 9> printed{}, L{}, e{};
            for (std::size_t i = 0; i < 9; ++i) {
                printed[i] = probe.rgb[i][channel];
            }
            flip_phase(3, printed, L);
            irradiance(3, L, e);
            const glm::dmat4 M = irradiance_matrix(std::span<const double>(L));
            for (int k = 0; k < 100; ++k) {
                const glm::dvec3 n = random.direction();
                // Equation 13 with the constants as printed and the coefficients as printed.
                const double c1 = 0.429043, c2 = 0.511664, c3 = 0.743125, c4 = 0.886227, c5 = 0.247708;
                const double paper =
                    c1 * printed[8] * (n.x * n.x - n.y * n.y) + c3 * printed[6] * n.z * n.z + c4 * printed[0] -
                    c5 * printed[6] +
                    2 * c1 * (printed[4] * n.x * n.y + printed[7] * n.x * n.z + printed[5] * n.y * n.z) +
                    2 * c2 * (printed[3] * n.x + printed[1] * n.y + printed[2] * n.z);
                const glm::dvec4 h(n, 1.0);
                EXPECT_NEAR(glm::dot(h, M * h), paper, 3e-6) << probe.name;
                EXPECT_NEAR(irradiance_nine_terms(std::span<const double>(L), n), paper, 3e-6) << probe.name;
                EXPECT_NEAR(evaluate(3, e, n), glm::dot(h, M * h), 1e-14) << probe.name;
                const std::vector<float> single = test::to_float({L.begin(), L.end()});
                EXPECT_NEAR(irradiance_nine_terms(std::span<const float>(single), glm::vec3(n)), paper, 4e-6);
                const glm::vec4 hf(h);
                EXPECT_NEAR(glm::dot(hf, irradiance_matrix(std::span<const float>(single)) * hf), paper, 4e-6);
            }
            // "L_1-1, the linear moment along the y axis, is large and positive: the upper hemisphere is brighter."
            const glm::dvec3 up(0.0, 1.0, 0.0);
            EXPECT_GT(evaluate(3, e, up), evaluate(3, e, -up)) << probe.name;
        }
    }
}

TEST(Irradiance, OfAConstantSkyIsPiTimesTheRadiance) {
    const std::vector<double> L{2.0 * std::sqrt(4.0 * pi), 0, 0, 0, 0, 0, 0, 0, 0};
    EXPECT_NEAR(irradiance_nine_terms(std::span<const double>(L), glm::dvec3(0, 0, 1)), 2.0 * pi, 1e-14);
}

} // namespace
} // namespace alpenglow::sh
