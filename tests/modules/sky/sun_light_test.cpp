#include <alpenglow/sky/sun_light.hpp>
#include <alpenglow/sky/twilight.hpp>

#include <alpenglow/core/constants.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace alpenglow::sky {
namespace {

constexpr double sun_radius = 4.6542e-3;
constexpr AirColumn clear{2.0, 0.35, 2.0};

double sun_lux(double altitude_deg, const AirColumn& air = clear) {
    return luminance(sun_illuminance_lux(altitude_deg * degree_rad, sun_radius, 1.0, air));
}

TEST(SunLight, OpticalLengthAgainstKasten) {
    EXPECT_NEAR(relative_optical_length(0.5 * pi), 1.0, 1e-3);
    EXPECT_NEAR(relative_optical_length(30.0 * degree_rad), 2.0, 0.01);
    // Kasten 1965 prints 5.60 at 10 degrees, 10.4 at 5 and 36.5 at the horizon.
    EXPECT_NEAR(relative_optical_length(10.0 * degree_rad), 5.60, 0.02);
    EXPECT_NEAR(relative_optical_length(5.0 * degree_rad), 10.4, 0.1);
    EXPECT_NEAR(relative_optical_length(0.0), 36.5, 0.5);
}

TEST(SunLight, BrightAtTheZenithAndRedAtTheHorizon) {
    const double zenith = sun_lux(90.0);
    EXPECT_GT(zenith, 1.0e5);
    EXPECT_LT(zenith, 1.3e5);
    double before = 1e9;
    double redness_before = 0.0;
    for (double altitude = 90.0; altitude >= 0.5; altitude -= 0.5) {
        const glm::dvec3 rgb = sun_illuminance_lux(altitude * degree_rad, sun_radius, 1.0, clear);
        EXPECT_LT(luminance(rgb), before);
        const double redness = rgb.x / rgb.y;
        EXPECT_GE(redness, redness_before);
        before = luminance(rgb);
        redness_before = redness;
    }
    EXPECT_GT(redness_before, 2.0);
}

TEST(SunLight, VacuumTransmitsAll) {
    const AirColumn nothing{1.0, 0.0, 0.0};
    const Spectrum t = air_transmittance(nothing, 1.0);
    // Turbidity 1 is pure air: Rayleigh alone, 0.1001 at 550 nm, but for the 2e-4 at 1 micrometre that Preetham's fit
    // of the aerosol leaves (Preetham et al. 1999, A.1).
    const double aerosol = (0.04608365822050 - 0.04586025928522) * std::pow(0.55, -1.3);
    EXPECT_NEAR(-std::log(t[17]), 0.008735 * std::pow(0.55, -4.08) + aerosol, 1e-9);
    const Spectrum twice = air_transmittance(nothing, 2.0);
    EXPECT_NEAR(twice[17], t[17] * t[17], 1e-12);
}

TEST(SunLight, FadesSmoothlyAsTheDiscSets) {
    // No step between neighbours larger than the disc's own rate allows: the whole fades over more than 0.53 degrees.
    const double step_deg = 0.001;
    const double high = sun_lux(1.0);
    double before = high;
    for (double altitude = 1.0; altitude > -1.5; altitude -= step_deg) {
        const double now = sun_lux(altitude);
        EXPECT_LE(now, before);
        EXPECT_LT(before - now, high * 0.003);
        before = now;
    }
    EXPECT_EQ(before, 0.0);
    EXPECT_GT(sun_lux(-0.3), 0.0); // refraction holds the sun up
}

TEST(SunLight, DiscFraction) {
    EXPECT_DOUBLE_EQ(visible_disc_fraction(1.0, 0.1), 1.0);
    EXPECT_DOUBLE_EQ(visible_disc_fraction(-1.0, 0.1), 0.0);
    EXPECT_NEAR(visible_disc_fraction(0.0, 0.1), 0.5, 1e-12);
    EXPECT_NEAR(visible_disc_fraction(0.03, 0.1) + visible_disc_fraction(-0.03, 0.1), 1.0, 1e-12);
}

TEST(MoonLight, FullMoonAtTheZenith) {
    const glm::dvec3 rgb = moon_illuminance_lux(0.5 * pi, 4.52e-3, 3.844e8, 0.0, clear);
    EXPECT_GT(luminance(rgb), 0.2);
    EXPECT_LT(luminance(rgb), 0.3);
    const glm::dvec3 sun = sun_illuminance_lux(0.5 * pi, sun_radius, 1.0, clear);
    EXPECT_GT(rgb.x / rgb.z, sun.x / sun.z); // redder than the sun
}

TEST(MoonLight, PhaseLaws) {
    // Allen: the half moon has 9 % of the full moon's light.
    EXPECT_NEAR(moon_phase_factor(0.5 * pi), 0.091, 0.003);
    EXPECT_DOUBLE_EQ(moon_phase_factor(0.0), 1.0);
    // Eq. 5 at 90 degrees: 1 - sin 45 tan 45 ln cot 22.5 = 0.37677.
    EXPECT_NEAR(lommel_seeliger_phase_factor(0.5 * pi), 0.37677, 1e-5);
    double before = 2.0;
    for (double a = 0.0; a <= pi; a += 0.01) {
        const double now = lommel_seeliger_phase_factor(a);
        EXPECT_LT(now, before);
        EXPECT_GE(now, 0.0);
        before = now;
    }
}

TEST(Twilight, FollowsTheMeasuredDecline) {
    // 10655 lux: Preetham's horizontal illuminance at turbidity 2.5 with the sun on the horizon.
    const auto lux = [](double altitude_deg) { return 10655.0 * twilight_fade(altitude_deg * degree_rad); };
    EXPECT_NEAR(std::log10(lux(-6.0)), std::log10(3.4), 0.1); // Janiczek and DeYoung 1987
    EXPECT_NEAR(std::log10(lux(-12.0)), std::log10(8.0e-3), 0.2);
    EXPECT_EQ(twilight_fade(-18.0 * degree_rad), 0.0);
    EXPECT_EQ(twilight_fade(10.0 * degree_rad), 1.0);
    double before = 0.0;
    for (double altitude = -18.0; altitude <= 10.5; altitude += 0.01) {
        const double now = twilight_fade(altitude * degree_rad);
        EXPECT_GE(now, before);
        if (altitude > -16.0) {
            EXPECT_LT(now, before * 1.02); // continuous: at most 2 % in a hundredth of a degree
        }
        before = now;
    }
    EXPECT_NEAR(luminance(night_floor_cd_m2()), 2.2e-4, 5e-6);
}

} // namespace
} // namespace alpenglow::sky
