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

// Bennett's and Saemundsson's formulas are each other's inverses within 0.1 arcmin, by themselves.
TEST(SunLight, RefractionAtHeightJoinsThatOnTheGround) {
    for (double altitude = -0.9; altitude < 90.0; altitude += 0.13) {
        EXPECT_NEAR(refraction_rad(altitude * degree_rad, 0.0) / degree_rad * 60.0,
                    refraction_rad(altitude * degree_rad) / degree_rad * 60.0, altitude < 0.0 ? 1.5 : 0.2)
            << altitude;
    }
    // Apparent altitudes keep their order at every height, so that no disc turns inside out.
    for (double height : {0.0, 500.0, 4000.0, 12e3, 30e3, 80e3}) {
        double before = -10.0;
        for (double altitude = -20.0; altitude < 20.0; altitude += 0.02) {
            const double apparent = altitude * degree_rad + refraction_rad(altitude * degree_rad, height);
            EXPECT_GT(apparent, before) << height << ' ' << altitude;
            before = apparent;
        }
    }
}

// The setting sun on a sea horizon is an ellipse of 0.8 to 0.85 (Minnaert 1954, section 25: 5/6); high up it is round.
TEST(SunLight, HorizonFlattensTheDisc) {
    const ApparentDisc low = apparent_disc(-0.55 * degree_rad, sun_radius);
    EXPECT_NEAR(low.altitude_rad, 0.0, 0.1 * degree_rad);
    EXPECT_GT(low.vertical_radius_rad / low.horizontal_radius_rad, 0.75);
    EXPECT_LT(low.vertical_radius_rad / low.horizontal_radius_rad, 0.88);
    const ApparentDisc high = apparent_disc(40.0 * degree_rad, sun_radius);
    EXPECT_NEAR(high.vertical_radius_rad / high.horizontal_radius_rad, 1.0, 2e-3);
    const ApparentDisc flight = apparent_disc(-3.8 * degree_rad, sun_radius, 12e3);
    EXPECT_LT(flight.vertical_radius_rad, 0.8 * flight.horizontal_radius_rad);
    EXPECT_GT(flight.vertical_radius_rad, 0.0);
}

TEST(SunLight, LimbDarkeningIsNormalised) {
    glm::dvec3 mean(0.0);
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        mean += limb_darkening(std::sqrt((i + 0.5) / n)) / double(n);
    }
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(mean[k], 1.0, 1e-4);
    }
    EXPECT_GT(limb_darkening(0.9).x, limb_darkening(0.9).z); // redder towards the limb
    // Neckel and Labs 1994 at 550 nm: half way out 0.92 of the centre, at 0.9 0.67.
    EXPECT_NEAR(limb_darkening(0.5).y / limb_darkening(0.0).y, 0.92, 0.02);
    EXPECT_NEAR(limb_darkening(0.9).y / limb_darkening(0.0).y, 0.67, 0.03);
}

// Against summing the darkened disc point by point.
TEST(SunLight, VisibleFractionOfTheDarkenedDisc) {
    for (double u : {-0.9, -0.3, 0.0, 0.5, 0.95}) {
        glm::dvec3 seen(0.0);
        glm::dvec3 all(0.0);
        const int n = 600;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                const double x = (2.0 * i + 1.0) / n - 1.0;
                const double y = (2.0 * j + 1.0) / n - 1.0;
                const double r = std::hypot(x, y);
                if (r < 1.0) {
                    all += limb_darkening(r);
                    seen += y > -u ? limb_darkening(r) : glm::dvec3(0.0);
                }
            }
        }
        const glm::dvec3 got = visible_sun_fraction(u * sun_radius, sun_radius);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(got[k], seen[k] / all[k], 2e-3) << u;
        }
    }
    EXPECT_EQ(visible_sun_fraction(sun_radius, sun_radius), glm::dvec3(1.0));
    EXPECT_EQ(visible_sun_fraction(-sun_radius, sun_radius), glm::dvec3(0.0));
}

TEST(SunLight, SlantColumnIsKastensAtTheSea) {
    for (double altitude : {0.0, 1.0, 10.0, 45.0, 90.0}) {
        const SlantColumn c = slant_column(altitude * degree_rad, 0.0);
        const double m = relative_optical_length(altitude * degree_rad);
        for (double amount : {c.molecules, c.aerosol, c.ozone, c.water}) {
            EXPECT_NEAR(amount / m, 1.0, 1e-12);
        }
    }
    // Straight up the exponentials.
    const SlantColumn up = slant_column(0.5 * pi, 8000.0);
    EXPECT_NEAR(up.molecules, std::exp(-1.0), 2e-3);
    EXPECT_NEAR(up.aerosol, std::exp(-6.4), 1e-4);
}

// Against a march through the spherical shell, rays from aloft that dip towards the ground among them; both relative to
// the vertical column over the sea.
TEST(SunLight, SlantColumnAgainstAMarch) {
    const double radius = 6371e3;
    for (double height : {3e3, 12e3, 40e3}) {
        const double horizon = horizon_altitude_rad(height);
        for (double altitude : {horizon, 0.5 * horizon, 0.0, 3.0 * degree_rad, 30.0 * degree_rad}) {
            double sum = 0.0;
            const double step = 500.0;
            for (double s = 0.5 * step; s < 2.5e6; s += step) {
                const double h =
                    std::hypot((radius + height) * std::cos(altitude), (radius + height) * std::sin(altitude) + s) -
                    radius;
                sum += std::exp(-h / 8000.0) * step / 8000.0;
            }
            // Kasten's air, with its temperatures, is not this one: 36.5 against 35.4 at the horizon.
            EXPECT_NEAR(slant_column(altitude, height).molecules / sum, 1.0, 0.06)
                << height << ' ' << altitude / degree_rad;
        }
    }
}

TEST(SunLight, MoreLightWithHeight) {
    for (double altitude : {0.5, 5.0, 40.0, 90.0}) {
        glm::dvec3 before(0.0);
        for (double height : {0.0, 1.0, 100.0, 1000.0, 3000.0, 8000.0, 12e3, 20e3, 40e3, 80e3}) {
            AirColumn air = clear;
            air.observer_height_m = height;
            const glm::dvec3 now = sun_illuminance_lux(altitude * degree_rad, sun_radius, 1.0, air);
            EXPECT_GE(luminance(now), luminance(before)) << altitude << ' ' << height;
            if (height == 1.0) {
                EXPECT_NEAR(luminance(now) / luminance(before), 1.0, 1e-2); // no step off the ground
            }
            before = now;
        }
        EXPECT_GT(luminance(before), 0.97 * solar_illuminance_constant_lux);
    }
    // From a flight the sun is up when it has set below: 12 km see 3.5 degrees below the horizontal, and refraction.
    AirColumn flight = clear;
    flight.observer_height_m = 12e3;
    EXPECT_GT(luminance(sun_illuminance_lux(-3.5 * degree_rad, sun_radius, 1.0, flight)), 0.0);
    EXPECT_EQ(luminance(sun_illuminance_lux(-5.5 * degree_rad, sun_radius, 1.0, flight)), 0.0);
}

TEST(SunLight, SetsSmoothlyAtEveryHeight) {
    for (double height : {0.0, 2000.0, 12e3, 80e3}) {
        AirColumn air = clear;
        air.observer_height_m = height;
        const auto lux = [&](double altitude_deg) {
            return luminance(sun_illuminance_lux(altitude_deg * degree_rad, sun_radius, 1.0, air));
        };
        const double high = lux(3.0);
        double before = high;
        for (double altitude = 3.0; altitude > -13.0; altitude -= 0.005) {
            const double now = lux(altitude);
            EXPECT_LE(now, before * (1.0 + 1e-9)) << height << ' ' << altitude;
            EXPECT_LT(before - now, high * 0.03) << height << ' ' << altitude; // of 0.53 degrees, a hundredth a step
            before = now;
        }
        EXPECT_EQ(before, 0.0);
    }
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
