// Floating-point traps on: every domain to its ends and past them.
#include <alpenglow/ephemeris/celestial.hpp>
#include <alpenglow/ephemeris/course.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/refraction.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include <alpenglow/core/constants.hpp>

#include "fp_traps.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::ephemeris {
namespace {

using EphemerisStress = test::StressTest;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

void expect_sane(const CelestialState& s) {
    for (const glm::vec3& v : {s.to_sun, s.to_moon}) {
        ASSERT_NEAR(glm::length(v), 1.0F, 2e-7F);
    }
    for (const glm::dmat3& m : {s.local_from_equatorial, s.local_from_moon}) {
        for (int i = 0; i < 3; ++i) {
            ASSERT_NEAR(glm::length(m[i]), 1.0, 1e-14);
            ASSERT_NEAR(glm::dot(m[i], m[(i + 1) % 3]), 0.0, 1e-14);
        }
    }
    ASSERT_GT(s.sun_distance_m, 1.46e11);
    ASSERT_LT(s.sun_distance_m, 1.53e11);
    ASSERT_GT(s.moon_distance_m, 3.45e8);
    ASSERT_LT(s.moon_distance_m, 4.16e8);
    ASSERT_GE(s.moon_illuminated_fraction, 0.0F);
    ASSERT_LE(s.moon_illuminated_fraction, 1.0F);
    ASSERT_GE(s.moon_phase_angle_rad, 0.0F);
    ASSERT_LE(s.moon_phase_angle_rad, static_cast<float>(pi));
}

TEST_F(EphemerisStress, EveryPlaceAndAllFiveThousandYears) {
    const double last = std::nextafter(max_utc_j2000_s, 0.0);
    for (double latitude : {-0.5 * pi, std::nextafter(-0.5 * pi, 0.0), -1e-300, 0.0, 0.3, 0.5 * pi}) {
        for (double longitude : {-two_pi, -pi, 0.0, pi, two_pi}) {
            for (double height : {min_height_m, 0.0, max_height_m}) {
                for (int i = 0; i <= 100; ++i) {
                    const double utc =
                        i == 100 ? last : min_utc_j2000_s + (max_utc_j2000_s - min_utc_j2000_s) * 0.01 * i;
                    const Observer observer{latitude, longitude, height};
                    ASSERT_TRUE(inputs_valid(observer, {.utc_j2000_s = utc}));
                    expect_sane(evaluate(observer, utc, delta_t_s(utc)));
                }
            }
        }
    }
}

TEST_F(EphemerisStress, BadInputsAreRefusedQuietly) {
    for (const double bad : {not_a_number, infinity, -infinity, 1e308, -1e308}) {
        EXPECT_FALSE(inputs_valid({.latitude_rad = bad}, {}));
        EXPECT_FALSE(inputs_valid({.longitude_rad = bad}, {}));
        EXPECT_FALSE(inputs_valid({.height_m = bad}, {}));
        EXPECT_FALSE(inputs_valid({}, {.utc_j2000_s = bad}));
        EXPECT_FALSE(check_inputs({}, {.utc_j2000_s = bad}));
        EXPECT_FALSE(check_inputs({.latitude_rad = bad}, {}));
        EXPECT_FALSE(in_range(bad));
        EXPECT_FALSE(utc_from_calendar({2026, 1, 1, 0, 0, bad}));
    }
    EXPECT_FALSE(inputs_valid({}, {.delta_t_s = infinity}));
    EXPECT_FALSE(in_range(max_utc_j2000_s));
    EXPECT_FALSE(in_range(std::nextafter(min_utc_j2000_s, -infinity)));
}

TEST_F(EphemerisStress, RefractionFarPastItsDomain) {
    for (double h : {-1e300, -100.0, -0.5 * pi, -1.0 * degree_rad, -4.4 * degree_rad, -5.11 * degree_rad, 0.0, 0.5 * pi,
                     100.0, 1e300}) {
        for (const double pressure : {0.0, 300.0, 1100.0}) {
            const double r = refraction_from_true_rad(h, pressure, -40.0);
            const double s = refraction_from_apparent_rad(h, pressure, -40.0);
            EXPECT_GE(r, 0.0);
            EXPECT_GE(s, 0.0);
            EXPECT_LT(r, 0.03);
            EXPECT_LT(s, 0.03);
        }
    }
}

TEST_F(EphemerisStress, HorizontalOfDegenerateDirections) {
    EXPECT_EQ(horizontal_from_local({0.0, 0.0, 0.0}).altitude_rad, 0.0);
    EXPECT_NEAR(horizontal_from_local({1e-300, 0.0, 1e-300}).altitude_rad, 0.25 * pi, 1e-12);
    EXPECT_EQ(horizontal_from_local({0.0, 0.0, -1.0}).altitude_rad, -0.5 * pi);
    EXPECT_EQ(angle_between({1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}), 0.0);
    EXPECT_EQ(angle_between({1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}), pi);
    EXPECT_NEAR(angle_between({1.0, 0.0, 0.0}, {1.0, 1e-12, 0.0}), 1e-12, 1e-20);
}

TEST_F(EphemerisStress, ParserTakesAnyBytes) {
    std::mt19937 random(5);
    const std::string alphabet = "0123456789-+:.,TZtz \t\n\0x/";
    std::uniform_int_distribution<std::size_t> letter(0, alphabet.size() - 1);
    std::uniform_int_distribution<std::size_t> length(0, 40);
    std::uniform_int_distribution<std::size_t> place(0, 25);
    int accepted = 0;
    for (int i = 0; i < 200000; ++i) {
        std::string text;
        if (i % 2 == 0) {
            for (std::size_t n = length(random); n > 0; --n) {
                text += alphabet[letter(random)];
            }
        } else {
            text = "2026-06-21T05:30:00.5+02:00";
            text[place(random)] = alphabet[letter(random)];
            text[place(random)] = alphabet[letter(random)];
        }
        const Result<double> r = parse_time(text);
        if (r) {
            ++accepted;
            ASSERT_TRUE(in_range(*r)) << text;
            ASSERT_NEAR(*parse_time(format_time(*r, 6)), *r, 2e-5) << text;
        } else {
            ASSERT_FALSE(r.error().message().empty());
        }
    }
    EXPECT_GT(accepted, 100);
}

TEST_F(EphemerisStress, CourseSeriesStayFiniteFarFromTheirCenturies) {
    for (const double t : {-1e6, -50.0, 0.0, 50.0, 1e6}) {
        const course::HorizonPositions p = course::horizon_positions(t, t, 0.5 * pi, pi);
        EXPECT_TRUE(std::isfinite(glm::length(p.sun)) && std::isfinite(glm::length(p.moon)));
    }
}

} // namespace
} // namespace alpenglow::ephemeris
