#include <alpenglow/sky/phase.hpp>

#include <fp_traps.hpp>

#include <alpenglow/core/constants.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace alpenglow::sky {
namespace {

struct Moments {
    double norm, mean;
};

// Over the sphere, with nodes crowded towards both peaks: tanh-sinh in the cosine.
Moments moments(const std::function<double(double, double)>& phase_of_cosine_and_rest) {
    Moments out{0.0, 0.0};
    const double h = 0.01;
    for (double t = -4.4; t <= 4.4; t += h) {
        const double s = 0.5 * pi * std::sinh(t);
        const double c = std::tanh(s);
        const double w = 0.5 * pi * std::cosh(t) / (std::cosh(s) * std::cosh(s)) * h * two_pi;
        const double p = phase_of_cosine_and_rest(c, 1.0 - c);
        out.norm += w * p;
        out.mean += w * p * c;
    }
    return out;
}

TEST(Phase, NormalisedWithTheRightMeanCosine) {
    for (double g : {-0.95, -0.5, 0.0, 0.3, 0.8, 0.95}) {
        Moments m = moments([g](double c, double) { return phase_henyey_greenstein(c, g); });
        EXPECT_NEAR(m.norm, 1.0, 1e-6) << g;
        EXPECT_NEAR(m.mean, g, 1e-6) << g;
        m = moments([g](double c, double) { return phase_cornette_shanks(c, g); });
        EXPECT_NEAR(m.norm, 1.0, 1e-6) << g;
        EXPECT_NEAR(m.mean, 3.0 * g * (4.0 + g * g) / (5.0 * (2.0 + g * g)), 1e-6) << g;
        m = moments([g](double c, double) { return phase_schlick(c, g); });
        EXPECT_NEAR(m.norm, 1.0, 1e-6) << g;
        EXPECT_GT(m.mean * g, -1e-12) << g; // forward for k > 0
    }
    Moments m = moments([](double, double) { return phase_isotropic<double>(); });
    EXPECT_NEAR(m.norm, 1.0, 1e-9);
    EXPECT_NEAR(m.mean, 0.0, 1e-9);
    m = moments([](double c, double) { return phase_rayleigh(c); });
    EXPECT_NEAR(m.norm, 1.0, 1e-9);
    EXPECT_NEAR(m.mean, 0.0, 1e-9);
    m = moments([](double c, double) { return phase_double_henyey_greenstein(c, 0.8, -0.4, 0.25); });
    EXPECT_NEAR(m.norm, 1.0, 1e-6);
    EXPECT_NEAR(m.mean, 0.75 * 0.8 - 0.25 * 0.4, 1e-6);
}

TEST(Phase, CornetteShanksOfZeroIsRayleigh) {
    for (double c = -1.0; c <= 1.0; c += 0.1) {
        EXPECT_NEAR(phase_cornette_shanks(c, 0.0), phase_rayleigh(c), 1e-12);
    }
}

// The forward peak at g = 0.9999 against (1 + g) / (4 pi (1 - g)^2), in single precision too, where 1 + g^2 - 2 g is 0.
class PhaseStress : public test::StressTest {};

TEST_F(PhaseStress, SafeToTheEndsOfG) {
    for (double g : {-0.9999, -0.999, 0.999, 0.9999}) {
        const double peak = (1.0 + std::abs(g)) / (4.0 * pi * (1.0 - std::abs(g)) * (1.0 - std::abs(g)));
        const double c = g > 0.0 ? 1.0 : -1.0;
        EXPECT_NEAR(phase_henyey_greenstein(c, g) / peak, 1.0, 1e-9);
        EXPECT_NEAR(phase_henyey_greenstein(float(c), float(g)) / peak, 1.0,
                    2e-3); // 1 - g itself is that coarse in float
        for (float x = -1.0F; x <= 1.0F; x += 0.001F) {
            for (const float p : {phase_henyey_greenstein(x, float(g)), phase_cornette_shanks(x, float(g)),
                                  phase_schlick(x, float(g))}) {
                ASSERT_TRUE(std::isfinite(p));
                ASSERT_GE(p, 0.0F);
            }
        }
    }
}

} // namespace
} // namespace alpenglow::sky
