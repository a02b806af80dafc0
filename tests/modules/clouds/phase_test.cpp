#include "clouds_test_support.hpp"

#include <alpenglow/clouds/beam.hpp>
#include <alpenglow/clouds/phase.hpp>
#include <alpenglow/core/constants.hpp>

#include <array>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

const Phase phases[] = {
    {PhaseKind::henyey_greenstein, 0.0F, 0, 0},  {PhaseKind::henyey_greenstein, 0.85F, 0, 0},
    {PhaseKind::henyey_greenstein, -0.6F, 0, 0}, {PhaseKind::double_henyey_greenstein, 0.9F, -0.3F, 0.8F},
    {PhaseKind::cornette_shanks, 0.8F, 0, 0},    {PhaseKind::cornette_shanks, 0.005F, 0, 0},
    {PhaseKind::cornette_shanks, -0.5F, 0, 0},   {PhaseKind::rayleigh, 0, 0, 0}};

// Integral over the sphere of p(mu) f(mu), by a midpoint rule in the angle.
template <class F>
double integrate(const Phase& phase, F&& f) {
    double sum = 0.0;
    const int n = 40000;
    for (int i = 0; i < n; ++i) {
        const double angle = pi * (i + 0.5) / n;
        const double s = std::sin(0.5 * angle);
        sum += double(phase_value(phase, static_cast<float>(2.0 * s * s))) * f(std::cos(angle)) * two_pi *
               std::sin(angle) * pi / n;
    }
    return sum;
}

TEST(CloudPhase, IntegratesToOneWithTheMomentsItSays) {
    for (const Phase& phase : phases) {
        std::array<double, 5> chi{};
        phase_moments(phase, chi);
        EXPECT_NEAR(integrate(phase, [](double) { return 1.0; }), 1.0, 1e-5);
        EXPECT_NEAR(chi[0], 1.0, 1e-12);
        EXPECT_NEAR(integrate(phase, [](double c) { return c; }), chi[1], 1e-5);
        EXPECT_NEAR(integrate(phase, [](double c) { return 1.5 * c * c - 0.5; }), chi[2], 1e-5);
        EXPECT_NEAR(integrate(phase, [](double c) { return (35.0 * c * c * c * c - 30.0 * c * c + 3.0) / 8.0; }),
                    chi[4], 1e-5);
    }
}

TEST(CloudPhase, SamplesFollowTheFunction) {
    for (const Phase& phase : phases) {
        std::array<double, 3> chi{};
        phase_moments(phase, chi);
        double first = 0.0;
        double second = 0.0;
        const int n = 20000;
        for (int i = 0; i < n; ++i) {
            const auto c = double(sample_phase_cos(phase, (static_cast<float>(i) + 0.5F) / n));
            ASSERT_LE(std::abs(c), 1.0);
            first += c / n;
            second += (1.5 * c * c - 0.5) / n;
        }
        EXPECT_NEAR(first, chi[1], 2e-4);
        EXPECT_NEAR(second, chi[2], 4e-4);
    }
}

TEST(CloudPhase, TheBroadenedBeamStartsAsThePhaseFunctionAndKeepsItsEnergy) {
    for (const float albedo : {0.9F, 1.0F}) {
        for (const float g : {0.0F, 0.5F, 0.85F, 0.95F}) {
            Medium medium{1.0F, albedo, {PhaseKind::henyey_greenstein, g, 0, 0}};
            const BeamTable table = BeamTable::broadened(medium);
            for (const double angle : {0.0, 0.02, 0.3, 1.0, 2.0, 3.1}) {
                const auto omc = static_cast<float>(1.0 - std::cos(angle));
                const float p = albedo * phase_value(medium.phase, omc);
                EXPECT_NEAR(table.value(0.0F, omc), p, 0.01F * p + 1e-4F) << g << " " << angle;
            }
            // Over all angles: albedo ((1 - f) exp(-(1 - albedo f) tau) + f exp(-tau)).
            const ScaledMedium scaled = scaled_medium(medium);
            for (const float tau : {0.5F, 3.0F, 10.0F}) {
                double sum = 0.0;
                const int n = 20000;
                for (int i = 0; i < n; ++i) {
                    const double x = (i + 0.5) / n; // finer near the peak
                    const double angle = pi * x * x;
                    const double s = std::sin(0.5 * angle);
                    sum += double(table.value(tau, static_cast<float>(2.0 * s * s))) * two_pi * std::sin(angle) * 2.0 *
                           pi * x / n;
                }
                const double exact =
                    double(albedo) * ((1.0 - scaled.forward) * std::exp(-scaled.extinction * double(tau)) +
                                      scaled.forward * std::exp(-double(tau)));
                EXPECT_NEAR(sum, exact, 0.02 * exact + 1e-5) << albedo << " " << g << " " << tau;
            }
        }
    }
}

TEST(CloudPhase, SingleScatteringAndOctavesTablesAreTheirFormulas) {
    const Medium medium{1.0F, 0.95F, {PhaseKind::henyey_greenstein, 0.7F, 0, 0}};
    const BeamTable single = BeamTable::single_scattering(medium);
    const BeamTable octaves = BeamTable::octaves(medium, {});
    for (std::uint32_t i = 0; i < 500; ++i) {
        const float tau = 12.0F * test::random_at(2 * i);
        const float omc = 2.0F * test::random_at(2 * i + 1);
        const double exact = 0.95 * double(phase_value(medium.phase, omc)) * std::exp(-double(tau));
        EXPECT_NEAR(single.value(tau, omc), exact, 4e-3 * exact);
        double sum = 0.0;
        for (int o = 0; o < 8; ++o) {
            const double half = std::pow(0.5, o);
            Phase p = medium.phase;
            p.g *= static_cast<float>(half);
            sum += half * 0.95 * double(phase_value(p, omc)) * std::exp(-half * double(tau));
        }
        EXPECT_NEAR(octaves.value(tau, omc), sum, 1e-2 * sum);
    }
}

} // namespace
