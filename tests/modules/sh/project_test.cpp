#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/project.hpp>

#include <array>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

TEST(Project, QuadratureIntegratesConstantsAndMoments) {
    for (const int degree : {0, 1, 2, 7, 30, 200}) {
        const SphereQuadrature q = sphere_quadrature(degree);
        double sum = 0.0, zz = 0.0, xy = 0.0;
        for (std::size_t i = 0; i < q.weights.size(); ++i) {
            const glm::dvec3 d = q.directions[i];
            EXPECT_NEAR(glm::length(d), 1.0, 1e-14);
            sum += q.weights[i];
            zz += q.weights[i] * d.z * d.z;
            xy += q.weights[i] * d.x * d.y;
        }
        EXPECT_NEAR(sum, 4.0 * pi, 4.0 * pi * 2e-13);
        if (degree >= 2) {
            EXPECT_NEAR(zz, 4.0 * pi / 3.0, 1e-12);
            EXPECT_NEAR(xy, 0.0, 1e-12);
        }
    }
}

TEST(Project, BasisIsOrthonormal) {
    const SphereQuadrature q = sphere_quadrature(2 * (max_order - 1));
    for (int i = 0; i < max_coefficients; ++i) {
        std::array<double, max_coefficients> c{};
        project_function(
            max_order, q,
            [&](const glm::dvec3& d) {
                std::array<double, max_coefficients> y{};
                evaluate_basis(max_order, d, y);
                return y[static_cast<std::size_t>(i)];
            },
            c);
        for (int j = 0; j < max_coefficients; ++j) {
            EXPECT_NEAR(c[static_cast<std::size_t>(j)], i == j ? 1.0 : 0.0, 1e-13);
        }
    }
}

TEST(Project, ProjectionThenEvaluationOfABandLimitedFunctionIsTheIdentity) {
    const auto function = [](const glm::dvec3& d) {
        return 1.0 + d.x * d.y * d.z * d.z - 2.0 * d.z * d.z * d.z + d.y * d.y * d.x;
    };
    std::array<double, 25> c{};
    project_function(5, sphere_quadrature(8), function, c);
    test::Random random(4);
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 d = random.direction();
        EXPECT_NEAR(evaluate(5, c, d), function(d), 1e-13);
    }
}

TEST(Project, SamplesAndFunctionAgreeInEachChannel) {
    const SphereQuadrature q = sphere_quadrature(12);
    std::vector<glm::dvec3> values;
    for (const glm::dvec3& d : q.directions) {
        values.emplace_back(std::exp(d.z), d.x * d.x, 3.0);
    }
    std::array<glm::dvec3, 16> by_samples{};
    std::array<glm::dvec3, 16> by_function{};
    std::array<double, 16> red{};
    project_samples(4, q.directions, std::span<const glm::dvec3>(values), q.weights, std::span<glm::dvec3>(by_samples));
    project_function(
        4, q, [](const glm::dvec3& d) { return glm::dvec3(std::exp(d.z), d.x * d.x, 3.0); }, by_function);
    project_function(
        4, q, [](const glm::dvec3& d) { return std::exp(d.z); }, red);
    for (std::size_t i = 0; i < 16; ++i) {
        EXPECT_EQ(by_samples[i], by_function[i]);
        EXPECT_EQ(by_samples[i].x, red[i]);
    }
    EXPECT_NEAR(by_samples[0].z, 3.0 * std::sqrt(4.0 * pi), 1e-12);
}

} // namespace
} // namespace alpenglow::sh
