#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

// g(R d) = f(d) is the definition.
TEST(Rotate, CommutesWithEvaluation) {
    test::Random random(5);
    for (int order = 1; order <= max_order; ++order) {
        for (int i = 0; i < 50; ++i) {
            const glm::dquat q = random.rotation();
            const Rotation rotation(order, q * random.uniform(0.1, 10.0));
            const std::vector<double> f = random.coefficients(order);
            std::vector<double> g(f.size());
            rotation.apply(f, g);
            for (int k = 0; k < 5; ++k) {
                const glm::dvec3 d = random.direction();
                EXPECT_NEAR(evaluate(order, g, q * d), evaluate(order, f, d), 1e-12 * test::norm(f));
            }
        }
    }
}

TEST(Rotate, KeepsTheNormOfEachBandAndComposes) {
    test::Random random(6);
    for (int i = 0; i < 100; ++i) {
        const glm::dquat a = random.rotation();
        const glm::dquat b = random.rotation();
        const std::vector<double> f = random.coefficients(max_order);
        std::vector<double> g(f), h(f);
        Rotation(max_order, a).apply(f, g);
        for (int l = 0; l < max_order; ++l) {
            const auto band = [l](std::vector<double>& v) {
                return std::span(v).subspan(static_cast<std::size_t>(l * l), static_cast<std::size_t>(2 * l + 1));
            };
            std::vector<double> source(f);
            EXPECT_NEAR(test::norm(band(g)), test::norm(band(source)), 1e-13);
        }
        Rotation(max_order, b).apply(g, g); // in place
        Rotation(max_order, b * a).apply(f, h);
        EXPECT_LE(test::distance(g, h), 1e-13 * test::norm(f));
    }
}

TEST(Rotate, SmallTiltsAreExactToFirstOrder) {
    // d/dt of a rotation about x at t = 0, against the rotation itself: no digits may be lost at any tilt.
    test::Random random(7);
    const std::vector<double> f = random.coefficients(6);
    for (const double tilt : {1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}) {
        const glm::dquat q(std::cos(tilt / 2.0), std::sin(tilt / 2.0), 0.0, 0.0);
        std::vector<double> g(f.size());
        Rotation(6, q).apply(f, g);
        for (int k = 0; k < 20; ++k) {
            const glm::dvec3 d = random.direction();
            EXPECT_NEAR(evaluate(6, g, q * d), evaluate(6, f, d), 3e-14 * test::norm(f));
        }
        std::vector<float> h(f.size());
        Rotation(6, q).apply(test::to_float(f), h);
        EXPECT_LE(test::distance(g, h), 3e-7 * test::norm(f)) << "tilt " << tilt;
    }
}

TEST(Rotate, FloatErrorIsBelow3em7ForEveryRotation) {
    test::Random random(8);
    double worst = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const glm::dquat q = random.rotation();
        const std::vector<double> f = random.coefficients(6);
        const std::vector<float> single = test::to_float(f);
        const std::vector<double> source(single.begin(), single.end());
        std::vector<double> g(f.size());
        std::vector<float> h(f.size());
        const Rotation rotation(6, q);
        rotation.apply(source, g);
        rotation.apply(single, h);
        worst = std::max(worst, test::distance(g, h) / test::norm(source));
    }
    EXPECT_LE(worst, 3e-7);
}

TEST(Rotate, AboutZIsTheGeneralRotation) {
    test::Random random(9);
    for (const double angle : {0.0, 1e-7, 0.3, pi / 2.0, -2.0, 3.1, 100.0}) {
        const std::vector<double> f = random.coefficients(7);
        std::vector<double> g(f.size()), h(f.size());
        rotate_z(7, angle, f, g);
        Rotation(7, glm::dquat(std::cos(angle / 2.0), 0.0, 0.0, std::sin(angle / 2.0))).apply(f, h);
        EXPECT_LE(test::distance(g, h), 1e-13 * test::norm(f));
    }
    // A lobe along x turns towards y.
    const std::vector<double> lobe{0.0, 0.0, 0.0, -1.0};
    std::vector<double> turned(4);
    rotate_z(2, pi / 2.0, lobe, turned);
    EXPECT_NEAR(evaluate(2, turned, glm::dvec3(0.0, 1.0, 0.0)), 0.4886025119029199, 1e-15);
}

TEST(Rotate, ReflectionIsAnInvolution) {
    test::Random random(10);
    const glm::dmat3 swap(1, 0, 0, 0, 0, 1, 0, 1, 0); // y <-> z
    const Rotation reflection(max_order, swap);
    const std::vector<double> f = random.coefficients(max_order);
    std::vector<double> g(f.size());
    reflection.apply(f, g);
    const glm::dvec3 d = random.direction();
    EXPECT_NEAR(evaluate(max_order, g, glm::dvec3(d.x, d.z, d.y)), evaluate(max_order, f, d), 1e-12);
    reflection.apply(g, g);
    EXPECT_LE(test::distance(f, g), 1e-13 * test::norm(f));
}

} // namespace
} // namespace alpenglow::sh
