#include <alpenglow/ephemeris/course.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/refraction.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include <alpenglow/core/constants.hpp>

#include "erfa_reference.hpp"

#include <algorithm>
#include <cmath>

#include <erfa.h>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

namespace alpenglow::ephemeris {
namespace {

using test::from_rows;

double largest_difference(const glm::dmat3& a, const glm::dmat3& b) {
    double worst = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            worst = std::max(worst, std::abs(a[i][j] - b[i][j]));
        }
    }
    return worst;
}

TEST(Frames, PrecessionAndObliquityAgreeWithErfa) {
    for (double t = -5.0; t <= 5.0; t += 0.25) {
        double rb[3][3];
        double rp[3][3];
        double rbp[3][3];
        eraBp06(2451545.0, 36525.0 * t, rb, rp, rbp);
        EXPECT_LT(largest_difference(date_from_j2000(t), from_rows(rp)), 1e-8) << t;
        EXPECT_NEAR(mean_obliquity_rad(t), eraObl06(2451545.0, 36525.0 * t), 1e-12);
    }
}

TEST(Frames, SiderealTimeAgreesWithErfa) {
    for (double days = -36525.0; days <= 36525.0; days += 173.37) {
        const double gmst = eraGmst06(2451545.0, days, 2451545.0, days + 65.0 / 86400.0);
        const double ours = greenwich_mean_sidereal_time_rad(days * day_s, days * day_s + 65.0);
        ASSERT_LT(std::abs(std::remainder(gmst - ours, two_pi)), 1e-9);
        ASSERT_GE(ours, 0.0);
        ASSERT_LT(ours, two_pi);
    }
}

TEST(Frames, NutationStaysWithinItsBound) {
    double worst = 0.0;
    for (double t = -1.0; t <= 1.0; t += 0.00037) {
        double dpsi = 0.0;
        double deps = 0.0;
        eraNut06a(2451545.0, 36525.0 * t, &dpsi, &deps);
        const Nutation n = nutation(t);
        worst = std::max({worst, std::abs(n.longitude_rad - dpsi), std::abs(n.obliquity_rad - deps)});
    }
    EXPECT_LT(worst / arcsecond_rad, 0.15);
}

TEST(Frames, CelestialPoleStandsAsHighAsTheLatitude) {
    for (const double latitude : {-90.0, -47.0, 0.0, 31.5, 90.0}) {
        const glm::dmat3 m = local_from_equatorial_of_date(latitude * degree_rad, 1.234);
        const Horizontal pole = horizontal_from_local(m * glm::dvec3(0.0, 0.0, 1.0));
        EXPECT_NEAR(pole.altitude_rad, latitude * degree_rad, 1e-15);
        EXPECT_LT(largest_difference(glm::transpose(m) * m, glm::dmat3(1.0)), 1e-15);
        EXPECT_NEAR(glm::determinant(m), 1.0, 1e-15);
    }
}

TEST(Frames, CourseMatricesAreTheSameRotation) {
    for (double latitude = -1.5; latitude <= 1.5; latitude += 0.3) {
        for (double lmst = 0.0; lmst < 6.0; lmst += 0.5) {
            EXPECT_LT(largest_difference(course::local_from_horizon() * course::horizon_from_equatorial(latitude, lmst),
                                         local_from_equatorial_of_date(latitude, lmst)),
                      1e-15);
        }
    }
}

TEST(Frames, CoursePrecessionWithinTenArcsecondsOver1900To2100) {
    for (double t = -1.0; t <= 1.0; t += 0.1) {
        EXPECT_LT(largest_difference(course::precession(t), date_from_j2000(t)), 10.0 * arcsecond_rad) << t;
        EXPECT_NEAR(course::obliquity(t), mean_obliquity_rad(t), 0.2 * arcsecond_rad);
    }
}

TEST(Frames, ObserverStandsOnTheEllipsoid) {
    for (double latitude = -90.0; latitude <= 90.0; latitude += 7.5) {
        for (const double height : {-400.0, 0.0, 8848.0}) {
            const glm::dvec3 expected = test::erfa_observer_local_m(latitude * degree_rad, 0.7, height);
            EXPECT_LT(glm::length(observer_in_local_m(latitude * degree_rad, height) - expected), 1e-6);
        }
    }
}

TEST(Frames, AzimuthRunsFromNorthThroughEast) {
    EXPECT_NEAR(horizontal_from_local({0.0, 1.0, 0.0}).azimuth_rad, 0.0, 1e-15);
    EXPECT_NEAR(horizontal_from_local({1.0, 0.0, 0.0}).azimuth_rad, 0.5 * pi, 1e-15);
    EXPECT_NEAR(horizontal_from_local({0.0, -1.0, 0.0}).azimuth_rad, pi, 1e-15);
    EXPECT_NEAR(horizontal_from_local({-1.0, 0.0, 0.0}).azimuth_rad, 1.5 * pi, 1e-15);
    EXPECT_EQ(horizontal_from_local({0.0, 0.0, 1.0}).azimuth_rad, 0.0);
    for (double az = 0.1; az < two_pi; az += 0.4) {
        for (double alt = -1.5; alt <= 1.5; alt += 0.25) {
            const Horizontal h = horizontal_from_local(local_from_horizontal({az, alt}));
            EXPECT_NEAR(h.azimuth_rad, az, 1e-13);
            EXPECT_NEAR(h.altitude_rad, alt, 1e-13);
        }
    }
}

// eraRefco's A tan z + B tan^3 z is good above 15 degrees or so; Bennett is stated to 0.1 arcminute.
TEST(Refraction, AgreesWithErfaHighUp) {
    double a = 0.0;
    double b = 0.0;
    eraRefco(1010.0, 10.0, 0.0, 0.574, &a, &b);
    for (double altitude = 15.0; altitude < 90.0; altitude += 1.0) {
        const double tz = std::tan((90.0 - altitude) * degree_rad); // of the apparent place
        EXPECT_NEAR(refraction_from_apparent_rad(altitude * degree_rad), a * tz + b * tz * tz * tz, 6.0 * arcsecond_rad)
            << altitude;
    }
}

TEST(Refraction, HorizonZenithNadirAndInverse) {
    const double arcminute = degree_rad / 60.0;
    EXPECT_NEAR(refraction_from_apparent_rad(0.0), 34.5 * arcminute, 0.5 * arcminute);
    EXPECT_NEAR(refraction_from_true_rad(0.0), 29.0 * arcminute, 0.5 * arcminute);
    EXPECT_NEAR(refraction_from_true_rad(0.5 * pi), 0.0, 0.001 * arcminute);
    EXPECT_EQ(refraction_from_true_rad(-0.5 * pi), 0.0);
    EXPECT_NEAR(refraction_from_true_rad(0.0, 505.0, 10.0), 0.5 * refraction_from_true_rad(0.0), 1e-12);
    for (double altitude = 0.0; altitude <= 90.0; altitude += 0.5) {
        const double apparent = altitude * degree_rad + refraction_from_true_rad(altitude * degree_rad);
        EXPECT_NEAR(apparent - refraction_from_apparent_rad(apparent), altitude * degree_rad, 0.15 * arcminute);
    }
}

TEST(Refraction, LiftedAltitudeIsContinuousAndIncreasingEverywhere) {
    double before = -0.5 * pi + refraction_from_true_rad(-0.5 * pi);
    const double step = 0.001 * degree_rad;
    for (double h = -0.5 * pi + step; h <= 0.5 * pi; h += step) {
        const double lifted = h + refraction_from_true_rad(h);
        ASSERT_GT(lifted, before) << h / degree_rad;
        ASSERT_LT(lifted - before, 3.0 * step) << h / degree_rad;
        before = lifted;
    }
}

} // namespace
} // namespace alpenglow::ephemeris
