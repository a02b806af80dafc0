#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fp_traps.hpp"
#include "sandbox/app/exposure.hpp"

namespace alpenglow::sandbox {
namespace {

TEST(Exposure, CoversNoonToMoonlessNight) {
    // The average lands on a visible key everywhere, and brighter scenes look brighter.
    float previous = 0.0F;
    for (const float luminance : {2e-4F, 2e-2F, 2.0F, 200.0F, 8000.0F}) {
        const float shown = luminance * automatic_exposure(luminance, 0.0F);
        EXPECT_GE(shown, 0.03F) << luminance;
        EXPECT_LE(shown, 1.0F) << luminance;
        EXPECT_GE(shown, 0.999F * previous) << luminance; // the darkest share the least key
        previous = shown;
    }
}

TEST(Exposure, BiasIsInStops) {
    EXPECT_FLOAT_EQ(automatic_exposure(500.0F, 1.0F), 2.0F * automatic_exposure(500.0F, 0.0F));
}

TEST(Exposure, AdaptationArrivesAndNeverOvershoots) {
    float exposure = 1e-3F;
    for (int frame = 0; frame < 600; ++frame) {
        const float next = adapt_exposure(exposure, 10.0F, 1.0F / 60.0F);
        EXPECT_GE(next, exposure);
        EXPECT_LE(next, 10.0F * 1.0001F);
        exposure = next;
    }
    EXPECT_NEAR(exposure, 10.0F, 0.2F);
}

TEST(Exposure, AdaptationDoesNotDependOnTheFrameRate) {
    float coarse = 1.0F;
    float fine = 1.0F;
    for (int i = 0; i < 10; ++i) {
        coarse = adapt_exposure(coarse, 50.0F, 0.1F);
        for (int k = 0; k < 10; ++k) {
            fine = adapt_exposure(fine, 50.0F, 0.01F);
        }
    }
    EXPECT_NEAR(coarse / fine, 1.0F, 1e-4F);
}

class ExposureStress : public test::StressTest {};

TEST_F(ExposureStress, AnyInputGivesAPositiveFiniteFactor) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (const float luminance : {nan, inf, -inf, -1.0F, 0.0F, 1e-38F, 1e-10F, 1.0F, 1e9F, 3e38F}) {
        for (const float bias : {nan, inf, -inf, -100.0F, 0.0F, 100.0F}) {
            const float exposure = automatic_exposure(luminance, bias);
            EXPECT_TRUE(std::isfinite(exposure));
            EXPECT_GT(exposure, 0.0F);
        }
    }
    EXPECT_EQ(adapt_exposure(nan, 2.0F, 0.1F), 2.0F);
    EXPECT_EQ(adapt_exposure(0.0F, 2.0F, 0.1F), 2.0F);
    EXPECT_EQ(adapt_exposure(1.0F, 2.0F, nan), 2.0F);
}

} // namespace
} // namespace alpenglow::sandbox
