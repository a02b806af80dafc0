#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/constants.h>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>

#include <array>
#include <limits>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

// Eq. 1 of the deringing paper in spherical coordinates. std::assoc_legendre has no Condon-Shortley phase.
double by_definition(int l, int m, double theta, double phi) {
    const int am = std::abs(m);
    double ratio = 1.0; // (l-|m|)! / (l+|m|)!
    for (int k = l - am + 1; k <= l + am; ++k) {
        ratio /= k;
    }
    const double k = std::sqrt((2.0 * l + 1.0) / (4.0 * pi) * ratio);
    const double p = std::assoc_legendre(static_cast<unsigned>(l), static_cast<unsigned>(am), std::cos(theta)) *
                     (am % 2 != 0 ? -1.0 : 1.0);
    if (m == 0) {
        return k * p;
    }
    return std::sqrt(2.0) * k * p * (m > 0 ? std::cos(m * phi) : std::sin(am * phi));
}

TEST(Basis, IsTheDefinitionOfThePaper) {
    test::Random random(1);
    for (int i = 0; i < 500; ++i) {
        const double theta = random.uniform(0.2, pi - 0.2); // nearer the poles the oracle itself loses digits
        const double phi = random.uniform(-pi, pi);
        const glm::dvec3 d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        std::array<double, max_coefficients> y{};
        evaluate_basis(max_order, d, y);
        for (int l = 0; l < max_order; ++l) {
            for (int m = -l; m <= l; ++m) {
                EXPECT_NEAR(y[static_cast<std::size_t>(index(l, m))], by_definition(l, m, theta, phi), 1e-13)
                    << l << ' ' << m;
            }
        }
    }
}

TEST(Basis, SignsAreThoseOfTheDeringingPaper) {
    std::array<double, 9> y{};
    const glm::dvec3 d = glm::normalize(glm::dvec3(0.3, 0.5, 0.7));
    evaluate_basis(3, d, y);
    EXPECT_NEAR(y[0], 0.28209479177387814, 1e-15);
    EXPECT_NEAR(y[1], -0.4886025119029199 * d.y, 1e-15);
    EXPECT_NEAR(y[2], 0.4886025119029199 * d.z, 1e-15);
    EXPECT_NEAR(y[3], -0.4886025119029199 * d.x, 1e-15);
    EXPECT_NEAR(y[4], 1.0925484305920792 * d.x * d.y, 1e-15);
    EXPECT_NEAR(y[5], -1.0925484305920792 * d.y * d.z, 1e-15);
    EXPECT_NEAR(y[6], 0.31539156525252005 * (3.0 * d.z * d.z - 1.0), 1e-15);
    EXPECT_NEAR(y[7], -1.0925484305920792 * d.x * d.z, 1e-15);
    EXPECT_NEAR(y[8], 0.5462742152960396 * (d.x * d.x - d.y * d.y), 1e-15);
}

TEST(Basis, FloatStaysWithinItsErrorBound) {
    test::Random random(2);
    const double bound[max_order + 1] = {0, 1e-7, 1e-7, 1.6e-7, 3e-7, 5e-7, 8e-7, 1.2e-6, 2e-6};
    for (int order = 1; order <= max_order; ++order) {
        double worst = 0.0;
        for (int i = 0; i < 20000; ++i) {
            const glm::vec3 d(random.direction());
            std::array<float, max_coefficients> f{};
            std::array<double, max_coefficients> y{};
            evaluate_basis(order, d, f);
            evaluate_basis(order, glm::dvec3(d), y);
            for (std::size_t k = 0; k < static_cast<std::size_t>(coefficient_count(order)); ++k) {
                worst = std::max(worst, std::abs(static_cast<double>(f[k]) - y[k]));
            }
        }
        EXPECT_LE(worst, bound[order]) << "order " << order;
    }
}

TEST(Basis, WritesNothingBeyondItsOrder) {
    std::array<double, max_coefficients> y;
    for (int order = 1; order <= max_order; ++order) {
        y.fill(-7.0);
        evaluate_basis(order, glm::dvec3(0.0, 0.0, 1.0), y);
        for (int i = coefficient_count(order); i < max_coefficients; ++i) {
            EXPECT_EQ(y[static_cast<std::size_t>(i)], -7.0);
        }
    }
}

TEST(Basis, AdditionTheoremHoldsAtPolesAndAxes) {
    // sum_m Y_lm(d)^2 = (2l+1) / 4 pi for every direction.
    for (const glm::dvec3 d : {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0),
                               glm::normalize(glm::dvec3(1e-9, 1e-12, 1)), glm::normalize(glm::dvec3(1, 1, 1))}) {
        std::array<double, max_coefficients> y{};
        evaluate_basis(max_order, d, y);
        for (int l = 0; l < max_order; ++l) {
            double sum = 0.0;
            for (int m = -l; m <= l; ++m) {
                const double v = y[static_cast<std::size_t>(index(l, m))];
                sum += v * v;
            }
            EXPECT_NEAR(sum, (2.0 * l + 1.0) / (4.0 * pi), 1e-14);
        }
    }
}

TEST(Basis, EvaluateIsTheDotProductForAllTypes) {
    test::Random random(3);
    const glm::dvec3 d = random.direction();
    const std::vector<double> c = random.coefficients(6);
    std::array<double, max_coefficients> y{};
    evaluate_basis(6, d, y);
    double expected = 0.0;
    std::vector<glm::vec3> rgb;
    for (std::size_t i = 0; i < c.size(); ++i) {
        expected += c[i] * y[i];
        rgb.emplace_back(glm::dvec3(1.0, -2.0, 0.5) * c[i]);
    }
    EXPECT_NEAR(evaluate(6, c, d), expected, 1e-14);
    EXPECT_NEAR(evaluate(6, test::to_float(c), glm::vec3(d)), expected, 1e-5);
    const glm::vec3 value = evaluate(6, std::span<const glm::vec3>(rgb), glm::vec3(d));
    EXPECT_NEAR(value.y, -2.0 * expected, 2e-5);
}

// What shaders compute from constants.h.
TEST(Basis, ConstantsForShadersAreTheBasis) {
    test::Random random(70);
    for (int i = 0; i < 20; ++i) {
        const glm::dvec3 d = random.direction();
        const double x = d.x, y = d.y, z = d.z, z2 = z * z;
        const double c2 = x * x - y * y, s2 = 2.0 * x * y, c3 = x * c2 - y * s2, s3 = y * c2 + x * s2;
        const double c4 = x * c3 - y * s3, s4 = y * c3 + x * s3;
        const double by_constants[25] = {ALPENGLOW_SH_K0,
                                         -ALPENGLOW_SH_K1 * y,
                                         ALPENGLOW_SH_K1 * z,
                                         -ALPENGLOW_SH_K1 * x,
                                         ALPENGLOW_SH_K2_2 * x * y,
                                         -ALPENGLOW_SH_K2_1 * y * z,
                                         ALPENGLOW_SH_K2_0 * (3.0 * z2 - 1.0),
                                         -ALPENGLOW_SH_K2_1 * x * z,
                                         ALPENGLOW_SH_K2_2C * c2,
                                         -ALPENGLOW_SH_K3_3 * s3,
                                         ALPENGLOW_SH_K3_2 * z * s2,
                                         -ALPENGLOW_SH_K3_1 * (5.0 * z2 - 1.0) * y,
                                         ALPENGLOW_SH_K3_0 * z * (5.0 * z2 - 3.0),
                                         -ALPENGLOW_SH_K3_1 * (5.0 * z2 - 1.0) * x,
                                         ALPENGLOW_SH_K3_2 * z * c2,
                                         -ALPENGLOW_SH_K3_3 * c3,
                                         ALPENGLOW_SH_K4_4 * s4,
                                         -ALPENGLOW_SH_K4_3 * z * s3,
                                         ALPENGLOW_SH_K4_2 * (7.0 * z2 - 1.0) * s2,
                                         -ALPENGLOW_SH_K4_1 * z * (7.0 * z2 - 3.0) * y,
                                         ALPENGLOW_SH_K4_0 * (35.0 * z2 * z2 - 30.0 * z2 + 3.0),
                                         -ALPENGLOW_SH_K4_1 * z * (7.0 * z2 - 3.0) * x,
                                         ALPENGLOW_SH_K4_2 * (7.0 * z2 - 1.0) * c2,
                                         -ALPENGLOW_SH_K4_3 * z * c3,
                                         ALPENGLOW_SH_K4_4 * c4};
        std::array<double, 25> basis{};
        evaluate_basis(5, d, basis);
        for (std::size_t k = 0; k < 25; ++k) {
            EXPECT_NEAR(by_constants[k], basis[k], 1e-14) << k;
        }
    }
    const double cosine[] = {ALPENGLOW_SH_A0, ALPENGLOW_SH_A1, ALPENGLOW_SH_A2, ALPENGLOW_SH_A3, ALPENGLOW_SH_A4};
    for (int l = 0; l < 5; ++l) {
        EXPECT_NEAR(cosine[l], cosine_factor(l), 1e-15);
    }
}

} // namespace
} // namespace alpenglow::sh
