#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/product.hpp>
#include <alpenglow/sh/project.hpp>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

TEST(Product, OfBandLimitedPairsIsTheProjectionOfTheProduct) {
    test::Random random(20);
    for (int order = 1; order <= max_order; ++order) {
        const std::vector<double> f = random.coefficients(order), g = random.coefficients(order);
        std::vector<double> h(f.size()), expected(f.size());
        product(order, f, g, h);
        project_function(
            order, sphere_quadrature(3 * order),
            [&](const glm::dvec3& d) { return evaluate(order, f, d) * evaluate(order, g, d); }, expected);
        EXPECT_LE(test::distance(h, expected), 1e-12 * test::norm(f) * test::norm(g)) << order;
        std::vector<float> single(f.size());
        product(order, test::to_float(f), test::to_float(g), single);
        EXPECT_LE(test::distance(single, expected), 3e-7 * test::norm(f) * test::norm(g)) << order;
    }
}

TEST(Product, ByAConstantScalesAndCommutes) {
    test::Random random(21);
    const std::vector<double> f = random.coefficients(5), g = random.coefficients(5);
    std::vector<double> constant(25), h(25), k(25);
    constant[0] = 3.0 * std::sqrt(4.0 * pi);
    product(5, f, constant, h);
    for (std::size_t i = 0; i < 25; ++i) {
        EXPECT_NEAR(h[i], 3.0 * f[i], 1e-13);
    }
    product(5, f, g, h);
    product(5, g, f, k);
    EXPECT_LE(test::distance(h, k), 1e-13);
}

TEST(Product, MatrixAndTripleProductAgreeWithIt) {
    test::Random random(22);
    for (const int order : {1, 3, 5, 6}) {
        const std::vector<double> f = random.coefficients(order), g = random.coefficients(order),
                                  w = random.coefficients(order);
        std::vector<double> h(f.size()), matrix(f.size() * f.size());
        product(order, f, g, h);
        product_matrix(order, f, matrix);
        double inner = 0.0;
        for (std::size_t i = 0; i < f.size(); ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < f.size(); ++j) {
                EXPECT_EQ(matrix[i * f.size() + j], matrix[j * f.size() + i]);
                sum += matrix[i * f.size() + j] * g[j];
            }
            EXPECT_NEAR(sum, h[i], 1e-12);
            inner += h[i] * w[i];
        }
        EXPECT_NEAR(triple_product(order, f, g, w), inner, 1e-11);
    }
}

TEST(Product, TableHoldsTheSelectionRules) {
    for (int order = 1; order <= max_order; ++order) {
        for (const GauntEntry& e : gaunt_table(order)) {
            EXPECT_LE(e.i, e.j);
            EXPECT_LE(e.j, e.k);
            const auto band = [](int i) { return static_cast<int>(std::sqrt(i + 0.5)); };
            const int a = band(e.i), b = band(e.j), c = band(e.k);
            EXPECT_EQ((a + b + c) % 2, 0);
            EXPECT_LE(c, a + b);
            EXPECT_GT(std::abs(e.value), 1e-3) << "the cut at 1e-9 drops nothing real";
        }
    }
}

} // namespace
} // namespace alpenglow::sh
