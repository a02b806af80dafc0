#include <alpenglow/ephemeris/course.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include <cmath>
#include <random>
#include <string>

#include <erfa.h>
#include <gtest/gtest.h>

namespace alpenglow::ephemeris {
namespace {

double must(const Result<double>& r) {
    EXPECT_TRUE(r.has_value()) << (r ? "" : r.error().message());
    return r ? *r : std::nan("");
}

TEST(Time, RangeConstantsAreTheBordersOfTheYears) {
    EXPECT_EQ(must(utc_from_calendar({min_year, 1, 1, 0, 0, 0.0})), min_utc_j2000_s);
    EXPECT_EQ(must(utc_from_calendar({max_year, 12, 31, 23, 59, 59.0})) + 1.0, max_utc_j2000_s);
    EXPECT_EQ(must(utc_from_calendar({2000, 1, 1, 12, 0, 0.0})), 0.0);
}

// Oracle: eraCal2jd is proleptic Gregorian too.
TEST(Time, JulianDateRoundTripOverAllYears) {
    for (double utc = min_utc_j2000_s; utc < max_utc_j2000_s; utc += 17.0 * day_s + 12345.0) {
        const CalendarTime c = calendar_from_utc(utc);
        ASSERT_EQ(must(utc_from_calendar(c)), utc) << format_time(utc);
        ASSERT_NEAR(utc_from_julian_date(julian_date(utc)), utc, 1e-4);
        double jd0 = 0.0;
        double mjd = 0.0;
        ASSERT_EQ(eraCal2jd(c.year, c.month, c.day, &jd0, &mjd), 0);
        const double fraction = (3600.0 * c.hour + 60.0 * c.minute + c.second) / day_s;
        ASSERT_NEAR(julian_date(utc), jd0 + mjd + fraction, 1e-9);
    }
}

TEST(Time, CourseJulianDateAgreesAfter1582) {
    for (int year = 1583; year <= 2999; year += 7) {
        for (int month = 1; month <= 12; ++month) {
            double jd0 = 0.0;
            double mjd = 0.0;
            eraCal2jd(year, month, 28, &jd0, &mjd);
            ASSERT_NEAR(course::julian_date(year, month, 28, 18, 30, 36.0), jd0 + mjd + 66636.0 / day_s, 2e-9);
        }
    }
}

TEST(Time, LeapDay) {
    for (const int year : {-4, 0, 1600, 1996, 2000, 2024, 2400}) {
        EXPECT_TRUE(utc_from_calendar({year, 2, 29, 0, 0, 0.0})) << year;
        EXPECT_EQ(must(utc_from_calendar({year, 3, 1, 0, 0, 0.0})) - must(utc_from_calendar({year, 2, 28, 0, 0, 0.0})),
                  2.0 * day_s);
    }
    for (const int year : {-1900, 1700, 1900, 2023, 2100}) {
        EXPECT_FALSE(utc_from_calendar({year, 2, 29, 0, 0, 0.0})) << year;
    }
}

// The calendar is proleptic: 4 and 15 October 1582 are eleven days apart, and the days between exist.
TEST(Time, October1582IsProlepticGregorian) {
    EXPECT_EQ(must(parse_time("1582-10-15")) - must(parse_time("1582-10-04")), 11.0 * day_s);
    EXPECT_EQ(julian_date(must(parse_time("1582-10-15"))), 2299160.5);
}

TEST(Time, ParsesIso8601) {
    const double expected = must(utc_from_calendar({2026, 6, 21, 5, 30, 0.0}));
    for (const char* text : {"2026-06-21T05:30:00Z", "2026-06-21 05:30", "2026-06-21T05:30", "2026-06-21T07:30+02:00",
                             "2026-06-21T07:30:00.000+0200", "2026-06-21T02:00:00-03:30", "2026-06-21t05:30z",
                             "+2026-06-21T07:30+02", "2026-06-20T23:30-06"}) {
        EXPECT_EQ(must(parse_time(text)), expected) << text;
    }
    EXPECT_EQ(must(parse_time("2026-06-21")), expected - 19800.0);
    EXPECT_NEAR(must(parse_time("2026-06-21T05:30:00.125Z")), expected + 0.125, 1e-7);
    EXPECT_NEAR(must(parse_time("-0044-03-15T12:00:00Z")), must(utc_from_calendar({-44, 3, 15, 12, 0, 0.0})), 0.0);
}

TEST(Time, RefusesWithFieldValueAndExpectation) {
    const auto message = [](const char* text) {
        const Result<double> r = parse_time(text, "scene.json: time.utc");
        return r ? std::string("accepted") : r.error().message();
    };
    EXPECT_EQ(message("-5000-01-01"), "scene.json: time.utc: year is -5000 (expected a year from -1999 to 3000)");
    EXPECT_EQ(message("10000-01-01T00:00:00Z"),
              "scene.json: time.utc: year is 10000 (expected a year from -1999 to 3000)");
    EXPECT_EQ(message("2026-13-01"), "scene.json: time.utc: month is 13 (expected 1 to 12)");
    EXPECT_EQ(message("2026-02-29"), "scene.json: time.utc: day is 29 (expected 1 to 28 in that month)");
    EXPECT_NE(message("2026-02-10T24:00").find("hour is 24"), std::string::npos);
    EXPECT_NE(message("2026-02-10T23:60").find("minute is 60"), std::string::npos);
    EXPECT_NE(message("2016-12-31T23:59:60Z").find("leap seconds"), std::string::npos);
    EXPECT_NE(message("-1999-01-01T00:00+01:00").find("out of range"), std::string::npos);
    for (const char* text : {"", "junk", "2026", "2026-6-21", "2026-06-21T", "2026-06-21T05",
                             "2026-06-21T05:30:", "2026-06-21T05:30:00.Z", "2026-06-21T05:30Zx", "2026-06-21T05:30+99",
                             "2026-06-21  05:30", "999999999999-01-01", "--2026-01-01", "nan"}) {
        EXPECT_NE(message(text).find("is no date (expected ISO 8601"), std::string::npos)
            << text << ": " << message(text);
    }
    EXPECT_FALSE(utc_from_calendar({2026, 1, 1, 0, 0, std::nan("")}));
}

TEST(Time, FormatCarriesRoundingAndParsesBack) {
    const double midnight = must(parse_time("2027-01-01"));
    EXPECT_EQ(format_time(midnight - 0.0004, 3), "2027-01-01T00:00:00.000Z");
    EXPECT_EQ(format_time(midnight - 0.0006, 3), "2026-12-31T23:59:59.999Z");
    EXPECT_EQ(format_time(must(parse_time("-0044-03-15T12:00:00Z"))), "-0044-03-15T12:00:00Z");
    EXPECT_EQ(format_time(std::nextafter(max_utc_j2000_s, 0.0)), "3000-12-31T23:59:59Z");
    std::mt19937 random(7);
    std::uniform_real_distribution<double> pick(min_utc_j2000_s + 1.0, max_utc_j2000_s - 1.0);
    for (int i = 0; i < 20000; ++i) {
        const double utc = pick(random);
        ASSERT_NEAR(must(parse_time(format_time(utc, 3))), utc, 5.3e-4) << format_time(utc, 3);
    }
}

// TT - UTC is known exactly since 1972, and leap seconds keep UT1 within 0.9 s of UTC.
TEST(Time, DeltaTFollowsTheLeapSeconds) {
    double worst = 0.0;
    for (int year = 1972; year <= 2025; ++year) {
        for (int month = 1; month <= 12; ++month) {
            double tai_utc = 0.0;
            ASSERT_GE(eraDat(year, month, 15, 0.0, &tai_utc), 0);
            const double utc = must(utc_from_calendar({year, month, 15, 0, 0, 0.0}));
            worst = std::max(worst, std::abs(32.184 + tai_utc - delta_t_s(utc)));
        }
    }
    EXPECT_LE(worst, 0.95);
    RecordProperty("worst_ut1_utc_s", std::to_string(worst));
}

// The table that Espenak & Meeus print beside their polynomials (years, seconds, one standard error).
TEST(Time, DeltaTMatchesThePrintedTable) {
    constexpr double table[][3] = {{-500, 17190, 430}, {0, 10580, 260}, {500, 5710, 140},  {1000, 1570, 55},
                                   {1500, 200, 20},    {1600, 120, 20}, {1700, 9, 5},      {1800, 14, 1},
                                   {1900, -3, 1},      {1950, 29, 0.1}, {1970, 40.2, 0.1}, {2000, 63.8, 0.1}};
    for (const auto& [year, seconds, sigma] : table) {
        EXPECT_NEAR(delta_t_s(must(utc_from_calendar({static_cast<int>(year), 1, 1, 0, 0, 0.0}))), seconds,
                    std::max(sigma, 0.5))
            << year;
    }
}

// Pieces join: no jump of more than 1 s after 1600 (15 arcseconds of the Earth's rotation), 30 s before.
TEST(Time, DeltaTIsContinuous) {
    for (int year = min_year + 1; year <= max_year; ++year) {
        const double utc = must(utc_from_calendar({year, 1, 1, 0, 0, 0.0}));
        double jump = 0.0;
        for (double s = -3.0; s < 3.0; s += 0.25) {
            jump = std::max(jump, std::abs(delta_t_s(utc + (s + 0.25) * day_s) - delta_t_s(utc + s * day_s)));
        }
        EXPECT_LE(jump, year > 1600 ? 1.0 : 30.0) << year;
    }
}

} // namespace
} // namespace alpenglow::ephemeris
