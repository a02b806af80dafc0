#include <alpenglow/ephemeris/geocentric_cache.hpp>

#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include "fp_traps.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

namespace alpenglow::ephemeris {
namespace {

double difference(const Geocentric& a, const Geocentric& b) {
    double worst = std::max(angle_between(a.sun_m, b.sun_m), angle_between(a.moon_m, b.moon_m));
    worst = std::max(worst, std::abs(a.equation_of_equinoxes_rad - b.equation_of_equinoxes_rad));
    for (int axis = 0; axis < 3; ++axis) {
        worst = std::max({worst, angle_between(a.equatorial_from_moon[axis], b.equatorial_from_moon[axis]),
                          angle_between(a.true_from_j2000[axis], b.true_from_j2000[axis])});
    }
    return worst;
}

TEST(GeocentricCache, StaysWithinItsBoundOfTheSeries) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    double worst = 0.0;
    double distance = 0.0;
    for (int i = 0; i < 10000; ++i) {
        // A third over all years, the rest over 1900 to 2100; a span's end is where a cubic is worst.
        const double tt = i % 3 == 0 ? min_utc_j2000_s + (max_utc_j2000_s - min_utc_j2000_s) * unit(random)
                                     : century_s * (2.0 * unit(random) - 1.0);
        const double at_end =
            (std::floor(tt / GeocentricCache::span_s) + (i % 2 == 0 ? 0.0 : unit(random))) * GeocentricCache::span_s;
        GeocentricCache cache;
        const Geocentric exact = geocentric(julian_centuries(at_end));
        const Geocentric cubic = cache.at(at_end);
        worst = std::max(worst, difference(exact, cubic));
        distance = std::max(distance, std::abs(glm::length(exact.moon_m) - glm::length(cubic.moon_m)));
    }
    EXPECT_LT(worst, GeocentricCache::max_error_rad);
    EXPECT_GT(worst, 0.1 * GeocentricCache::max_error_rad); // the bound is not idle
    EXPECT_LT(distance, 10.0);
}

TEST(GeocentricCache, FillsOncePerSpan) {
    GeocentricCache cache;
    const double begin = 1234.0 * GeocentricCache::span_s;
    for (double s = 0.0; s < 3.0 * GeocentricCache::span_s; s += 60.0) {
        (void)cache.at(begin + s);
    }
    EXPECT_EQ(cache.fills(), 3U);
    (void)cache.at(begin);
    EXPECT_EQ(cache.fills(), 3U);
}

// Same instant, same bits, whatever was asked before.
TEST(GeocentricCache, DoesNotDependOnHistory) {
    GeocentricCache used;
    for (double tt = -1e9; tt < 1e9; tt += 3.3e6) {
        (void)used.at(0.7 * tt);
        GeocentricCache fresh;
        const Geocentric a = used.at(tt);
        const Geocentric b = fresh.at(tt);
        ASSERT_EQ(a.sun_m, b.sun_m);
        ASSERT_EQ(a.moon_m, b.moon_m);
        ASSERT_EQ(a.equatorial_from_moon, b.equatorial_from_moon);
        ASSERT_EQ(a.true_from_j2000, b.true_from_j2000);
    }
}

using GeocentricCacheStress = test::StressTest;

TEST_F(GeocentricCacheStress, EndsOfTimeAndBordersOfSpans) {
    GeocentricCache cache;
    for (const double tt : {min_utc_j2000_s, max_utc_j2000_s + 1e6, 0.0, -0.0, -1e-9, 1e-9, GeocentricCache::span_s,
                            -GeocentricCache::span_s, std::nextafter(GeocentricCache::span_s, 0.0)}) {
        const Geocentric g = cache.at(tt);
        EXPECT_LT(difference(g, geocentric(julian_centuries(tt))), GeocentricCache::max_error_rad) << tt;
        EXPECT_NEAR(glm::length(g.equatorial_from_moon[1]), 1.0, 1e-14);
    }
}

} // namespace
} // namespace alpenglow::ephemeris
