// Floating-point traps on; every domain to its ends and past them.
#include "lights.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/dering.hpp>
#include <alpenglow/sh/dering_batch.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/project.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <fp_traps.hpp>

#include <array>
#include <limits>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

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

// ---- Batches and deringing
// ---------------------------------------------------------------------------------------------

class ShBatchStress : public alpenglow::test::StressTest, public ::testing::WithParamInterface<BatchTarget> {
protected:
    void SetUp() override {
        if (!limit_batch_target(GetParam())) {
            GTEST_SKIP() << "not on this machine";
        }
    }
    void TearDown() override { limit_batch_target(BatchTarget::best); }
};

// Lights scaled from denormal to huge: windows do not depend on the scale.
TEST_P(ShBatchStress, DeringingIsScaleFree) {
    constexpr std::size_t count = 160;
    test::Random random(14);
    BatchBuffer unit(9, count), in(9, count), out(9, count), factors(2, count), expected(2, count);
    std::vector<DeringOutcome> outcomes(count);
    for (std::size_t k = 0; k < count; ++k) {
        std::vector<double> f = test::random_light(random);
        const double size = test::norm(f);
        for (std::size_t i = 0; i < 9; ++i) {
            unit.row(i)[k] = static_cast<float>(f[i] / size);
        }
    }
    for (const WindowFamily family : {WindowFamily::blend, WindowFamily::gauss, WindowFamily::sloan}) {
        DeringOptions options;
        options.family = family;
        dering(1, unit, out, options, outcomes, expected);
        for (const float scale : {1e-36F, 1e-30F, 1e-10F, 1.6e9F, 1e20F, 1e30F}) {
            for (std::size_t i = 0; i < 9; ++i) {
                for (std::size_t k = 0; k < count; ++k) {
                    in.row(i)[k] = unit.row(i)[k] * scale;
                }
            }
            dering(1, in, out, options, outcomes, factors);
            for (std::size_t k = 0; k < count; ++k) {
                EXPECT_NEAR(static_cast<double>(factors.row(1)[k]), static_cast<double>(expected.row(1)[k]), 2e-3)
                    << scale << ' ' << k;
                EXPECT_TRUE(std::isfinite(out.row(6)[k]));
            }
        }
    }
}

TEST_P(ShBatchStress, DeringingOfHigherOrdersIsScaleFree) {
    constexpr std::size_t count = 24;
    test::Random random(15);
    for (int order = 4; order <= 6; ++order) {
        const auto n = static_cast<std::size_t>(order * order);
        BatchBuffer unit(n, count), in(n, count), out(n, count);
        BatchBuffer expected(static_cast<std::size_t>(order - 1), count), factors(expected.rows(), count);
        for (std::size_t k = 0; k < count; ++k) {
            // Among them one band alone, with a mean from nothing to a lot.
            std::vector<double> f = test::random_light(random, order);
            if (k % 3 == 0) {
                f.assign(n, 0.0);
                f[n - 1 - k / 3] = 1.0;
                f[0] += std::pow(10.0, static_cast<double>(k) - 14.0);
            }
            const double size = test::norm(f);
            for (std::size_t i = 0; i < n; ++i) {
                unit.row(i)[k] = static_cast<float>(f[i] / size);
            }
        }
        std::vector<DeringOutcome> outcomes(count);
        dering(order, 1, unit, out, {}, outcomes, expected);
        for (const float scale : {1e-40F, 1e-36F, 1e-10F, 1.6e9F, 1e30F}) {
            for (std::size_t i = 0; i < n; ++i) {
                for (std::size_t k = 0; k < count; ++k) {
                    in.row(i)[k] = unit.row(i)[k] * scale;
                }
            }
            dering(order, 1, in, out, {}, outcomes, factors);
            for (std::size_t k = 0; k < count; ++k) {
                EXPECT_TRUE(std::isfinite(out.row(n - 1)[k]));
                EXPECT_NE(outcomes[k], DeringOutcome::not_finite);
                if (scale > 1e-38F && in.row(0)[k] > 1e-37F) {
                    EXPECT_NEAR(factors.row(0)[k], expected.row(0)[k], 2e-3F) << order << ' ' << scale << ' ' << k;
                }
            }
        }
    }
}

TEST_P(ShBatchStress, DenormalsAnswerWithAndWithoutFlush) {
    BatchBuffer in(9, 16), out(9, 16);
    std::vector<DeringOutcome> outcomes(16);
    for (const bool flush : {false, true}) {
#if defined(__SSE2__)
        const unsigned before = _mm_getcsr();
        _mm_setcsr(flush ? before | 0x8040U : before);
#endif
        for (std::size_t k = 0; k < 16; ++k) {
            for (std::size_t i = 0; i < 9; ++i) {
                in.row(i)[k] = i == 0 ? 1e-40F : 3e-41F * static_cast<float>(k);
            }
        }
        dering(1, in, out, {}, outcomes);
        evaluate_basis(3, in.view(), out.view());
#if defined(__SSE2__)
        _mm_setcsr(before);
#endif
        for (std::size_t k = 0; k < 16; ++k) {
            EXPECT_NE(outcomes[k], DeringOutcome::not_finite) << flush;
        }
    }
}

TEST_P(ShBatchStress, PureBandsSpikesAndBadItems) {
    // One band alone, with a mean from nothing to a lot; NaN and infinities among them.
    constexpr std::size_t count = 9 * 16;
    BatchBuffer in(9, count), out(9, count), factors(2, count);
    std::vector<DeringOutcome> outcomes(count);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = k / 16;
        in.row(i)[k] = k % 2 == 0 ? 1.0F : -1.0F;
        in.row(0)[k] += std::pow(10.0F, static_cast<float>(k % 16) - 14.0F);
    }
    in.row(4)[20] = std::numeric_limits<float>::quiet_NaN();
    in.row(4)[37] = std::numeric_limits<float>::infinity();
    in.row(0)[50] = -std::numeric_limits<float>::infinity();
    for (const DeringMethod method : {DeringMethod::exact, DeringMethod::paper}) {
        for (const WindowFamily family : {WindowFamily::blend, WindowFamily::gauss, WindowFamily::sloan}) {
            DeringOptions options;
            options.method = method;
            options.family = family;
            options.signal = Signal::radiance;
            dering(1, in, out, options, outcomes, factors);
            for (std::size_t k = 0; k < count; ++k) {
                EXPECT_EQ(outcomes[k] == DeringOutcome::not_finite, k == 20 || k == 37 || k == 50);
                std::vector<double> f(9);
                for (std::size_t i = 0; i < 9; ++i) {
                    f[i] = static_cast<double>(out.row(i)[k]);
                }
                if (method == DeringMethod::exact) {
                    EXPECT_GE(quadratic_minimum(f).value, -1e-6 * 0.2821 * f[0]) << k;
                }
            }
        }
    }
}

TEST_P(ShBatchStress, RotationsAndProductsOverTheWholeRange) {
    constexpr std::size_t count = 48;
    test::Random random(15);
    for (const int order : {2, 3, 4, 6, 8}) {
        BatchBuffer f(static_cast<std::size_t>(order * order), count), g(f.rows(), count), h(f.rows(), count),
            q(4, count);
        for (const double scale : {1e-36, 1e-15, 1.0, 1e15, 1e30}) {
            for (std::size_t k = 0; k < count; ++k) {
                const glm::dquat r = random.rotation();
                const double tilt = std::pow(10.0, -static_cast<double>(k)); // down to denormal
                q.row(0)[k] = static_cast<float>(r.x * tilt);
                q.row(1)[k] = static_cast<float>(r.y * tilt);
                // About z by some angle, or not at all, and nearly of unit length.
                const double rest = std::sqrt(1.0 - (r.x * r.x + r.y * r.y) * tilt * tilt);
                const double half = k % 2 == 0 ? random.uniform(-3.0, 3.0) : 0.0;
                q.row(2)[k] = static_cast<float>(rest * std::sin(half) * 1.0004);
                q.row(3)[k] = static_cast<float>(rest * std::cos(half) * 1.0004);
                for (std::size_t i = 0; i < f.rows(); ++i) {
                    f.row(i)[k] = static_cast<float>(scale * random.normal());
                    g.row(i)[k] = static_cast<float>(random.normal() / std::max(1.0, scale));
                }
            }
            rotate(order, q.view(), f.view(), h.view());
            for (std::size_t k = 0; k < count; ++k) {
                double before = 0.0, after = 0.0;
                for (std::size_t i = 0; i < f.rows(); ++i) {
                    before = std::hypot(before, static_cast<double>(f.row(i)[k]));
                    after = std::hypot(after, static_cast<double>(h.row(i)[k]));
                }
                EXPECT_NEAR(after / before, 1.0, 1e-6);
            }
            product(order, f.view(), g.view(), h.view());
            for (std::size_t i = 0; i < f.rows(); ++i) {
                for (std::size_t k = 0; k < count; ++k) {
                    EXPECT_TRUE(std::isfinite(h.row(i)[k]));
                }
            }
        }
    }
}

// A million rotations: compose the quaternion, keep the source.
TEST_P(ShBatchStress, AMillionComposedRotations) {
    test::Random random(16);
    const glm::dvec3 axis = random.direction();
    const double angle = 0.3;
    const glm::dquat step(std::cos(0.5 * angle), std::sin(0.5 * angle) * axis);
    glm::dquat total(1.0, 0.0, 0.0, 0.0);
    for (int i = 0; i < 1'000'000; ++i) {
        total = glm::normalize(step * total);
    }
    const double whole = 0.5e6 * angle; // half the angle of all of them at once
    const std::vector<double> f = random.coefficients(6);
    BatchBuffer in(36, 1), q(4, 1), out(36, 1);
    std::vector<double> expected(36);
    for (std::size_t i = 0; i < 36; ++i) {
        in.row(i)[0] = static_cast<float>(f[i]);
    }
    q.row(0)[0] = static_cast<float>(total.x);
    q.row(1)[0] = static_cast<float>(total.y);
    q.row(2)[0] = static_cast<float>(total.z);
    q.row(3)[0] = static_cast<float>(total.w);
    rotate(6, q.view(), in.view(), out.view());
    Rotation(6, glm::dquat(std::cos(whole), std::sin(whole) * axis)).apply(f, expected);
    for (std::size_t i = 0; i < 36; ++i) {
        EXPECT_NEAR(static_cast<double>(out.row(i)[0]), expected[i], 5e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(AllTargets, ShBatchStress,
                         ::testing::Values(BatchTarget::scalar, BatchTarget::sse4, BatchTarget::avx2,
                                           BatchTarget::avx512));

TEST_F(ShStress, ScalarDeringingFromDenormalToHuge) {
    test::Random random(17);
    for (int i = 0; i < 200; ++i) {
        std::vector<double> f = test::random_light(random);
        const Dering expected = find_window(3, f);
        for (const double scale : {1e-40, 1e-20, 1.6e9, 1e30}) {
            std::vector<double> g(f);
            for (double& c : g) {
                c *= scale;
            }
            EXPECT_NEAR(find_window(3, g).strength, expected.strength, 1e-9);
        }
        for (const DeringMethod method : {DeringMethod::paper, DeringMethod::exact}) {
            DeringOptions options;
            options.method = method;
            options.family = WindowFamily::sloan;
            static_cast<void>(find_window(3, f, options));
        }
    }
    // At the corners of the paper's Newton: pure bands, z = +-1, no linear band, one along each axis.
    for (std::size_t i = 0; i < 9; ++i) {
        for (const double sign : {-1.0, 1.0}) {
            std::vector<double> f(9);
            f[0] = 1.0;
            f[i] += sign * 5.0;
            EXPECT_TRUE(std::isfinite(paper_bound(f)));
            EXPECT_LE(paper_bound(f), quadratic_minimum(f).value + 1e-12);
        }
    }
}

// 2 * 10^5 lights that ring; the exact minimum (tested against dense sampling elsewhere) of every result.
TEST_F(ShStress, NothingIsLeftNegative) {
    constexpr std::size_t count = 200'000;
    test::Random random(18);
    BatchBuffer in(9, count), out(9, count);
    for (std::size_t k = 0; k < count; ++k) {
        const std::vector<double> f = test::random_light(random);
        for (std::size_t i = 0; i < 9; ++i) {
            in.row(i)[k] = static_cast<float>(f[i]);
        }
    }
    dering(1, in, out);
    double least = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
        std::array<double, 9> f{};
        for (std::size_t i = 0; i < 9; ++i) {
            f[i] = static_cast<double>(out.row(i)[k]);
        }
        irradiance(3, f, std::span<double>(f));
        least = std::min(least, quadratic_minimum(f).value / (0.28209479177387814 * f[0]));
    }
    EXPECT_GE(least, -1e-6);
}

} // namespace
} // namespace alpenglow::sh
