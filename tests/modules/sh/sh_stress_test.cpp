// Floating-point traps on; every domain to its ends and past them.
#include "support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <fp_traps.hpp>

#include <array>

namespace alpenglow::sh {
namespace {

class ShStress : public alpenglow::test::StressTest {};

TEST_F(ShStress, AxesPolesAndDenormalComponentsEvaluate) {
    const double tiny[] = {0.0, -0.0, 5e-324, 1e-310, 1e-45, 1e-20};
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
            for (const double small : tiny) {
                glm::dvec3 d(small);
                d[axis] = sign;
                std::array<double, max_coefficients> y{};
                std::array<float, max_coefficients> f{};
                evaluate_basis(max_order, d, y);
                evaluate_basis(max_order, glm::vec3(d), f);
                for (std::size_t i = 0; i < y.size(); ++i) {
                    EXPECT_NEAR(static_cast<double>(f[i]), y[i], 2e-6);
                }
            }
        }
    }
}

TEST_F(ShStress, RotationsOfEveryTiltAndScaleAreOrthogonal) {
    test::Random random(13);
    for (double tilt = 1e-300; tilt < 4.0; tilt *= 10.0) {
        const glm::dvec3 axis = random.direction() * std::sin(tilt / 2.0);
        const Rotation rotation(max_order, glm::dquat(std::cos(tilt / 2.0), axis.x, axis.y, axis.z));
        for (const double scale : {1e-40, 1.0, 1e30}) {
            std::vector<double> f = random.coefficients(max_order);
            for (double& v : f) {
                v *= scale;
            }
            std::vector<double> g(f.size());
            rotation.apply(f, g);
            EXPECT_NEAR(test::norm(g) / test::norm(f), 1.0, 1e-13);
        }
    }
}

TEST_F(ShStress, ConstantsStayConstantAndHdrSunsProject) {
    std::array<double, max_coefficients> c{};
    const SphereQuadrature q = sphere_quadrature(64);
    for (const double value : {1e-40, 1.0, 1.6e9, 1e30}) {
        project_function(
            max_order, q, [&](const glm::dvec3&) { return value; }, c);
        EXPECT_NEAR(c[0] / (value * std::sqrt(4.0 * pi)), 1.0, 1e-13);
        for (std::size_t i = 1; i < c.size(); ++i) {
            EXPECT_LE(std::abs(c[i]), 1e-13 * value);
        }
    }
    std::vector<float> sun(9, 1.6e9F), lit(9);
    irradiance(3, sun, std::span<float>(lit));
    EXPECT_TRUE(std::isfinite(irradiance_nine_terms(std::span<const float>(sun), glm::vec3(0, 0, 1))));
}

} // namespace
} // namespace alpenglow::sh
